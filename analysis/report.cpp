// Evidence to a report, and a report to report/.
#include "analysis/report.h"

#include <set>

#include "analysis/graph.h"
#include "analysis/tables.h"
#include "base/error.h"
#include "base/files.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

std::set<std::string> digests_of(const std::vector<SessionRow>& sessions,
                                 std::string SessionDigests::*member) {
  std::set<std::string> digests;
  for (const SessionRow& session : sessions) digests.insert(session.digests.*member);
  return digests;
}

void warn_of_digests(std::vector<std::string>& warnings, const std::vector<SessionRow>& sessions,
                     std::string SessionDigests::*member, const std::string& now, const std::string& what) {
  const auto used = digests_of(sessions, member);
  if (used.empty() || used == std::set<std::string>{now}) return;
  warnings.push_back(fmt::format("Some sessions used {} other than the one in the folder now ({}...).", what,
                                 now.substr(0, 12)));
}

void warn_of_selection(Report& report) {
  const auto& sessions = report.evidence.material.finished;
  if (sessions.empty()) return;
  if (!report.selection) {
    report.warnings.push_back(fmt::format(
        "The selection that the material sessions used is missing: there is no selection-{}.json.",
        format_kind(report.evidence.kind)));
    return;
  }
  warn_of_digests(report.warnings, sessions, &SessionDigests::selection, digest_selection(*report.selection),
                  "a selection");
  if (report.selection->answers_digest != report.evidence.artifact.digest) {
    report.warnings.push_back(
        "The selection was pruned from other artifact answers than those counted here: artifact sessions "
        "were "
        "finished after pruning. The levels that the material experiment tested follow the earlier answers.");
  }
}

void warn_of_placeholders(Report& report) {
  if (!report.windows) return;
  std::size_t placeholders = 0;
  for (const auto& [column, window] : report.windows->by_column) {
    placeholders += window.origin == WindowOrigin::kPlaceholder ? 1 : 0;
  }
  if (placeholders == 0) return;
  report.warnings.push_back(fmt::format(
      "The clamp windows of {} of {} columns are placeholders: no pilot, prediction or eye chose them.",
      placeholders, report.windows->by_column.size()));
}

void warn_of_uneven_cells(Report& report, const Tally& tally, Experiment experiment) {
  std::set<std::int64_t> sizes;
  for (const auto& [cell, count] : tally) {
    if (count.n > 0) sizes.insert(count.n);
  }
  if (sizes.size() < 2) return;
  report.warnings.push_back(fmt::format("Cells of the {} experiment have between {} and {} answers.",
                                        format_experiment(experiment), *sizes.begin(), *sizes.rbegin()));
}

void warn_of_other_study(Report& report) {
  if (report.manifest && report.manifest->study_digest != report.study.digest) {
    report.warnings.push_back("The manifest belongs to another version of the study.");
  }
}

}  // namespace

Report make_report(const Study& study, Evidence evidence, Rule rule, ReportSources sources) {
  Report report;
  report.study = study;
  report.evidence = std::move(evidence);
  report.rule = rule;
  report.artifact = tally_answers(report.evidence.artifact.answers, study);
  report.material = tally_answers(report.evidence.material.answers, study);
  report.selection = std::move(sources.selection);
  report.windows = std::move(sources.windows);
  report.manifest = std::move(sources.manifest);
  report.convergences = std::move(sources.convergences);
  report.findings = find_equivalence(study, report.artifact, report.material,
                                     report.selection ? &*report.selection : nullptr);
  warn_of_other_study(report);
  for (const ConvergenceExhibit& exhibit : report.convergences) {
    if (exhibit.convergence.source != study.name)
      report.warnings.push_back(
          fmt::format("Error against run time of {} was measured of {}, not of this study.",
                      exhibit.convergence.condition, exhibit.convergence.source));
  }
  if (report.windows) {
    warn_of_digests(report.warnings, report.evidence.artifact.finished, &SessionDigests::windows,
                    report.windows->digest, "a windows.json");
  }
  warn_of_selection(report);
  warn_of_placeholders(report);
  warn_of_uneven_cells(report, report.artifact, Experiment::kArtifact);
  warn_of_uneven_cells(report, report.material, Experiment::kMaterial);
  return report;
}

fs::path write_report(const Report& report, const fs::path& folder) {
  make_folder(folder);
  save_text(folder / "cells.csv",
            format_csv(make_cells_table(report.study, report.artifact, report.material)));
  save_text(folder / "thresholds.csv", format_csv(make_thresholds_table(report.findings)));
  save_text(folder / "ee.csv", format_csv(make_ee_table(report.findings)));
  for (const Object& object : enumerate_objects(report.study)) {
    save_text(folder / fmt::format("graph-{}.svg", format_key(object)),
              draw_graph(object, findings_of(report.findings, object), report.rule));
  }
  fs::path page = folder / "index.html";
  save_text(page, format_page(report));
  return page;
}

}  // namespace equilux
