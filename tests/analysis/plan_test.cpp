// The number of subjects: simulated shares against exact tails, and what must grow with n.
#include "analysis/plan.h"

#include <cmath>
#include <gtest/gtest.h>

#include "analysis/probability.h"
#include "base/error.h"
#include "base/files.h"
#include "tests/analysis/columns.h"
#include "tests/support/temp_folder.h"

namespace equilux::tests {
namespace {

std::vector<SubjectPlanRow> simulate(const SubjectPlanParams& params) {
  const Study study = load_protocol("pocket");
  return simulate_plan(study, load_truth(study.truth_path, study), load_windows(study.windows_path, study),
                       params);
}

double eval_flagged(int n, double p) {
  double tail = 0, term = std::pow(1 - p, n);
  for (int k = 0; k <= n; ++k) {
    if (4 * k >= 3 * n) tail += term;
    term *= p / (1 - p) * (n - k) / (k + 1);
  }
  return tail;
}

TEST(Proportion, runs_from_one_half_to_the_lapse_rate_and_crosses_between_the_levels) {
  const PlantedColumn planted{5, 7};
  EXPECT_EQ(eval_proportion(planted, Experiment::kArtifact, 4, 0, 0.02), 0.99);
  EXPECT_EQ(eval_proportion(planted, Experiment::kArtifact, 5, 0, 0.02), 0.5);
  EXPECT_EQ(eval_proportion(planted, Experiment::kMaterial, 7, 0, 0.02), 0.5);
  EXPECT_EQ(eval_proportion(planted, Experiment::kMaterial, 8, 0, 0.02), 0.99);
  EXPECT_GT(eval_proportion(planted, Experiment::kArtifact, 4, 1, 0), 0.75);
  EXPECT_LT(eval_proportion(planted, Experiment::kArtifact, 5, 1, 0), 0.75);
  EXPECT_NEAR(eval_proportion(planted, Experiment::kArtifact, 4, 1, 0) +
                  eval_proportion(planted, Experiment::kArtifact, 5, 1, 0),
              1.5, 1e-12);
}

// A step: every cell is guessed or seen but for lapses of 2 %. 400 studies of 8 columns, seed 1: some 12,800
// artifact cells; four standard errors of a share of at least 6,000.
TEST(Plan, of_a_step_has_the_exact_false_flags_and_power) {
  const auto rows = simulate({{8, 12, 14}, 400, 0, 1, Rule::kPaper});
  for (const SubjectPlanRow& row : rows) {
    const double guessed = eval_flagged(row.subjects, 0.5), seen = eval_flagged(row.subjects, 0.99);
    EXPECT_NEAR(row.false_flags.value, guessed, 4 * std::sqrt(guessed * (1 - guessed) / 6000))
        << row.subjects;
    EXPECT_NEAR(row.power.value, seen, 4 * std::sqrt(seen * (1 - seen) / 6000) + 1e-4) << row.subjects;
  }
}

TEST(Plan, of_very_many_subjects_is_right_about_everything) {
  const auto rows = simulate({{400}, 5, 0, 1, Rule::kPaper});
  EXPECT_EQ(rows[0].false_flags.value, 0);
  EXPECT_EQ(rows[0].power.value, 1);
  EXPECT_EQ(rows[0].cuts_right.value, 1);
  EXPECT_EQ(rows[0].ee_right.value, 1);
  const Study study = load_protocol("pocket");
  EXPECT_LE(rows[0].green_width.value, find_true_width(study, load_truth(study.truth_path, study)));
  EXPECT_GT(rows[0].supported.value, 0);
}

TEST(Plan, gains_support_with_subjects) {
  const auto rows = simulate({{12, 40, 160}, 100, 0.5, 2, Rule::kIsotonic});
  EXPECT_LT(rows[0].supported.value, rows[1].supported.value);
  EXPECT_LT(rows[1].supported.value, rows[2].supported.value);
  EXPECT_LT(rows[0].cuts_right.value, rows[2].cuts_right.value);
}

TEST(Plan, is_a_function_of_its_seed) {
  const SubjectPlanParams params{{12}, 20, 0.5, 3, Rule::kPaper};
  EXPECT_EQ(make_plan_table(simulate(params)), make_plan_table(simulate(params)));
  SubjectPlanParams other = params;
  other.seed = 4;
  EXPECT_NE(make_plan_table(simulate(params)), make_plan_table(simulate(other)));
}

// 40 seeds of 60 studies: the spread of what they find is known to 11 %, four of which are allowed.
TEST(Plan, has_standard_errors_that_are_the_spread_over_seeds) {
  double sums[2] = {}, squares[2] = {}, variances[2] = {};
  constexpr int kSeeds = 40;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const auto row = simulate({{12}, 60, 0.5, static_cast<std::uint64_t>(seed), Rule::kPaper})[0];
    const SimulatedShare* shares[2] = {&row.false_flags, &row.cuts_right};
    for (int i = 0; i < 2; ++i) {
      sums[i] += shares[i]->value;
      squares[i] += shares[i]->value * shares[i]->value;
      variances[i] += *shares[i]->standard_error * *shares[i]->standard_error / kSeeds;
    }
  }
  for (int i = 0; i < 2; ++i) {
    const double spread = std::sqrt((squares[i] - sums[i] * sums[i] / kSeeds) / (kSeeds - 1));
    EXPECT_NEAR(std::sqrt(variances[i]) / spread, 1, 0.44) << i;
  }
  EXPECT_FALSE(simulate({{12}, 1, 0.5, 1, Rule::kPaper})[0].power.standard_error);
}

TEST(Plan, takes_another_number_of_subjects_for_the_material_experiment) {
  SubjectPlanParams params{{12, 14}, 20, 0.5, 3, Rule::kPaper, {14}};
  const auto rows = simulate(params);
  EXPECT_EQ(rows[0].subjects, 12);
  EXPECT_EQ(rows[0].material_subjects, 14);
  params.material_subjects = {40, 14};
  EXPECT_EQ(simulate(params)[0].material_subjects, 40);
  // Equal numbers are the same study whichever way they are given.
  EXPECT_EQ(make_plan_table({rows[1]}), make_plan_table(simulate({{14}, 20, 0.5, 3, Rule::kPaper})));
  params.material_subjects = {1, 2, 3};
  EXPECT_THROW(simulate(params), InputError);
}

TEST(Plan, is_written_with_all_that_it_depends_on_and_a_dictionary) {
  const Study study = load_protocol("pocket");
  const Truth truth = load_truth(study.truth_path, study);
  const Windows windows = load_windows(study.windows_path, study);
  const SubjectPlanParams params{{12, 16}, 5, 0.25, 9, Rule::kIsotonic, {14}};
  const auto rows = simulate_plan(study, truth, windows, params);
  const TempFolder folder;
  write_plan(rows, make_plan_json(study, truth, windows, params, rows), folder.path());
  const Json json = parse_json(load_text(folder / "plan.json"), "plan.json");
  EXPECT_EQ(json.at("truth_digest").as_string(), truth.digest);
  EXPECT_EQ(json.at("rule").as_string(), "isotonic");
  EXPECT_EQ(json.at("seed").as_double(), 9);
  EXPECT_EQ(json.at("slope").as_double(), 0.25);
  EXPECT_EQ(json.at("studies").as_double(), 5);
  EXPECT_EQ(json.at("rows").as_array()[0].at("material_subjects").as_double(), 14);
  EXPECT_EQ(json.at("rows").as_array()[0].at("power").as_double(), rows[0].power.value);
  const std::string metadata = load_text(folder / "plan.csv-metadata.json");
  for (const std::string& column : make_plan_table(rows).columns)
    EXPECT_NE(metadata.find("\"" + column + "\""), std::string::npos) << column;
}

// gnuplot draws no range that is empty, and says so in the user's terminal.
TEST(Plan, of_one_number_of_subjects_or_without_green_levels_is_drawn_without_a_warning) {
  const Study study = load_protocol("pocket");
  const Truth truth = load_truth(study.truth_path, study);
  const Windows windows = load_windows(study.windows_path, study);
  const SubjectPlanParams params{{12}, 2, 0.5, 1, Rule::kPaper};
  auto rows = simulate_plan(study, truth, windows, params);
  const TempFolder folder;
  const auto write = [&] {
    testing::internal::CaptureStderr();
    write_plan(rows, make_plan_json(study, truth, windows, params, rows), folder.path());
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(write(), "");
  rows.front().green_width = rows.front().supported = {};
  EXPECT_EQ(write(), "");
}

}  // namespace
}  // namespace equilux::tests
