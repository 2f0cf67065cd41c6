// Exact tests of clusters against enumeration, the sign test and counts by hand.
#include "analysis/permutation.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>

#include "base/random.h"

namespace equilux::tests {
namespace {

// One stratum alone: `size` levels, of which `ones` have EE.
Cluster make_single(int size, int ones) {
  Cluster cluster;
  for (int i = 0; i < size; ++i) cluster.levels.push_back({i < ones});
  return cluster;
}

std::vector<Cluster> make_singles(const std::vector<std::pair<int, int>>& strata) {
  std::vector<Cluster> clusters;
  for (const auto& [size, ones] : strata) clusters.push_back(make_single(size, ones));
  return clusters;
}

// R: binom.test(9, 10)$p.value is 22 / 1024; ties, two alike in a pair, tell nothing.
TEST(PermutationTest, of_pairs_is_the_sign_test) {
  std::vector<Cluster> pairs(10, make_single(2, 1));
  EXPECT_DOUBLE_EQ(eval_permutation_p(pairs, 8), 22.0 / 1024);
  for (const int ones : {0, 2, 2}) pairs.push_back(make_single(2, ones));
  EXPECT_DOUBLE_EQ(eval_permutation_p(pairs, 8), 22.0 / 1024);
}

// Three places with one 1 each: S is -2, 0 or 2, equally often.
TEST(PermutationTest, of_triples_is_as_counted_by_hand) {
  EXPECT_DOUBLE_EQ(eval_permutation_p(make_singles({{3, 1}}), 2), 2.0 / 3);
  EXPECT_DOUBLE_EQ(eval_permutation_p(make_singles({{3, 1}, {3, 2}}), 4), 2.0 / 9);
  EXPECT_DOUBLE_EQ(eval_permutation_p(make_singles({{3, 1}, {3, 2}}), 0), 1.0);
}

// Two objects that gain at all three VPL counts: 6 or -6 by the flips of both alike, 0 else. Three pairs of
// one object and one of another: 4, 2, -2, -4.
TEST(PermutationTest, flips_the_pairs_of_an_object_together) {
  const Cluster three{{{false, false, false}, {true, true, true}}}, one{{{false}, {true}}};
  EXPECT_DOUBLE_EQ(eval_permutation_p({three, three}, 6), 0.5);
  EXPECT_DOUBLE_EQ(eval_permutation_p({three, one}, 4), 0.5);
  EXPECT_DOUBLE_EQ(eval_permutation_p({three, one}, 2), 1.0);
}

TEST(PermutationTest, without_anything_that_differs_has_p_one) {
  EXPECT_EQ(eval_permutation_p({}, 0), 1);
  EXPECT_EQ(eval_permutation_p(make_singles({{3, 0}, {3, 3}, {2, 2}}), 0), 1);
}

// One 1 in 24 places is at each equally often: S is 2 place - 23, and |S| >= 21 at four of them. Two 1s in 30
// are at the last two with S = 29 + 27, and of C(30, 2) = 435 orders two are as far from 0.
TEST(PermutationTest, knows_strata_of_any_size) {
  EXPECT_NEAR(eval_permutation_p(make_singles({{24, 1}}), 21), 4.0 / 24, 1e-15);
  EXPECT_NEAR(eval_permutation_p(make_singles({{30, 2}}), 56), 2.0 / 435, 1e-15);
  EXPECT_NEAR(eval_permutation_p(make_singles({{30, 28}}), -56), 2.0 / 435, 1e-15);
}

// By definition: over strata, pairs of levels with both verdicts, the later less the earlier.
std::int64_t eval_statistic(const Cluster& cluster, const std::vector<std::size_t>& order) {
  std::int64_t sum = 0;
  for (std::size_t stratum = 0; stratum < cluster.levels.front().size(); ++stratum) {
    for (std::size_t j = 1; j < order.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i) {
        const auto earlier = cluster.levels[order[i]][stratum], later = cluster.levels[order[j]][stratum];
        if (earlier && later) sum += static_cast<int>(*later) - static_cast<int>(*earlier);
      }
    }
  }
  return sum;
}

std::vector<std::size_t> make_order(std::size_t levels) {
  std::vector<std::size_t> order(levels);
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

// Every order of every cluster.
std::vector<std::int64_t> enumerate_sums(const std::vector<Cluster>& clusters) {
  std::vector<std::int64_t> sums{0};
  for (const Cluster& cluster : clusters) {
    std::vector<std::int64_t> next;
    auto order = make_order(cluster.levels.size());
    do {
      for (const std::int64_t sum : sums) next.push_back(sum + eval_statistic(cluster, order));
    } while (std::next_permutation(order.begin(), order.end()));
    sums = std::move(next);
  }
  return sums;
}

std::int64_t eval_statistic(const std::vector<Cluster>& clusters) {
  std::int64_t sum = 0;
  for (const Cluster& cluster : clusters) sum += eval_statistic(cluster, make_order(cluster.levels.size()));
  return sum;
}

Cluster draw_cluster(RandomStream& random, std::size_t levels, std::size_t strata, bool has_gaps) {
  Cluster cluster;
  for (std::size_t level = 0; level < levels; ++level) {
    cluster.levels.emplace_back(strata);
    for (auto& verdict : cluster.levels.back()) {
      if (has_gaps && random.next_below(4) == 0) continue;
      verdict = random.next_below(2) == 0;
    }
  }
  return cluster;
}

// 100 sets of three clusters, of two to four levels and one to three VPL counts, with and without verdicts
// missing, seed 1: p of what is seen, and of a statistic that no order gives.
TEST(PermutationTest, is_the_share_of_all_orders_that_are_enumerated) {
  RandomStream random(1, "clusters", 0);
  for (int i = 0; i < 100; ++i) {
    std::vector<Cluster> clusters;
    for (int c = 0; c < 3; ++c)
      clusters.push_back(
          draw_cluster(random, 2 + random.next_below(3), 1 + random.next_below(3), i % 2 == 1));
    const auto sums = enumerate_sums(clusters);
    const std::int64_t seen = eval_statistic(clusters);
    const auto far = std::count_if(sums.begin(), sums.end(),
                                   [&](std::int64_t sum) { return std::abs(sum) >= std::abs(seen); });
    EXPECT_NEAR(eval_permutation_p(clusters, seen),
                static_cast<double>(far) / static_cast<double>(sums.size()), 1e-12)
        << i;
    EXPECT_EQ(eval_permutation_p(clusters, 1000), 0);
  }
}

// Every verdict of a place with one, in turn. False once all were tried.
bool turn_verdicts(std::vector<Cluster>& clusters) {
  for (Cluster& cluster : clusters) {
    for (auto& level : cluster.levels) {
      for (auto& verdict : level) {
        if (!verdict) continue;
        verdict = !*verdict;
        if (*verdict) return true;
      }
    }
  }
  return false;
}

double enumerate_least_p(std::vector<Cluster> clusters) {
  double least = 1;
  do {
    least = std::min(least, eval_permutation_p(clusters, eval_statistic(clusters)));
  } while (turn_verdicts(clusters));
  return least;
}

Cluster make_unlike(std::size_t levels, std::size_t strata) {
  return {
      std::vector<std::vector<std::optional<bool>>>(levels, std::vector<std::optional<bool>>(strata, false))};
}

TEST(PermutationTest, has_no_p_below_the_least_one) {
  for (const std::vector<Cluster>& clusters : std::vector<std::vector<Cluster>>{
           {make_unlike(2, 1), make_unlike(2, 1), make_unlike(2, 1), make_unlike(2, 1)},
           {make_unlike(3, 1)},
           {make_unlike(4, 1), make_unlike(3, 1)},
           {make_unlike(5, 1), make_unlike(2, 1)},
           {make_unlike(2, 3), make_unlike(2, 2)},
           {make_unlike(3, 2), make_unlike(2, 2)},
           {make_unlike(4, 2)},
           {make_unlike(4, 3)}})
    EXPECT_NEAR(find_least_p(clusters), enumerate_least_p(clusters), 1e-12) << clusters.size();
  EXPECT_EQ(find_least_p({}), 1);
}

// Of two levels what one lacks the pair lacks; a level without verdicts is none; of three with different gaps
// the least is a bound.
TEST(PermutationTest, has_no_p_below_the_least_one_where_verdicts_are_missing) {
  Cluster pair = make_unlike(2, 3), triple = make_unlike(3, 1), gaps = make_unlike(3, 2);
  pair.levels[1][2].reset();
  triple.levels[1][0].reset();
  gaps.levels[0][1].reset();
  for (const auto& clusters : {std::vector<Cluster>{pair}, std::vector<Cluster>{pair, triple, pair}})
    EXPECT_NEAR(find_least_p(clusters), enumerate_least_p(clusters), 1e-12);
  EXPECT_LE(find_least_p({gaps, pair}), enumerate_least_p({gaps, pair}) + 1e-12);
  pair.levels[0] = {std::nullopt, std::nullopt, true};
  EXPECT_FALSE(has_pairs(pair));
  EXPECT_TRUE(has_pairs(gaps));
  EXPECT_EQ(find_least_p({pair}), 1);
}

// 2,000 studies without a trend, seeds 1..2000, eight objects at three levels: p <= .05 in at most 5 % (exact
// tests are conservative), three standard errors allowed.
TEST(PermutationTest, rejects_no_more_often_than_its_level) {
  int rejected = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    RandomStream random(seed, "no trend", 0);
    std::vector<Cluster> clusters;
    for (int s = 0; s < 8; ++s) clusters.push_back(draw_cluster(random, 3, 1, false));
    rejected += eval_permutation_p(clusters, eval_statistic(clusters)) <= 0.05 ? 1 : 0;
  }
  EXPECT_LE(rejected, 2000 * 0.05 + 3 * std::sqrt(2000 * 0.05 * 0.95));
  EXPECT_GT(rejected, 20) << "a test that never rejects";
}

// 24 pairs of eight objects, unlike, and the same way round at all three VPL counts; which way, a coin says.
// 2,000 studies, seeds 1..2000. All eight the same way is p = 2 / 256, seven is 18 / 256. The mutant takes
// every pair for itself: it rejects from 18 of 24 on, six objects, which are 74 of 256 studies.
TEST(PermutationTest, keeps_its_level_where_the_verdicts_of_an_object_coincide) {
  int rejected = 0, by_pairs = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    RandomStream random(seed, "no trend, coinciding", 0);
    std::vector<Cluster> clusters, pairs;
    for (int object = 0; object < 8; ++object) {
      const bool later = random.next_below(2) == 0;
      const Cluster pair{{{!later}, {later}}};
      Cluster cluster;
      for (const auto& level : pair.levels) cluster.levels.emplace_back(3, level.front());
      clusters.push_back(cluster);
      for (int count = 0; count < 3; ++count) pairs.push_back(pair);
    }
    const std::int64_t statistic = eval_statistic(clusters);
    EXPECT_EQ(statistic, eval_statistic(pairs));
    rejected += eval_permutation_p(clusters, statistic) <= 0.05 ? 1 : 0;
    by_pairs += eval_permutation_p(pairs, statistic) <= 0.05 ? 1 : 0;
  }
  EXPECT_LE(rejected, 2000 * 0.05 + 3 * std::sqrt(2000 * 0.05 * 0.95));
  EXPECT_GT(rejected, 0) << "a test that never rejects";
  EXPECT_NEAR(by_pairs, 2000 * 74.0 / 256, 3 * std::sqrt(2000 * 74.0 / 256 * 182 / 256));
}

}  // namespace
}  // namespace equilux::tests
