// Intervals, posteriors and false discoveries against R 4.2 and exact tails. The R command stands beside each
// number.
#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include "analysis/cell_statistics.h"
#include "analysis/probability.h"
#include "base/error.h"
#include "base/random.h"

namespace equilux::tests {
namespace {

struct FromR {
  Count count;
  Interval clopper_pearson;  ///< binom.test(k, n)$conf.int
  Interval jeffreys;         ///< qbeta(c(.025, .975), k + .5, n - k + .5), its end 0 or 1 where k is 0 or n
  double p_guess;            ///< binom.test(k, n, alternative = "greater")$p.value
  double over;               ///< 1 - pbeta(.75, k + .5, n - k + .5)
};

const FromR kFromR[] = {
    {{0, 12}, {0, 0.26464846939705111}, {0, 0.1853059383124851}, 1, 5.3719314552225228e-09},
    {{5, 12},
     {0.1516522298084301, 0.72333031431789419},
     {0.1804786947897016, 0.68805957495988035},
     0.80615234375,
     0.0065429068836482251},
    {{9, 12},
     {0.42814153812181088, 0.94513935547200723},
     {0.47080891637344924, 0.92405767108051517},
     299.0 / 4096,
     0.47681670266588916},
    {{12, 12}, {0.73535153060294889, 1}, {0.81469406168751479, 1}, 1.0 / 4096, 0.99208726164199423},
    {{11, 14},
     {0.49202432295152815, 0.95342071211013268},
     {0.53097633290645396, 0.93566492246177746},
     470.0 / 16384,
     0.60142068129679327},
    {{7, 14},
     {0.23036054144806237, 0.76963945855193761},
     {0.25892699154983373, 0.74107300845016622},
     0.604736328125,
     0.020484477977918081},
    {{0, 1}, {0, 0.975}, {0, 0.85325368369042476}, 1, 0.057668885622437327},
    {{1, 1}, {0.025, 1}, {0.14674631630957513, 1}, 0.5, 0.60899778104422952},
    {{75, 100},
     {0.65344750424119169, 0.83122026190065812},
     {0.65884868888715276, 0.82692021008651129},
     2.8181410171027107e-07,
     0.49227655268021686}};

constexpr double kAgreement = 1e-9;  ///< relative; R and Boost stop their root finding elsewhere

void expect_near(double value, double expected) {
  EXPECT_NEAR(value, expected, kAgreement * std::max(std::abs(expected), 1e-300));
}

void expect_near(const Interval& value, const Interval& expected) {
  expect_near(value.lower, expected.lower);
  expect_near(value.upper, expected.upper);
}

TEST(Intervals, tails_and_posteriors_are_those_of_R) {
  for (const FromR& row : kFromR) {
    SCOPED_TRACE(fmt::format("{} of {}", row.count.k, row.count.n));
    expect_near(*find_clopper_pearson(row.count), row.clopper_pearson);
    expect_near(*find_jeffreys(row.count), row.jeffreys);
    expect_near(*eval_p_guess(row.count), row.p_guess);
    EXPECT_NEAR(*eval_posterior_over(row.count), row.over, 1e-15 + kAgreement * row.over);
  }
}

// p.adjust(c(.0730, .0002, .5, .0193, .0193, 1, .003, .0730), "BH"): with two ties.
TEST(FalseDiscovery, rates_are_those_of_Rs_p_adjust) {
  const auto q = adjust_false_discovery({0.0730, 0.0002, 0.5, 0.0193, 0.0193, 1, 0.003, 0.0730});
  const std::array<double, 8> expected = {
      0.097333333333333327, 0.0016, 0.5714285714285714, 0.0386, 0.0386, 1, 0.012, 0.097333333333333327};
  for (std::size_t i = 0; i < expected.size(); ++i) expect_near(q[i], expected[i]);
}

TEST(FalseDiscovery, rates_of_none_one_and_equal_hypotheses_are_their_own) {
  EXPECT_TRUE(adjust_false_discovery({}).empty());
  EXPECT_EQ(adjust_false_discovery({0.3}), std::vector<double>{0.3});
  EXPECT_EQ(adjust_false_discovery({1, 1, 1}), (std::vector<double>{1, 1, 1}));
  EXPECT_EQ(adjust_false_discovery({0.02, 0.02}), (std::vector<double>{0.02, 0.02}));
}

// By the definition: the smallest rate a at which p_(i) <= i a / m for some i at or above the rank.
TEST(FalseDiscovery, rates_are_the_least_at_which_the_step_up_rule_rejects) {
  RandomStream random(11, "false discovery", 0);
  std::vector<double> p(40);
  for (double& value : p) value = std::pow(random.next_double(), 3);
  const auto q = adjust_false_discovery(p);
  const auto is_rejected = [&](double value, double rate) {
    std::vector<double> sorted = p;
    std::sort(sorted.begin(), sorted.end());
    for (std::size_t i = sorted.size(); i > 0; --i) {
      if (sorted[i - 1] <= static_cast<double>(i) * rate / static_cast<double>(p.size()))
        return value <= sorted[i - 1];
    }
    return false;
  };
  for (std::size_t i = 0; i < p.size(); ++i) {
    EXPECT_TRUE(is_rejected(p[i], q[i] * (1 + 1e-12))) << i;
    EXPECT_FALSE(is_rejected(p[i], q[i] * (1 - 1e-9))) << i;
  }
}

// P(X = k) for X of Bin(n, p), by multiplication alone.
double eval_binomial(std::int64_t k, std::int64_t n, double p) {
  double value = 1;
  for (std::int64_t i = 1; i <= k; ++i) value *= p * static_cast<double>(n - k + i) / static_cast<double>(i);
  return value * std::pow(1 - p, static_cast<double>(n - k));
}

double eval_coverage(std::int64_t n, double p, std::optional<Interval> (*find)(const Count&, double)) {
  double coverage = 0;
  for (std::int64_t k = 0; k <= n; ++k) {
    const Interval interval = *find({k, n}, 0.95);
    if (interval.lower <= p && p <= interval.upper) coverage += eval_binomial(k, n, p);
  }
  return coverage;
}

// Summed over all outcomes, not simulated.
TEST(Intervals, of_clopper_and_pearson_cover_at_least_at_their_level_whatever_the_truth) {
  for (const std::int64_t n : {1, 2, 5, 12, 14, 40}) {
    for (double p = 0.005; p < 1; p += 0.005)
      ASSERT_GE(eval_coverage(n, p, find_clopper_pearson), 0.95 - 1e-12) << n;
  }
}

TEST(Intervals, of_jeffreys_cover_at_their_level_on_average) {
  for (const std::int64_t n : {12, 14, 40}) {
    double sum = 0;
    for (int i = 0; i < 1000; ++i) sum += eval_coverage(n, (i + 0.5) / 1000, find_jeffreys);
    EXPECT_NEAR(sum / 1000, 0.95, 0.005) << n;
  }
}

TEST(Intervals, a_narrower_level_would_not_cover) {
  const auto narrow = [](const Count& count, double) { return find_clopper_pearson(count, 0.80); };
  double least = 1;
  for (double p = 0.005; p < 1; p += 0.005) least = std::min(least, eval_coverage(12, p, narrow));
  EXPECT_LT(least, 0.95) << "the mutant must fail";
}

TEST(Intervals, of_wrong_and_right_are_mirrored) {
  for (std::int64_t n = 1; n <= 60; ++n) {
    for (std::int64_t k = 0; k <= n; ++k) {
      for (const auto& find : {find_clopper_pearson, find_jeffreys}) {
        const Interval interval = *find({k, n}, 0.95), mirrored = *find({n - k, n}, 0.95);
        ASSERT_NEAR(interval.lower, 1 - mirrored.upper, 1e-12) << k << " of " << n;
        ASSERT_GE(interval.lower, 0);
        ASSERT_LE(interval.upper, 1);
        ASSERT_LE(interval.lower, static_cast<double>(k) / static_cast<double>(n));
        ASSERT_GE(interval.upper, static_cast<double>(k) / static_cast<double>(n));
      }
    }
  }
}

Cell make_cell(int level) { return {{{"G1", "MR", Illumination::kIndirect}, 1000}, level, false}; }

// Stiff cases: a status each, every number finite.
TEST(CellStatistics, of_stiff_cells_are_finite_and_say_what_they_are) {
  const Tally tally = {{make_cell(0), {0, 0}},    {make_cell(1), {0, 1}},      {make_cell(2), {1, 1}},
                       {make_cell(3), {0, 12}},   {make_cell(4), {12, 12}},    {make_cell(5), {6, 12}},
                       {make_cell(6), {0, 2000}}, {make_cell(7), {2000, 2000}}};
  const auto statistics = find_cell_statistics(tally);
  const std::vector<std::string> expected = {"untested",  "single", "single",    "all_wrong",
                                             "all_right", "inner",  "all_wrong", "all_right"};
  for (int level = 0; level < 8; ++level) {
    const CellStatistics& row = statistics.at(make_cell(level));
    EXPECT_EQ(format_cell_status(row.status), expected[static_cast<std::size_t>(level)]);
    EXPECT_EQ(row.estimate.has_value(), level > 0);
    if (!row.estimate) continue;
    const CellEstimate& e = *row.estimate;
    for (const double value : {e.proportion, e.clopper_pearson.lower, e.clopper_pearson.upper,
                               e.jeffreys.lower, e.jeffreys.upper, e.p_guess, e.q_guess, e.posterior_over}) {
      EXPECT_TRUE(value >= 0 && value <= 1) << level << ": " << value;
    }
    EXPECT_GE(e.q_guess, e.p_guess);
  }
}

TEST(CellStatistics, of_nobody_asked_have_no_interval_and_no_posterior) {
  EXPECT_FALSE(find_clopper_pearson({0, 0}));
  EXPECT_FALSE(find_jeffreys({0, 0}));
  EXPECT_FALSE(eval_posterior_over({0, 0}));
  EXPECT_THROW(find_jeffreys({3, 2}), CheckFailure);
}

// The cut itself is what the flag says in 99.9 % of draws and more where many were asked.
TEST(CellStatistics, posterior_of_many_answers_is_sure_on_either_side_of_the_cut) {
  EXPECT_GT(*eval_posterior_over({1600, 2000}), 0.999);
  EXPECT_LT(*eval_posterior_over({1400, 2000}), 0.001);
}

// R: pnorm(qt(.025, n - 1) * sqrt(n / (n - 1)))
TEST(Intervals, by_bootstrap_over_few_subjects_reach_as_far_as_students) {
  EXPECT_NEAR(find_bootstrap_tail(12), 0.0107566149, 1e-9);
  EXPECT_NEAR(find_bootstrap_tail(14), 0.0124832552, 1e-9);
  EXPECT_NEAR(find_bootstrap_tail(1000000), 0.025, 1e-6);
  EXPECT_LT(find_bootstrap_tail(2), 1e-6);
  EXPECT_THROW(find_bootstrap_tail(1), CheckFailure);
}

}  // namespace
}  // namespace equilux::tests
