// A report: evidence, findings and warnings as values, and then as files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/equivalence.h"
#include "analysis/evidence.h"
#include "stimuli/convergence.h"
#include "stimuli/manifest.h"

namespace equilux {

/// Error against run time of a condition, and its plot.
struct ConvergenceExhibit {
  Convergence convergence;
  std::string svg;  ///< empty: it was not drawn
};

/// Everything that a report says, before it is drawn. Pure: no clock, no file.
struct Report {
  Study study;
  Evidence evidence;
  Rule rule = Rule::kPaper;  ///< of the graphs and the EE table; the CSV files hold both
  Tally artifact;
  Tally material;
  std::vector<ColumnFinding> findings;
  std::optional<Selection> selection;
  std::optional<Windows> windows;
  std::optional<Manifest> manifest;
  std::vector<ConvergenceExhibit> convergences;
  std::vector<std::string> warnings;  ///< legal, but a reader should know
};

/// What stands beside the answers in the study folder, where it is there.
struct ReportSources {
  std::optional<Selection> selection;
  std::optional<Windows> windows;
  std::optional<Manifest> manifest;
  std::vector<ConvergenceExhibit> convergences = {};
};

/// errors: InputError for answers that the study does not allow.
Report make_report(const Study& study, Evidence evidence, Rule rule, ReportSources sources);

/// Writes cells.csv, thresholds.csv, ee.csv, a graph for each object and index.html, each only whole. The
/// bytes depend on the report and the program's version alone. Gives the path of index.html.
std::filesystem::path write_report(const Report& report, const std::filesystem::path& folder);

/// The self-contained page. shape: one HTML document with style and graphs inside.
std::string format_page(const Report& report);

}  // namespace equilux
