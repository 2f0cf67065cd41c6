// The number of subjects: simulated shares against exact tails, and what must grow with n.
#include "analysis/plan.h"

#include <cmath>
#include <gtest/gtest.h>

#include "analysis/probability.h"
#include "tests/analysis/columns.h"

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
    EXPECT_NEAR(row.false_flags, guessed, 4 * std::sqrt(guessed * (1 - guessed) / 6000)) << row.subjects;
    EXPECT_NEAR(row.power, seen, 4 * std::sqrt(seen * (1 - seen) / 6000) + 1e-4) << row.subjects;
  }
}

TEST(Plan, of_very_many_subjects_is_right_about_everything) {
  const auto rows = simulate({{400}, 5, 0, 1, Rule::kPaper});
  EXPECT_EQ(rows[0].false_flags, 0);
  EXPECT_EQ(rows[0].power, 1);
  EXPECT_EQ(rows[0].cuts_right, 1);
  EXPECT_EQ(rows[0].ee_right, 1);
  const Study study = load_protocol("pocket");
  EXPECT_LE(rows[0].green_width, find_true_width(study, load_truth(study.truth_path, study)));
  EXPECT_GT(rows[0].supported, 0);
}

TEST(Plan, gains_support_with_subjects) {
  const auto rows = simulate({{12, 40, 160}, 100, 0.5, 2, Rule::kIsotonic});
  EXPECT_LT(rows[0].supported, rows[1].supported);
  EXPECT_LT(rows[1].supported, rows[2].supported);
  EXPECT_LT(rows[0].cuts_right, rows[2].cuts_right);
}

TEST(Plan, is_a_function_of_its_seed) {
  const SubjectPlanParams params{{12}, 20, 0.5, 3, Rule::kPaper};
  EXPECT_EQ(make_plan_table(simulate(params)), make_plan_table(simulate(params)));
  SubjectPlanParams other = params;
  other.seed = 4;
  EXPECT_NE(make_plan_table(simulate(params)), make_plan_table(simulate(other)));
}

}  // namespace
}  // namespace equilux::tests
