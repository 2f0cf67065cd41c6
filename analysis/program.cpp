// The two subcommands: read the folder, compute, write, say so.
#include "analysis/program.h"

#include <cstdio>
#include <set>

#include "analysis/prune.h"
#include "analysis/tables.h"
#include "base/error.h"
#include "base/files.h"
#include "base/program.h"
#include "stimuli/verify_pictures.h"

namespace equilux {
namespace {

template <typename T, typename Load>
std::optional<T> load_if_there(const std::filesystem::path& path, const Load& load) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  return load(path);
}

// Of all conditions that were measured, by name.
std::vector<ConvergenceExhibit> load_convergences(const std::filesystem::path& folder) {
  std::vector<ConvergenceExhibit> exhibits;
  if (!std::filesystem::is_directory(folder)) return exhibits;
  std::set<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".json") files.insert(entry.path());
  }
  for (std::filesystem::path file : files) {
    ConvergenceExhibit exhibit{load_convergence(file), ""};
    file.replace_extension(".svg");
    if (std::filesystem::exists(file)) exhibit.svg = load_text(file);
    exhibits.push_back(std::move(exhibit));
  }
  return exhibits;
}

std::string describe_sessions(const ExperimentEvidence& evidence, Experiment experiment) {
  return fmt::format("{}: {} finished sessions, {} unfinished left out, {} answers\n",
                     format_experiment(experiment), evidence.finished.size(), evidence.unfinished,
                     evidence.answers.size());
}

std::string describe_outcome(PruneOutcome outcome, const std::string& path) {
  switch (outcome) {
    case PruneOutcome::kWritten:
      return fmt::format("wrote {}\n", path);
    case PruneOutcome::kUnchanged:
      return fmt::format("{} stands already, unchanged\n", path);
    case PruneOutcome::kFrozenEqual:
      return fmt::format("{} is frozen, since a session has used it; pruning again gives the same\n", path);
    case PruneOutcome::kFrozenOther:
      break;
  }
  return fmt::format(
      "{} is frozen, since a session has used it; pruning again would give the above instead. "
      "Nothing was changed.\n",
      path);
}

// What was rendered, which may be less than the study has.
std::vector<Finding> verify_manifest(const StudyFolder& folder, const Study& study,
                                     const std::optional<Manifest>& manifest) {
  if (!manifest) return {};
  std::vector<std::string> keys;
  for (const auto& [key, picture] : manifest->pictures) keys.push_back(key);
  return verify_pictures(folder, study, *manifest, keys);
}

}  // namespace

Report load_report(const AnalyzeParams& params) {
  const StudyFolder folder{params.study_folder};
  const Study study = load_folder_study(folder);
  Evidence evidence = load_evidence(folder, study, params.kind);
  ReportSources sources;
  sources.selection = load_if_there<Selection>(
      folder.selection(evidence.kind),
      [&](const std::filesystem::path& path) { return load_selection(path, study); });
  sources.windows = load_if_there<Windows>(
      folder.windows(), [&](const std::filesystem::path& path) { return load_windows(path, study); });
  sources.manifest = load_if_there<Manifest>(
      folder.manifest(), [](const std::filesystem::path& path) { return load_manifest(path); });
  sources.convergences = load_convergences(folder.convergence_folder());
  const std::vector<Finding> findings = verify_manifest(folder, study, sources.manifest);
  if (params.verify) refuse_findings(findings, folder);
  Report report = make_report(study, std::move(evidence), params.rule, std::move(sources));
  if (!findings.empty())
    report.warnings.push_back(fmt::format("Of the pictures {} do not verify, the first {}", findings.size(),
                                          format_finding(findings.front())));
  return report;
}

int run_prune(const AnalyzeParams& params) {
  const StudyFolder folder{params.study_folder};
  const Study study = load_folder_study(folder);
  const Evidence evidence = load_evidence(folder, study, params.kind);
  const Selection fresh = make_selection(study, tally_answers(evidence.artifact.answers, study),
                                         evidence.kind, params.rule, evidence.artifact.digest);
  const auto path = folder.selection(evidence.kind);
  std::optional<Selection> standing;
  if (std::filesystem::exists(path)) standing = load_selection(path, study);
  const auto used = find_used_selections(TrialLog(folder.responses()), evidence.kind);
  const PruneOutcome outcome = decide_pruning(fresh, standing, used);
  if (outcome == PruneOutcome::kWritten) save_selection(fresh, path);
  fmt::print("{}{}{}", describe_sessions(evidence.artifact, Experiment::kArtifact),
             format_selection(fresh, study), describe_outcome(outcome, path.string()));
  return outcome == PruneOutcome::kFrozenOther ? kExitError : kExitOk;
}

int run_report(const AnalyzeParams& params) {
  const StudyFolder folder{params.study_folder};
  const Report report = load_report(params);
  const auto page = write_report(report, folder.report_folder());
  fmt::print("{}{}", describe_sessions(report.evidence.artifact, Experiment::kArtifact),
             describe_sessions(report.evidence.material, Experiment::kMaterial));
  if (report.evidence.kind == SubjectKind::kPlanted) {
    fmt::print("PLANTED answers: they tell nothing about these pictures\n");
  }
  for (const std::string& warning : report.warnings) fmt::print("warning: {}\n", warning);
  fmt::print("{}report: {}\n", format_ee_text(report.study, report.findings, report.rule), page.string());
  return kExitOk;
}

}  // namespace equilux
