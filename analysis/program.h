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
};

/// Reads a study folder. errors: InputError, also without finished artifact sessions.
Report load_report(const StudyFolder& folder, std::optional<SubjectKind> kind, Rule rule);

/// Prunes the study of a folder and prints what goes on. Gives the exit code. errors: InputError, StoreError
int run_prune(const AnalyzeParams& params);

/// Writes report/ and prints the EE table. Gives the exit code. errors: InputError, StoreError
int run_report(const AnalyzeParams& params);

}  // namespace equilux
