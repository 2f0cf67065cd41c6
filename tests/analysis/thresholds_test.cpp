// Every clause of the rules by hand, isotonic regression against brute force, and where the rules agree.
#include "analysis/thresholds.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>

#include "base/error.h"
#include "tests/analysis/columns.h"

namespace equilux::tests {
namespace {

using enum LevelState;

Threshold artifact(const ColumnCounts& counts, Rule rule = Rule::kPaper) {
  return find_threshold(counts, Experiment::kArtifact, rule);
}

Threshold material(const ColumnCounts& counts, Rule rule = Rule::kPaper) {
  return find_threshold(counts, Experiment::kMaterial, rule);
}

std::string states_of(const Threshold& threshold) {
  std::string text;
  for (const LevelState state : threshold.states) {
    text += state == kSame ? '=' : state == kDifferent ? 'x' : '.';
  }
  return text;
}

TEST(ArtifactCut, lies_just_after_the_most_clamped_flagged_level) {
  const auto threshold = artifact(make_window(3, {12, 9, 8, 6}));
  EXPECT_EQ(threshold.cut, 5);
  EXPECT_EQ(threshold.status, CutStatus::kCut);
  EXPECT_EQ(states_of(threshold), "xxxxx======");
}

// Nothing is less clamped than C0, and nothing more than C10.
TEST(Cuts, at_an_end_of_the_scale_lie_beyond_nothing) {
  const auto at_end = [](const Threshold& threshold, Experiment experiment, const ColumnCounts& counts) {
    EXPECT_EQ(describe_status(threshold, experiment, counts) == "end of the scale",
              is_at_scale_end(threshold, experiment, counts));
    return is_at_scale_end(threshold, experiment, counts);
  };
  const auto of_artifacts = [&](const ColumnCounts& counts) {
    return at_end(artifact(counts), Experiment::kArtifact, counts);
  };
  const auto of_material = [&](const ColumnCounts& counts) {
    return at_end(material(counts), Experiment::kMaterial, counts);
  };
  EXPECT_TRUE(of_artifacts(make_window(0, {6, 6, 6, 6})));
  EXPECT_FALSE(of_artifacts(make_window(1, {6, 6, 6, 6})));
  EXPECT_FALSE(of_artifacts(make_window(0, {12, 6, 6, 6})));
  EXPECT_FALSE(of_artifacts(make_window(6, {12, 12, 12, 12}))) << "C10, untested, is beyond";
  EXPECT_FALSE(of_artifacts(make_window(7, {12, 12, 12, 12}))) << "no level is free";
  EXPECT_TRUE(of_material(make_window(7, {6, 6, 6, 6})));
  EXPECT_FALSE(of_material(make_window(6, {6, 6, 6, 6})));
  EXPECT_FALSE(of_material(make_window(7, {6, 6, 6, 12})));
  EXPECT_FALSE(of_material(make_window(7, {12, 12, 12, 12})));
}

TEST(ArtifactCut, with_nothing_flagged_is_the_windows_first_level_and_censored_low) {
  const auto threshold = artifact(make_window(4, {8, 6, 6, 5}));
  EXPECT_EQ(threshold.cut, 4);
  EXPECT_EQ(threshold.status, CutStatus::kCensoredLow);
  EXPECT_EQ(states_of(threshold), "xxxx=======");
}

TEST(ArtifactCut, with_all_flagged_is_the_next_more_clamped_level_and_censored_high) {
  const auto threshold = artifact(make_window(4, {12, 12, 10, 9}));
  EXPECT_EQ(threshold.cut, 8);
  EXPECT_EQ(threshold.status, CutStatus::kCensoredHigh);
}

TEST(ArtifactCut, is_censored_high_too_where_only_the_windows_last_level_is_flagged) {
  const auto threshold = artifact(make_window(4, {6, 12, 6, 9}));
  EXPECT_EQ(threshold.cut, 8);
  EXPECT_EQ(threshold.status, CutStatus::kCensoredHigh) << "no tested level is free beyond the cut";
}

TEST(ArtifactCut, is_none_once_c10_is_flagged) {
  for (const auto& correct : {std::vector<std::int64_t>{12, 12, 12, 12}, {6, 6, 6, 9}}) {
    const auto threshold = artifact(make_window(7, correct));
    EXPECT_FALSE(threshold.cut.has_value());
    EXPECT_EQ(threshold.status, CutStatus::kNone);
    EXPECT_EQ(states_of(threshold), "xxxxxxxxxxx");
  }
}

TEST(ArtifactCut, of_a_column_without_answers_is_untested_and_shows_nothing) {
  const auto threshold = artifact(make_column({}));
  EXPECT_FALSE(threshold.cut.has_value());
  EXPECT_EQ(threshold.status, CutStatus::kUntested);
  EXPECT_EQ(states_of(threshold), "...........");
}

TEST(ArtifactCut, an_untested_level_is_never_flagged) {
  const auto threshold = artifact(make_column({{3, {12, 12}}, {4, {0, 0}}, {5, {6, 12}}}));
  EXPECT_EQ(threshold.cut, 4);
  EXPECT_EQ(threshold.status, CutStatus::kCut);
}

TEST(ArtifactCut, of_a_column_that_goes_back_is_flagged_and_follows_the_rule) {
  const auto counts = make_window(3, {12, 5, 9, 3});  // pooled: 12, 7, 7, 3
  EXPECT_EQ(artifact(counts).cut, 6);
  EXPECT_EQ(artifact(counts, Rule::kIsotonic).cut, 4);
  EXPECT_FALSE(artifact(counts).monotone);
  EXPECT_FALSE(artifact(counts).flags_monotone);
}

TEST(ArtifactCut, uneven_proportions_with_even_flags_are_said_to_be_uneven_but_cut_alike) {
  const auto counts = make_window(3, {10, 12, 5, 7});
  EXPECT_FALSE(artifact(counts).monotone);
  EXPECT_TRUE(artifact(counts).flags_monotone);
  EXPECT_EQ(artifact(counts).cut, 5);
  EXPECT_EQ(artifact(counts, Rule::kIsotonic).cut, 5);
}

TEST(ArtifactCut, of_a_study_that_ends_before_c10_is_none_once_its_last_level_is_flagged) {
  ColumnCounts counts = make_window(3, {12, 12, 12, 12});
  counts.resize(7);
  EXPECT_EQ(artifact(counts).status, CutStatus::kNone);
}

TEST(MaterialCut, is_the_most_clamped_level_before_the_first_changed_one) {
  const auto threshold = material(make_column({{3, {6, 14}}, {5, {7, 14}}, {7, {11, 14}}, {10, {14, 14}}}));
  EXPECT_EQ(threshold.cut, 5);
  EXPECT_EQ(threshold.status, CutStatus::kCut);
  EXPECT_EQ(states_of(threshold), "...===.xxxx");
}

TEST(MaterialCut, counts_an_untested_level_as_unchanged_only_between_two_unchanged_tested_ones) {
  const auto threshold = material(make_column({{3, {6, 14}}, {5, {7, 14}}, {7, {11, 14}}}));
  EXPECT_EQ(threshold.states[4], kSame);
  EXPECT_EQ(threshold.states[6], kUnknown);
}

TEST(MaterialCut, leaves_everything_less_clamped_than_the_first_tested_level_open) {
  const auto threshold = material(make_column({{6, {6, 14}}, {8, {6, 14}}, {10, {6, 14}}}));
  EXPECT_EQ(states_of(threshold), "......=====");
  EXPECT_EQ(threshold.cut, 10);
  EXPECT_EQ(threshold.status, CutStatus::kCensoredHigh);
}

TEST(MaterialCut, nothing_follows_beyond_the_last_tested_level_where_none_changed) {
  EXPECT_EQ(states_of(material(make_column({{4, {6, 14}}, {6, {6, 14}}}))), "....===....");
}

TEST(MaterialCut, lies_below_the_first_tested_level_where_that_has_changed) {
  const auto threshold = material(make_column({{4, {14, 14}}, {6, {6, 14}}, {10, {6, 14}}}));
  EXPECT_FALSE(threshold.cut.has_value());
  EXPECT_EQ(threshold.below, 4);
  EXPECT_EQ(threshold.status, CutStatus::kCensoredLow);
  EXPECT_EQ(format_cut(threshold), "< C4");
  EXPECT_EQ(states_of(threshold), "....xxxxxxx");
  EXPECT_FALSE(threshold.flags_monotone);
}

TEST(MaterialCut, is_none_only_where_the_least_clamped_level_was_tested_and_has_changed) {
  const auto threshold = material(make_column({{0, {14, 14}}, {2, {14, 14}}, {4, {14, 14}}}));
  EXPECT_FALSE(threshold.cut || threshold.below);
  EXPECT_EQ(threshold.status, CutStatus::kNone);
  EXPECT_EQ(format_cut(threshold), "-");
  ColumnCounts counts = make_column({{4, {14, 14}}, {6, {14, 14}}});
  counts.erase(counts.begin(), counts.begin() + 4);
  EXPECT_EQ(material(counts).status, CutStatus::kNone) << "of a study that begins at C4";
}

TEST(MaterialCut, everything_from_the_first_changed_level_on_is_changed) {
  const auto counts = make_column({{3, {6, 14}}, {5, {11, 14}}, {7, {4, 14}}, {10, {14, 14}}});
  EXPECT_EQ(states_of(material(counts)), "...=.xxxxxx");
  EXPECT_EQ(states_of(material(counts, Rule::kIsotonic)), "...=====..x") << "pooled: 6, 7.5, 7.5, 14";
}

TEST(MaterialCut, of_a_dropped_column_is_untested) {
  EXPECT_EQ(material(make_column({})).status, CutStatus::kUntested);
}

// All ways to cut the tested levels into blocks; among those whose block means obey the order, the one of
// least weighted squared error is the isotonic regression (and unique as a function).
std::vector<double> fit_by_brute_force(const std::vector<Count>& counts, bool falling) {
  const std::size_t size = counts.size();
  double best = std::numeric_limits<double>::infinity();
  std::vector<double> best_fit;
  for (unsigned mask = 0; mask < (1U << (size - 1)); ++mask) {
    std::vector<double> fit;
    for (std::size_t begin = 0; begin < size;) {
      std::size_t end = begin + 1;
      while (end < size && !(mask >> (end - 1) & 1U)) ++end;
      double k = 0, n = 0;
      for (std::size_t i = begin; i < end; ++i) k += counts[i].k, n += counts[i].n;
      fit.insert(fit.end(), end - begin, k / n);
      begin = end;
    }
    double error = 0;
    bool ordered = true;
    for (std::size_t i = 0; i < size; ++i) {
      const double difference = static_cast<double>(counts[i].k) / counts[i].n - fit[i];
      error += counts[i].n * difference * difference;
      if (i > 0 && (falling ? fit[i] > fit[i - 1] + 1e-12 : fit[i] < fit[i - 1] - 1e-12)) ordered = false;
    }
    if (ordered && error < best - 1e-12) best = error, best_fit = fit;
  }
  return best_fit;
}

ColumnCounts make_random_column(RandomStream& random, std::int64_t largest_n) {
  ColumnCounts counts = make_column({});
  for (LevelCount& level : counts) {
    if (random.next_below(4) == 0) continue;
    level.count.n = 1 + static_cast<std::int64_t>(random.next_below(static_cast<std::uint64_t>(largest_n)));
    level.count.k =
        static_cast<std::int64_t>(random.next_below(static_cast<std::uint64_t>(level.count.n) + 1));
  }
  return counts;
}

std::vector<Count> tested_counts(const ColumnCounts& counts) {
  std::vector<Count> tested;
  for (const LevelCount& level : counts) {
    if (level.count.n > 0) tested.push_back(level.count);
  }
  return tested;
}

// Seed 11, 3,000 columns of up to eleven tested levels, n from 1 to 20.
TEST(Isotonic, pooling_equals_the_best_ordered_partition_by_brute_force) {
  RandomStream random(11, "columns", 0);
  for (int i = 0; i < 3000; ++i) {
    const ColumnCounts counts = make_random_column(random, 20);
    const auto tested = tested_counts(counts);
    if (tested.empty()) continue;
    for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
      const auto pooled = tested_counts(pool_adjacent_violators(counts, experiment));
      const auto expected = fit_by_brute_force(tested, experiment == Experiment::kArtifact);
      ASSERT_EQ(pooled.size(), expected.size());
      for (std::size_t level = 0; level < pooled.size(); ++level) {
        ASSERT_NEAR(static_cast<double>(pooled[level].k) / pooled[level].n, expected[level], 1e-9);
      }
    }
  }
}

TEST(Isotonic, leaves_untested_levels_untested) {
  const auto counts = make_column({{2, {3, 12}}, {5, {9, 12}}});
  const auto pooled = pool_adjacent_violators(counts, Experiment::kArtifact);
  EXPECT_EQ(pooled[3].count, (Count{0, 0}));
  EXPECT_EQ(pooled[2].count, (Count{12, 24}));
  EXPECT_EQ(pooled[5].count, (Count{12, 24}));
}

bool are_alike(const Threshold& a, const Threshold& b) {
  return a.cut == b.cut && a.below == b.below && a.status == b.status && a.states == b.states;
}

// Pooled in any case: the program does so only where flags break the order.
bool cut_alike(const ColumnCounts& counts, Experiment experiment) {
  const Threshold pooled = find_cut(pool_adjacent_violators(counts, experiment), experiment, Rule::kPaper);
  EXPECT_TRUE(are_alike(find_cut(counts, experiment, Rule::kIsotonic), pooled));
  return are_alike(find_cut(counts, experiment, Rule::kPaper), pooled);
}

// Seed 12, 20,000 columns made monotone by sorting their proportions, unequal n. Even flags are enough.
TEST(Isotonic, agrees_with_paper_where_proportions_or_flags_are_monotone) {
  RandomStream random(12, "columns", 0);
  int monotone = 0, flags_only = 0, different = 0;
  for (int i = 0; i < 20000; ++i) {
    ColumnCounts counts = make_random_column(random, 15);
    auto tested = tested_counts(counts);
    for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
      const Threshold raw = find_threshold(counts, experiment, Rule::kPaper);
      if (raw.flags_monotone) {
        flags_only += raw.monotone ? 0 : 1;
        ASSERT_TRUE(cut_alike(counts, experiment));
      } else {
        different += cut_alike(counts, experiment) ? 0 : 1;
      }
      ColumnCounts sorted = counts;
      std::sort(tested.begin(), tested.end(), [&](const Count& a, const Count& b) {
        return experiment == Experiment::kArtifact ? a.k * b.n > b.k * a.n : a.k * b.n < b.k * a.n;
      });
      std::size_t next = 0;
      for (LevelCount& level : sorted) {
        if (level.count.n > 0) level.count = tested[next++];
      }
      ASSERT_TRUE(find_threshold(sorted, experiment, Rule::kPaper).monotone);
      ASSERT_TRUE(cut_alike(sorted, experiment));
      ++monotone;
    }
  }
  EXPECT_EQ(monotone, 40000);
  EXPECT_GT(flags_only, 1000);
  EXPECT_GT(different, 1000) << "the property would hold of rules that never differ";
}

// Seed 13, 20,000 columns.
TEST(Thresholds, both_rules_at_once_are_each_by_itself) {
  RandomStream random(13, "columns", 0);
  for (int i = 0; i < 20000; ++i) {
    std::vector<Count> counts;
    for (const LevelCount& level : make_random_column(random, 15)) counts.push_back(level.count);
    for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
      const auto cuts = place_cuts(counts, experiment);
      for (const Rule rule : kRules)
        ASSERT_EQ(cuts[static_cast<std::size_t>(rule)], place_cut(counts, experiment, rule));
    }
  }
}

TEST(Thresholds, a_rule_has_one_name_and_no_other_is_read) {
  for (const Rule rule : kRules) EXPECT_EQ(parse_rule(format_rule(rule), "test"), rule);
  EXPECT_THROW(parse_rule("monotone", "test"), InputError);
}

}  // namespace
}  // namespace equilux::tests
