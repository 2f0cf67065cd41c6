// 12 and 14 subjects through the real programs: what comes back is a sample, and its distribution is known.
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <gtest/gtest.h>

#include "tests/experiment/fake_study.h"
#include "tests/support/statistics.h"
#include "tests/walk/planted_findings.h"
#include "tests/walk/programs.h"

namespace equilux {
namespace {

constexpr int kStudies = 200;  // seeds 1 .. 200
constexpr double kLevel = 0.01;
constexpr double kVisible = 0.99;  // lapse rate .02, and every second lapse guesses right
constexpr double kGuessed = 0.5;
constexpr double kFlaggedOf12 = 299.0 / 4096;   // 9 or more of 12 by guessing
constexpr double kFlaggedOf14 = 470.0 / 16384;  // 11 or more of 14

using Histogram = std::vector<double>;

double sum(const Histogram& histogram) {
  double total = 0;
  for (double count : histogram) total += count;
  return total;
}

/// How often k of n subjects were correct: [k].
Histogram eval_binomial(int n, double p) {
  const boost::math::binomial_distribution<double> count(n, p);
  Histogram probabilities;
  for (int k = 0; k <= n; ++k) probabilities.push_back(boost::math::pdf(count, k));
  return probabilities;
}

/// Whether the counts may come from these probabilities, by chi-squared at 1 %.
bool agrees(const Histogram& observed, Histogram expected) {
  for (double& value : expected) value *= sum(observed);
  const test::ChiSquared result = test::test_chi_squared(observed, expected);
  EXPECT_GE(result.degrees, 1);
  return result.p > kLevel;
}

struct ExperimentSpread {
  int subjects = 0;
  Histogram visible, guessed;  ///< [k]: cells
};

struct Spread {
  ExperimentSpread artifact{12, Histogram(13), Histogram(13)};
  ExperimentSpread material{14, Histogram(15), Histogram(15)};
  std::map<int, Histogram> cuts;  ///< visible levels of the window -> [cut - first]: columns
};

using Truths = std::map<std::string, PlantedColumn>;

bool is_seen(const Record& row, const PlantedColumn& truth) {
  const int level = *parse_cut(row.at("clamp"));
  return row.at("experiment") == "artifact" ? level < truth.artifact_free_from
                                            : level > truth.material_same_to;
}

void add_cells(const std::vector<Record>& cells, const Truths& truths, Spread& spread) {
  for (const Record& row : cells) {
    if (row.at("n") == "0") continue;
    ExperimentSpread& experiment = row.at("experiment") == "artifact" ? spread.artifact : spread.material;
    ASSERT_EQ(row.at("n"), std::to_string(experiment.subjects));
    Histogram& histogram =
        is_seen(row, truths.at(column_name(row))) ? experiment.visible : experiment.guessed;
    histogram.at(std::stoul(row.at("k"))) += 1;
  }
}

void add_cuts(const std::vector<Record>& thresholds, const std::map<std::string, PlantedFinding>& findings,
              Spread& spread) {
  for (const Record& row : thresholds) {
    if (row.at("experiment") != "artifact" || row.at("rule") != "paper") continue;
    const PlantedFinding& finding = findings.at(column_name(row));
    Histogram& histogram = spread.cuts.try_emplace(finding.visible, Histogram(5)).first->second;
    // None stands behind C10, which is the last of a window here.
    const int cut = parse_cut(row.at("cut")).value_or(kClampLevelCount);
    histogram.at(static_cast<std::size_t>(cut - finding.first)) += 1;
  }
}

/// A folder whose subjects can be sent home: its pictures stay.
void forget_sessions(const StudyFolder& folder) {
  for (const char* end : {"", "-wal", "-shm"}) std::filesystem::remove(folder.responses().string() + end);
  std::filesystem::remove(folder.selection(SubjectKind::kPlanted));
  std::filesystem::remove_all(folder.report_folder());
}

ReportTables walk(const StudyFolder& folder, int seed) {
  forget_sessions(folder);
  const std::string root = folder.root.string(), text = std::to_string(seed);
  run_well("session", {"simulate", root, "--experiment", "artifact", "--subjects", "12", "--seed", text});
  run_well("analyze", {"prune", root, "--kind", "planted"});
  run_well("session", {"simulate", root, "--experiment", "material", "--subjects", "14", "--seed", text});
  run_well("analyze",
           {"report", root, "--kind", "planted", "--no-plot", "--draws", "10", "--resamples", "10"});
  return load_report_tables(folder.report_folder());
}

Spread walk_all(const StudyFolder& folder) {
  const Study study = load_folder_study(folder);
  const Truth truth = load_truth(folder.truth(), study);
  const auto findings = make_planted_findings(truth, load_windows(folder.windows(), study));
  Truths truths;
  for (const auto& [column, planted] : truth.by_column) truths[column_name(column)] = planted;
  Spread spread;
  for (int seed = 1; seed <= kStudies; ++seed) {
    const ReportTables tables = walk(folder, seed);
    add_cells(tables.cells, truths, spread);
    add_cuts(tables.thresholds, findings, spread);
  }
  return spread;
}

bool agree_cells(const ExperimentSpread& spread) {
  return agrees(spread.visible, eval_binomial(spread.subjects, kVisible)) &&
         agrees(spread.guessed, eval_binomial(spread.subjects, kGuessed));
}

/// Guessed cells that are flagged, 4k >= 3n.
bool agree_flags(const ExperimentSpread& spread, double probability) {
  double flagged = 0;
  for (std::size_t k = 0; k < spread.guessed.size(); ++k) {
    if (4 * static_cast<int>(k) >= 3 * spread.subjects) flagged += spread.guessed[k];
  }
  return agrees({flagged, sum(spread.guessed) - flagged}, {probability, 1 - probability});
}

/// Rule `paper`: the cut stands just behind the last flagged of four levels.
Histogram eval_cuts(int visible_levels) {
  const Histogram seen = eval_binomial(12, kVisible);
  const double flagged_seen = seen[9] + seen[10] + seen[11] + seen[12];
  Histogram probabilities(5);
  double none_behind = 1;
  for (int level = 3; level >= 0; --level) {
    const double flagged = level < visible_levels ? flagged_seen : kFlaggedOf12;
    probabilities[static_cast<std::size_t>(level) + 1] = none_behind * flagged;
    none_behind *= 1 - flagged;
  }
  probabilities[0] = none_behind;
  return probabilities;
}

/// The number of columns whose cut comes back exactly against its mean and deviation, two-sided at 1 %.
bool agree_exact_cuts(const std::map<int, Histogram>& cuts) {
  double exact = 0, mean = 0, variance = 0;
  for (const auto& [visible, histogram] : cuts) {
    const double p = eval_cuts(visible)[static_cast<std::size_t>(visible)];
    exact += histogram[static_cast<std::size_t>(visible)];
    mean += sum(histogram) * p;
    variance += sum(histogram) * p * (1 - p);
  }
  return std::abs(exact - mean) < 2.576 * std::sqrt(variance);
}

Histogram moved_up(Histogram histogram) {
  histogram.insert(histogram.begin(), 0);
  const double last = histogram.back();
  histogram.pop_back();
  histogram.back() += last;
  return histogram;
}

// Mutants: every cell has one correct answer more, every cut stands one level too far. The checks must fail.
void expect_mutants_to_fail(const Spread& spread) {
  for (ExperimentSpread mutant : {spread.artifact, spread.material}) {
    mutant.guessed = moved_up(mutant.guessed);
    EXPECT_FALSE(agree_cells(mutant));
    EXPECT_FALSE(agree_flags(mutant, mutant.subjects == 12 ? kFlaggedOf12 : kFlaggedOf14));
  }
  auto cuts = spread.cuts;
  for (auto& [visible, histogram] : cuts) histogram = moved_up(histogram);
  EXPECT_FALSE(agree_exact_cuts(cuts));
}

// 200 studies on pocket, seeds 1 .. 200, 12 and 14 subjects, lapse rate .02, side bias .5: 6,400 artifact
// cells, 1,600 columns. Level 1 % for each comparison.
TEST(Spread, OfTwoHundredStudiesIsTheBinomialOne) {
  const TemporaryFolder temporary;
  const Spread spread = walk_all(make_fake_study(temporary.path()));
  EXPECT_EQ(sum(spread.artifact.visible) + sum(spread.artifact.guessed), kStudies * 32);
  EXPECT_TRUE(agree_cells(spread.artifact));
  EXPECT_TRUE(agree_cells(spread.material));
  EXPECT_TRUE(agree_flags(spread.artifact, kFlaggedOf12));
  EXPECT_TRUE(agree_flags(spread.material, kFlaggedOf14));
  for (const auto& [visible, histogram] : spread.cuts) {
    EXPECT_EQ(sum(histogram), kStudies * 4);
    EXPECT_TRUE(agrees(histogram, eval_cuts(visible))) << visible << " visible levels";
  }
  EXPECT_NEAR(eval_cuts(2)[2], 0.859, 0.001) << "about 85 %, as study.md says";
  EXPECT_TRUE(agree_exact_cuts(spread.cuts));
  expect_mutants_to_fail(spread);
}

/// k correct of 12 guesses where the test picture stood left six times: two binomials added.
Histogram eval_biased(double left) {
  const Histogram there = eval_binomial(6, left), here = eval_binomial(6, 1 - left);
  Histogram probabilities(13);
  for (std::size_t i = 0; i <= 6; ++i) {
    for (std::size_t k = 0; k <= 6; ++k) probabilities[i + k] += there[i] * here[k];
  }
  return probabilities;
}

// 60 studies, seeds 1 .. 60, 12 subjects who see nothing and answer left with probability .8; 1 %. A side
// that is not balanced within each cell would spread k more.
TEST(Spread, OfSubjectsWhoPreferASideShowsThatSidesAreBalanced) {
  const TemporaryFolder temporary;
  const StudyFolder folder = make_fake_study(temporary.path());
  save_fake_truth(folder, 0.02, 0.8, "C0", "C10", folder.truth());
  Histogram observed(13);
  for (int seed = 1; seed <= 60; ++seed) {
    forget_sessions(folder);
    const std::string root = folder.root.string();
    run_well("session", {"simulate", root, "--experiment", "artifact", "--subjects", "12", "--seed",
                         std::to_string(seed)});
    run_well("analyze", {"report", root, "--no-plot", "--draws", "10", "--resamples", "10"});
    for (const Record& row : load_report_tables(folder.report_folder()).cells) {
      if (row.at("n") == "12") observed.at(std::stoul(row.at("k"))) += 1;
    }
  }
  EXPECT_EQ(sum(observed), 60 * 32);
  EXPECT_TRUE(agrees(observed, eval_biased(0.8)));
  EXPECT_FALSE(agrees(observed, eval_binomial(12, kGuessed))) << "the mutant: sides at random";
}

}  // namespace
}  // namespace equilux
