// A report: evidence, findings and warnings as values, and then as files.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "analysis/balance.h"
#include "analysis/cell_statistics.h"
#include "analysis/equivalence.h"
#include "analysis/evidence.h"
#include "analysis/prompts.h"
#include "analysis/report_folder.h"
#include "analysis/trends.h"
#include "analysis/uncertainty.h"
#include "protocols/session_protocol.h"
#include "protocols/truth.h"
#include "stimuli/convergence.h"
#include "stimuli/manifest.h"

namespace equilux {

/// Error against run time of a condition, and its plot.
struct ConvergenceExhibit {
  Convergence convergence;
  std::string svg;  ///< empty: it was not drawn
};

inline constexpr std::array<int, 2> kOtherPercents = {70, 80};  ///< cuts beside kFlagPercent

/// How the subjects of an experiment did.
struct SubjectsReport {
  std::vector<SubjectFinding> sessions;  ///< finished and not
  OrderEffect order;
};

/// What a folder of a pool was pruned to.
struct FolderSelection {
  std::string folder;
  std::string rule;
  std::string digest;
  std::string answers_digest;
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

  UncertaintyParams params;
  std::map<Cell, CellStatistics> artifact_cells;
  std::map<Cell, CellStatistics> material_cells;
  Uncertainty uncertainty;
  /// Findings with other cuts. shape: as kOtherPercents, then as `findings`.
  std::array<std::vector<ColumnFinding>, 2> at_other_percents;
  std::vector<Trend> trends;  ///< under `rule`
  SubjectsReport artifact_subjects;
  SubjectsReport material_subjects;
  Balance artifact_balance;
  Balance material_balance;
  /// Columns whose verdict under `rule` would be another without the marked sessions.
  std::vector<Column> flipped_without_marked;
  std::vector<FolderSelection> selections = {};  ///< as ReportSources::selections
  std::vector<std::string> folders = {};  ///< study folders that were pooled, by name; empty: not known
  std::optional<SessionProtocol> protocol = {};  ///< of the folders; empty: there is none, or several
  std::optional<Truth> truth = {};               ///< the same of the planted truth; of planted answers only
  Prompts artifact_prompts = {};                 ///< as ReportSources
  Prompts material_prompts = {};
};

/// What stands beside the answers in the study folder, where it is there.
struct ReportSources {
  std::optional<Selection> selection;
  std::optional<Windows> windows;
  std::optional<Manifest> manifest;
  std::vector<ConvergenceExhibit> convergences = {};
  std::optional<SessionProtocol> protocol = {};  ///< the folder's session.json; empty: there is none
  std::optional<Truth> truth = {};               ///< the folder's truth.json, for planted answers
  /// Of a pool whose selections differ: each folder's. `selection` then says which levels any of them keeps;
  /// its rule, cuts and digest of answers are empty where they are not the same in all.
  std::vector<FolderSelection> selections = {};
  Prompts artifact_prompts = {};  ///< in the languages of the finished sessions
  Prompts material_prompts = {};
};

/// errors: InputError for answers that the study does not allow.
Report make_report(const Study& study, Evidence evidence, Rule rule, ReportSources sources,
                   const UncertaintyParams& params = {});

/// The same of a pool of logs, whose sources were held against their answers log by log: `warnings` are what
/// was found.
Report make_pooled_report(const Study& study, Evidence evidence, Rule rule, ReportSources sources,
                          const UncertaintyParams& params, const std::vector<std::string>& warnings);

/// The studies of a report in their order of reading: most columns first, then by name. errors: InputError
/// for two of one name.
void sort_reports(std::vector<Report>& reports);

/// Adds to each normalised study the trend from each plain one that has columns of it, read together with its
/// other trends.
void add_normalisation_trends(std::vector<Report>& reports);

/// The tables of all studies together (docs/analysis.md says what each column means, and so does
/// csv-metadata.json), report.json, a graph for each object and index.html. The bytes depend on the reports
/// and the program's version alone.
ReportFiles make_report_files(const std::vector<Report>& reports);

/// The self-contained page. shape: one HTML document with style and graphs inside.
std::string format_page(const std::vector<Report>& reports);

}  // namespace equilux
