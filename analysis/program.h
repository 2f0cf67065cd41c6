// The verbs of equilux-analyze, as its main and the tests call them.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "analysis/plan.h"
#include "analysis/report.h"

namespace equilux {

struct AnalyzeParams {
  std::vector<std::filesystem::path> study_folders;  ///< one for `prune`; several of one study are pooled
  std::filesystem::path out;                         ///< of the report; empty: report/ of the first folder
  std::optional<SubjectKind> kind;                   ///< empty: the only one with finished artifact sessions
  Rule rule = Rule::kPaper;
  UncertaintyParams uncertainty;
  bool plot = true;    ///< draw figure-*.svg and figure-*.pdf by gnuplot
  bool force = false;  ///< export may replace files that differ; a report those that no report wrote
  bool verify = true;  ///< refuse pictures that are not those recorded; false: warn in the report
};

/// Reads study folders: those of one study (of equal digest) are pooled, other studies stand beside it.
/// errors: InputError, also without finished artifact sessions, for a folder given twice, for answers of
/// several kinds, and where a picture of a manifest does not verify.
std::vector<Report> load_reports(const AnalyzeParams& params);

/// Prunes the study of a folder and prints what goes on. Gives the exit code. errors: InputError, StoreError
int run_prune(const AnalyzeParams& params);

/// Writes report/, from which files of an earlier report go, and prints the EE table. Gives the exit code.
/// errors: InputError, also, unless `params.force`, where the report would replace what no report wrote: then
/// nothing is written; StoreError
int run_report(const AnalyzeParams& params);

/// Writes answers.csv and its csv-metadata.json into a folder. Gives the exit code. errors: InputError, also,
/// unless `params.force`, where one of them is there with other bytes: then nothing is written; StoreError
int run_export(const AnalyzeParams& params);

/// Simulates and prints how many subjects a study needs; `source` is a study file or folder, `out` a folder
/// for the table and the plot, empty for none. Gives the exit code. errors: InputError, StoreError
int run_plan(const std::filesystem::path& source, const SubjectPlanParams& params,
             const std::filesystem::path& out);

/// Writes windows.json under a new name, from the artifact answers of the folder, or from `prediction` (CSV)
/// where it is not empty. Gives the exit code. errors: InputError, also where `params.out` is there,
/// StoreError
int run_windows(const AnalyzeParams& params, const std::filesystem::path& prediction);

}  // namespace equilux
