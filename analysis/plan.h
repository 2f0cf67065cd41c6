// How many subjects a study needs: studies simulated from its planted truth, judged by the same rules.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/csv.h"
#include "analysis/thresholds.h"
#include "protocols/truth.h"
#include "protocols/windows.h"

namespace equilux {

struct SubjectPlanParams {
  std::vector<int> subjects = {6, 8, 10, 12, 14, 16, 20, 24, 32, 40, 60};  ///< in each experiment
  int studies = 200;                                                       ///< simulated for each number
  /// Spread of the psychometric function. units: clamp levels; 0 makes a step, as planted subjects have.
  double slope = 0.5;
  std::uint64_t seed = 1;
  Rule rule = Rule::kPaper;
};

/// What so many subjects in each experiment give, averaged over studies.
struct SubjectPlanRow {
  int subjects = 0;
  double false_flags = 0;  ///< share of cells below the cut in truth that are flagged
  double power = 0;        ///< share of cells at the cut or above in truth that are flagged
  double cuts_right = 0;   ///< share of columns whose artifact cut is the truth's
  double ee_right = 0;     ///< share of columns whose EE is the truth's
  double green_width = 0;  ///< equivalent levels of a column
  double supported = 0;    ///< equivalent levels of a column that are supported
};

/// True proportion correct in a cell: one half and the lapse rate are its ends, and 75 % before lapses lies
/// between the last level with a visible difference and the next. source: 2AFC with a logistic function,
/// Kingdom and Prins 2010, chapter 4.
double eval_proportion(const PlantedColumn& planted, Experiment experiment, int level, double slope,
                       double lapse_rate);

/// One row for each number of subjects.
std::vector<SubjectPlanRow> simulate_plan(const Study& study, const Truth& truth, const Windows& windows,
                                          const SubjectPlanParams& params);

/// What no number of subjects can better: the levels of a column that are equivalent in truth, on average.
double find_true_width(const Study& study, const Truth& truth);

Table make_plan_table(const std::vector<SubjectPlanRow>& rows);
std::string format_plan(const std::vector<SubjectPlanRow>& rows, double true_width);

/// plan.csv, plan.svg and plan.pdf. errors: InputError without gnuplot, StoreError
void write_plan(const std::vector<SubjectPlanRow>& rows, const std::filesystem::path& folder);

}  // namespace equilux
