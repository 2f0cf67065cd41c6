// How many subjects a study needs: studies simulated from its planted truth, judged by the same rules.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/csv.h"
#include "analysis/thresholds.h"
#include "base/json.h"
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
  /// In the material experiment. shape: as `subjects`, or one for all; empty: the same numbers
  std::vector<int> material_subjects = {};
};

/// A mean over simulated studies.
struct SimulatedShare {
  double value = 0;
  std::optional<double>
      standard_error;  ///< Monte Carlo's, of a ratio of sums over studies; empty of one study
};

/// What so many subjects give, over studies.
struct SubjectPlanRow {
  int subjects = 0;
  int material_subjects = 0;
  SimulatedShare false_flags;  ///< share of cells below the cut in truth that are flagged
  SimulatedShare power;        ///< share of cells at the cut or above in truth that are flagged
  SimulatedShare cuts_right;   ///< share of columns whose artifact cut is the truth's
  SimulatedShare ee_right;     ///< share of columns whose EE is the truth's
  SimulatedShare green_width;  ///< equivalent levels of a column
  SimulatedShare supported;    ///< equivalent levels of a column that are supported
};

/// True proportion correct in a cell: one half and the lapse rate are its ends, and 75 % before lapses lies
/// between the last level with a visible difference and the next. source: 2AFC with a logistic function,
/// Kingdom and Prins 2010, chapter 4.
double eval_proportion(const PlantedColumn& planted, Experiment experiment, int level, double slope,
                       double lapse_rate);

/// One row for each number of subjects. errors: InputError for numbers of the material experiment that are
/// neither one nor as many.
std::vector<SubjectPlanRow> simulate_plan(const Study& study, const Truth& truth, const Windows& windows,
                                          const SubjectPlanParams& params);

/// What no number of subjects can better: the levels of a column that are equivalent in truth, on average.
double find_true_width(const Study& study, const Truth& truth);

Table make_plan_table(const std::vector<SubjectPlanRow>& rows);
std::string format_plan(const std::vector<SubjectPlanRow>& rows, double true_width);

/// plan.json: the rows and all that they depend on.
Json make_plan_json(const Study& study, const Truth& truth, const Windows& windows,
                    const SubjectPlanParams& params, const std::vector<SubjectPlanRow>& rows);

/// plan.csv with its dictionary, plan.json, plan.svg and plan.pdf. errors: InputError without gnuplot,
/// StoreError
void write_plan(const std::vector<SubjectPlanRow>& rows, const Json& json,
                const std::filesystem::path& folder);

}  // namespace equilux
