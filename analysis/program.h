// The verbs of equilux-analyze, as its main and the tests call them.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "analysis/report.h"

namespace equilux {

struct AnalyzeParams {
  std::vector<std::filesystem::path> study_folders;  ///< one for `prune`; several of one study are pooled
  std::filesystem::path out;                         ///< of the report; empty: report/ of the first folder
  std::optional<SubjectKind> kind;                   ///< empty: the only one with finished artifact sessions
  Rule rule = Rule::kPaper;
  UncertaintyParams uncertainty;
  bool verify = true;  ///< refuse pictures that are not those recorded; false: warn in the report
};

/// Reads study folders: those of one study (of equal digest) are pooled, other studies stand beside it.
/// errors: InputError, also without finished artifact sessions, for a folder given twice, for answers of
/// several kinds, and where a picture of a manifest does not verify.
std::vector<Report> load_reports(const AnalyzeParams& params);

/// Prunes the study of a folder and prints what goes on. Gives the exit code. errors: InputError, StoreError
int run_prune(const AnalyzeParams& params);

/// Writes report/ and prints the EE table. Gives the exit code. errors: InputError, StoreError
int run_report(const AnalyzeParams& params);

}  // namespace equilux
