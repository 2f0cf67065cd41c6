// The verbs of equilux-analyze, as its main and the tests call them.
#pragma once

#include <filesystem>
#include <optional>

#include "analysis/report.h"

namespace equilux {

struct AnalyzeParams {
  std::filesystem::path study_folder;
  std::optional<SubjectKind> kind;  ///< empty: the only one with finished artifact sessions
  Rule rule = Rule::kPaper;
  bool verify = true;  ///< refuse pictures that are not those recorded; false: warn in the report
};

/// Reads a study folder. errors: InputError, also without finished artifact sessions, and where a picture of
/// the manifest does not verify.
Report load_report(const AnalyzeParams& params);

/// Prunes the study of a folder and prints what goes on. Gives the exit code. errors: InputError, StoreError
int run_prune(const AnalyzeParams& params);

/// Writes report/ and prints the EE table. Gives the exit code. errors: InputError, StoreError
int run_report(const AnalyzeParams& params);

}  // namespace equilux
