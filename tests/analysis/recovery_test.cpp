// A planted truth put through the stages and found again: exactly with many subjects, and with 12 and 14 in
// the spread that the binomial distribution computes. The checks are then run on mutants, which they must
// reject.
#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/chi_squared.hpp>
#include <gtest/gtest.h>
#include <map>

#include "tests/analysis/columns.h"

namespace equilux::tests {
namespace {

// What the material experiment can say at best: the last kept level up to which the planted material is the
// same.
std::optional<int> find_planted_material_cut(const PlantedColumn& truth, const std::vector<int>& kept) {
  std::optional<int> cut;
  for (int level : kept) {
    if (level <= truth.material_same_to) cut = level;
  }
  return cut;
}

bool recovers(const PlantedStudy& planted, const std::vector<ColumnFinding>& findings, Rule rule) {
  for (const ColumnFinding& finding : findings) {
    const PlantedColumn& truth = planted.truth.by_column.at(finding.column);
    const RuleFinding& under = finding.under(rule);
    const auto row = std::find_if(planted.selection.columns.begin(), planted.selection.columns.end(),
                                  [&](const auto& column) { return column.column == finding.column; });
    if (under.artifact.cut != truth.artifact_free_from) return false;
    if (under.material.cut != find_planted_material_cut(truth, row->levels)) return false;
    const bool exists = truth.artifact_free_from <= truth.material_same_to;
    if ((under.verdict == Verdict::kExists) != exists) return false;
  }
  return !findings.empty();
}

// Every answer behind the tally, counted again the slow way.
bool accounts_for(const std::vector<AnswerRow>& answers, const Tally& tally) {
  return std::all_of(tally.begin(), tally.end(), [&](const auto& entry) {
    Count count;
    for (const AnswerRow& row : answers) {
      if (row.cell != entry.first) continue;
      ++count.n;
      count.k += row.correct ? 1 : 0;
    }
    return count == entry.second;
  });
}

// Truths of three studies, 200 subjects in each experiment, no lapses: a guessed cell is flagged with
// probability 5e-13.
TEST(Recovery, of_the_planted_truths_is_exact_with_200_subjects) {
  for (const char* name : {"pocket", "paper", "validation", "normalisation"}) {
    const PlantedStudy planted = make_planted_study(name, 200, 200, 1, 0.0);
    for (const Rule rule : kRules) EXPECT_TRUE(recovers(planted, find_in(planted), rule)) << name;
  }
}

TEST(Recovery, of_the_planted_truths_is_exact_with_200_subjects_who_lapse) {
  const PlantedStudy planted = make_planted_study("pocket", 200, 200, 2, 0.02);
  for (const Rule rule : kRules) EXPECT_TRUE(recovers(planted, find_in(planted), rule));
}

TEST(Recovery, the_default_truths_give_green_and_red) {
  for (const char* name : {"pocket", "paper"}) {
    const PlantedStudy planted = make_planted_study(name, 200, 200, 1, 0.0);
    int green = 0, red = 0;
    for (const auto& finding : find_in(planted)) {
      (finding.under(Rule::kPaper).verdict == Verdict::kExists ? green : red) += 1;
    }
    EXPECT_GT(green, 0) << name;
    EXPECT_GT(red, 0) << name;
  }
}

TEST(Recovery, its_check_fails_on_cuts_off_by_one_level) {
  const PlantedStudy planted = make_planted_study("pocket", 200, 200, 1, 0.0);
  for (const int step : {-1, 1}) {
    auto findings = find_in(planted);
    for (auto& finding : findings) *finding.by_rule[0].artifact.cut += step;
    EXPECT_FALSE(recovers(planted, findings, Rule::kPaper)) << step;
  }
}

TEST(Recovery, its_check_fails_on_reversed_sides_of_the_clamp) {
  const PlantedStudy planted = make_planted_study("pocket", 200, 200, 1, 0.0);
  const auto reverse = [](std::vector<AnswerRow> answers) {
    for (AnswerRow& row : answers) row.cell.clamp_level = kClampLevelCount - 1 - row.cell.clamp_level;
    return answers;
  };
  PlantedStudy mutant = planted;
  mutant.artifact = reverse(planted.artifact);
  mutant.material = reverse(planted.material);
  EXPECT_FALSE(recovers(planted, find_in(mutant), Rule::kPaper));
}

TEST(Recovery, its_check_fails_where_the_experiments_are_exchanged) {
  const PlantedStudy planted = make_planted_study("pocket", 200, 200, 1, 0.0);
  PlantedStudy mutant = planted;
  std::swap(mutant.artifact, mutant.material);
  EXPECT_FALSE(recovers(planted, find_in(mutant), Rule::kPaper));
}

TEST(Recovery, a_dropped_or_turned_answer_does_not_pass_the_recount) {
  PlantedStudy planted = make_planted_study("pocket", 12, 14, 3, 0.02);
  const auto answers = planted.artifact;
  EXPECT_TRUE(accounts_for(answers, tally_answers(answers, planted.study)));
  planted.artifact.erase(planted.artifact.begin() + 17);
  EXPECT_FALSE(accounts_for(answers, tally_answers(planted.artifact, planted.study)));
  planted.artifact = answers;
  planted.artifact[17].correct = !planted.artifact[17].correct;
  EXPECT_FALSE(accounts_for(answers, tally_answers(planted.artifact, planted.study)));
}

constexpr int kStudies = 200;  // seeds 1 .. 200
constexpr double kLapseRate = 0.02;

double eval_flag_probability(std::int64_t n, double proportion) {
  const double least = static_cast<double>((3 * n + 3) / 4);
  return boost::math::cdf(boost::math::complement(
      boost::math::binomial_distribution<double>(static_cast<double>(n), proportion), least - 1));
}

// Pearson's statistic at 1 %, neighbouring bins joined until each expects at least five.
bool agrees(const std::vector<double>& observed, const std::vector<double>& expected) {
  std::vector<std::pair<double, double>> bins{{0, 0}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    if (bins.back().second >= 5) bins.emplace_back(0, 0);
    bins.back().first += observed[i];
    bins.back().second += expected[i];
  }
  if (bins.size() > 1 && bins.back().second < 5) {
    const auto last = bins.back();
    bins.pop_back();
    bins.back().first += last.first;
    bins.back().second += last.second;
  }
  double statistic = 0;
  for (const auto& [seen, wanted] : bins) statistic += (seen - wanted) * (seen - wanted) / wanted;
  EXPECT_GT(bins.size(), 1U);
  return statistic <
         boost::math::quantile(boost::math::chi_squared(static_cast<double>(bins.size() - 1)), 0.99);
}

using Flag = std::function<bool(const Count&)>;

// Over 200 studies of n subjects: how many of the cells without a visible difference are flagged, against
// Bin(cells, P(flag by guessing)).
bool false_flags_are_binomial(Experiment experiment, int subjects, const Flag& flag) {
  const PlantedStudy planted = make_planted_study("pocket", 200, 1, 1, 0.0);
  const Windows windows = load_windows(planted.study.windows_path, planted.study);
  const auto cells = experiment == Experiment::kArtifact
                         ? enumerate_window_cells(planted.study, windows)
                         : enumerate_selected_cells(planted.selection, planted.study);
  std::vector<Cell> guessed;
  for (const Cell& cell : cells) {
    if (!is_visible(planted.truth.by_column.at(cell.column), experiment, cell.clamp_level))
      guessed.push_back(cell);
  }
  std::vector<double> observed(guessed.size() + 1, 0.0), expected(guessed.size() + 1, 0.0);
  for (int study = 1; study <= kStudies; ++study) {
    const Tally tally = tally_answers(answer_by_truth(planted.truth, cells, experiment, subjects,
                                                      static_cast<std::uint64_t>(study), kLapseRate),
                                      planted.study);
    observed[static_cast<std::size_t>(std::count_if(
        guessed.begin(), guessed.end(), [&](const Cell& cell) { return flag(tally.at(cell)); }))] += 1;
  }
  const boost::math::binomial_distribution<double> count(static_cast<double>(guessed.size()),
                                                         eval_flag_probability(subjects, 0.5));
  for (std::size_t i = 0; i < expected.size(); ++i) {
    expected[i] = kStudies * boost::math::pdf(count, static_cast<double>(i));
  }
  return agrees(observed, expected);
}

TEST(Spread, of_false_flags_with_12_and_14_subjects_is_binomial) {
  const Flag flag = [](const Count& count) { return is_flagged(count); };
  EXPECT_TRUE(false_flags_are_binomial(Experiment::kArtifact, 12, flag));
  EXPECT_TRUE(false_flags_are_binomial(Experiment::kMaterial, 14, flag));
}

TEST(Spread, its_check_fails_on_cells_cut_off_by_one) {
  const Flag early = [](const Count& c) { return c.n > 0 && 4 * (c.k + 1) >= 3 * c.n; };
  const Flag late = [](const Count& c) { return c.n > 0 && 4 * (c.k - 1) >= 3 * c.n; };
  EXPECT_FALSE(false_flags_are_binomial(Experiment::kArtifact, 12, early));
  EXPECT_FALSE(false_flags_are_binomial(Experiment::kArtifact, 12, late));
  EXPECT_FALSE(false_flags_are_binomial(Experiment::kMaterial, 14, early));
}

// Probability of each cut first .. first + 4 under `paper`, flags being independent: the cut is just after
// the last flagged level.
std::vector<double> eval_cut_distribution(int visible_levels, std::int64_t n) {
  std::vector<double> probability(kWindowLevels + 1, 0.0);
  double none_after = 1;
  for (int i = kWindowLevels - 1; i >= 0; --i) {
    const double proportion = i < visible_levels ? 1 - kLapseRate / 2 : 0.5;
    const double flagged = eval_flag_probability(n, proportion);
    probability[static_cast<std::size_t>(i) + 1] = none_after * flagged;
    none_after *= 1 - flagged;
  }
  probability[0] = none_after;
  return probability;
}

// 200 studies of 12 subjects; columns with equally many visible levels in their window are draws of one
// distribution.
TEST(Spread, of_artifact_cuts_with_12_subjects_is_as_computed) {
  const Study study = load_protocol("pocket");
  const Truth truth = load_truth(study.truth_path, study);
  const Windows windows = load_windows(study.windows_path, study);
  std::map<int, std::vector<double>> observed;
  std::map<int, int> draws;
  for (int seed = 1; seed <= kStudies; ++seed) {
    const Tally tally =
        tally_answers(answer_by_truth(truth, enumerate_window_cells(study, windows), Experiment::kArtifact,
                                      12, static_cast<std::uint64_t>(seed), kLapseRate),
                      study);
    for (const Column& column : enumerate_columns(study)) {
      const int first = windows.by_column.at(column).first_level;
      const int visible = truth.by_column.at(column).artifact_free_from - first;
      const auto cut =
          find_threshold(counts_of(tally, column, study), Experiment::kArtifact, Rule::kPaper).cut;
      auto& histogram = observed[visible];
      histogram.resize(kWindowLevels + 1, 0.0);
      // None stands behind C10, which is the last of a window here.
      histogram[static_cast<std::size_t>(cut.value_or(kClampLevelCount) - first)] += 1;
      ++draws[visible];
    }
  }
  for (const auto& [visible, histogram] : observed) {
    auto expected = eval_cut_distribution(visible, 12);
    EXPECT_GT(expected[static_cast<std::size_t>(visible)], 0.85) << "most cuts come back exactly";
    EXPECT_LT(expected[static_cast<std::size_t>(visible)], 0.93) << "but not all";
    for (double& value : expected) value *= draws[visible];
    EXPECT_TRUE(agrees(histogram, expected)) << visible << " visible levels";
  }
}

}  // namespace
}  // namespace equilux::tests
