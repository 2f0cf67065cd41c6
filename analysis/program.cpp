// The two subcommands: read the folder, compute, write, say so.
#include "analysis/program.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <future>
#include <malloc.h>
#include <map>
#include <set>
#include <thread>

#include "analysis/answers_export.h"
#include "analysis/figure.h"
#include "analysis/pool.h"
#include "analysis/prune.h"
#include "analysis/report_tables.h"
#include "analysis/tables.h"
#include "analysis/warnings.h"
#include "analysis/window_choice.h"
#include "analysis/words.h"
#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "base/program.h"
#include "protocols/session_protocol.h"
#include "stimuli/verdict.h"

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
  return fmt::format("{}: {}, {} unfinished left out, {}\n", format_experiment(experiment),
                     format_count(evidence.finished.size(), "finished session"), evidence.unfinished,
                     format_count(evidence.answers.size(), "answer"));
}

std::string list_digests(const std::vector<std::string>& digests) {
  std::vector<std::string> parts;
  for (const std::string& digest : digests) parts.push_back(digest.substr(0, 12) + "...");
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string describe_outcome(PruneOutcome outcome, const std::string& path,
                             const std::vector<std::string>& used) {
  switch (outcome) {
    case PruneOutcome::kMissingOther:
      return fmt::format(
          "{} is missing, and sessions have used one of digest {}; pruning again would give the above "
          "instead. Put the one that was used back. Nothing was written.\n",
          path, list_digests(used));
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
  if (auto found = find_verdict(folder); !found.empty()) return found;
  if (!manifest) return {};
  std::vector<std::string> keys;
  for (const auto& [key, picture] : manifest->pictures) keys.push_back(key);
  return verify_pictures(folder, study, *manifest, keys);
}

// Answers about pictures that are not those recorded decide nothing.
void refuse_unverified(const StudyFolder& folder, const Study& study, const AnalyzeParams& params) {
  if (!params.verify) return;
  const auto manifest = load_if_there<Manifest>(
      folder.manifest(), [](const std::filesystem::path& path) { return load_manifest(path); });
  refuse_findings(verify_manifest(folder, study, manifest), folder);
}

// A study folder as it was found.
struct FolderReading {
  std::string name;
  Study study;
  std::optional<Evidence> evidence;  ///< empty: no finished artifact sessions; read_unfinished fills it
  ReportSources sources;
  std::vector<std::string> warnings;
};

ReportSources load_sources(const StudyFolder& folder, const Study& study, SubjectKind kind) {
  ReportSources sources;
  sources.selection = load_if_there<Selection>(
      folder.selection(kind), [&](const std::filesystem::path& path) { return load_selection(path, study); });
  sources.windows = load_if_there<Windows>(
      folder.windows(), [&](const std::filesystem::path& path) { return load_windows(path, study); });
  sources.manifest = load_if_there<Manifest>(
      folder.manifest(), [](const std::filesystem::path& path) { return load_manifest(path); });
  sources.protocol = load_if_there<SessionProtocol>(
      folder.session(), [](const std::filesystem::path& path) { return load_session_protocol(path); });
  if (kind == SubjectKind::kPlanted) {
    sources.truth = load_if_there<Truth>(
        folder.truth(), [&](const std::filesystem::path& path) { return load_truth(path, study); });
  }
  sources.convergences = load_convergences(folder.convergence_folder());
  return sources;
}

// Some that are counted.
bool has_answers(const FolderReading& reading) {
  return !reading.evidence->artifact.finished.empty() || !reading.evidence->material.finished.empty();
}

// Cells with answers of which the manifest has no picture in any view.
std::set<Cell> find_unpictured(const FolderReading& reading, const Manifest& manifest) {
  std::set<Cell> unpictured;
  for (const ExperimentEvidence* experiment : {&reading.evidence->artifact, &reading.evidence->material}) {
    const Answers& answers = experiment->answers;
    std::vector<char> is_counted(answers.cells().size(), 0);
    for (const CountedAnswer& answer : answers.rows()) is_counted[answer.cell] = 1;
    for (std::size_t cell = 0; cell < is_counted.size(); ++cell) {
      if (is_counted[cell]) unpictured.insert(answers.cells()[cell]);
    }
  }
  std::erase_if(unpictured, [&](const Cell& cell) {
    for (int view = 0; view < kViewCount; ++view) {
      if (manifest.pictures.contains(format_key(Condition{cell, view}))) return true;
    }
    return false;
  });
  return unpictured;
}

// What cannot be asked of pictures that are not there.
void warn_of_absent_pictures(FolderReading& reading) {
  if (!has_answers(reading)) return;
  if (!reading.sources.manifest) {
    reading.warnings.push_back(
        "There is no manifest.json: that answers are about pictures of this study was not checked.");
    return;
  }
  const std::set<Cell> unpictured = find_unpictured(reading, *reading.sources.manifest);
  if (!unpictured.empty())
    reading.warnings.push_back(fmt::format("Of {} with answers the manifest has no picture, the first {}.",
                                           format_count(unpictured.size(), "cell"),
                                           format_key(*unpictured.begin())));
}

void add_sources(FolderReading& reading, const StudyFolder& folder, const AnalyzeParams& params) {
  reading.sources = load_sources(folder, reading.study, reading.evidence->kind);
  reading.sources.artifact_prompts =
      load_prompts(folder.root, reading.evidence->artifact, Experiment::kArtifact);
  reading.sources.material_prompts =
      load_prompts(folder.root, reading.evidence->material, Experiment::kMaterial);
  reading.warnings = find_source_warnings(reading.study, *reading.evidence, reading.sources);
  warn_of_absent_pictures(reading);
  const std::vector<Finding> findings = verify_manifest(folder, reading.study, reading.sources.manifest);
  if (params.verify && has_answers(reading)) refuse_findings(findings, folder);
  if (!findings.empty())
    reading.warnings.push_back(fmt::format("Of the pictures {} {} not verify, the first {}", findings.size(),
                                           choose_form(findings.size(), "does", "do"),
                                           format_finding(findings.front())));
}

FolderReading read_folder(const StudyFolder& folder, const AnalyzeParams& params) {
  FolderReading reading;
  reading.name = folder.root.generic_string();
  reading.study = load_folder_study(folder);
  reading.evidence = find_evidence(folder, reading.study, params.kind);
  if (reading.evidence) add_sources(reading, folder, params);
  return reading;
}

// In a pool a log that nobody has finished says who was left out; by itself it is refused.
void read_unfinished(std::vector<FolderReading>& readings, const AnalyzeParams& params) {
  const auto first = std::find_if(readings.begin(), readings.end(),
                                  [](const FolderReading& reading) { return reading.evidence.has_value(); });
  for (FolderReading& reading : readings) {
    if (reading.evidence) continue;
    const StudyFolder folder{reading.name};
    if (first == readings.end()) {  // refused, unless a session was finished since it was read
      reading.evidence = load_evidence(folder, reading.study, params.kind);
      add_sources(reading, folder, params);
      continue;
    }
    const SubjectKind kind = first->evidence->kind;
    reading.evidence = load_evidence_of(folder, reading.study, kind);
    add_sources(reading, folder, params);
    const std::size_t material = reading.evidence->material.finished.size();
    reading.warnings.push_back(fmt::format(
        "No artifact session of the kind {} is finished here: {}, {}.", format_kind(kind),
        format_count(reading.evidence->artifact.unfinished, "unfinished one"),
        material == 0 ? "none to count"
                      : fmt::format("and {}, which {}", format_count(material, "finished material session"),
                                    choose_form(material, "counts", "count"))));
  }
}

// Sorted, so that the order on the command line changes nothing.
std::vector<std::filesystem::path> sort_folders(const std::vector<std::filesystem::path>& folders) {
  std::set<std::filesystem::path> sorted, real;
  for (const std::filesystem::path& folder : folders) {
    const auto path = (folder / "").lexically_normal().parent_path();
    sorted.insert(path.empty() ? folder : path);
    if (!real.insert(std::filesystem::weakly_canonical(folder / "")).second)
      throw InputError(folder.string(), "", "each study folder once", "the same again");
  }
  return {sorted.begin(), sorted.end()};
}

// What a log took is given to the next, not to the system and asked for again page by page.
void keep_freed_memory() {
  constexpr int kMost = 64 << 20, kLargest = 8 << 20;
  ::mallopt(M_TRIM_THRESHOLD, kMost);
  ::mallopt(M_MMAP_THRESHOLD, kLargest);
}

// Logs are read side by side, each by one thread, the next one by whichever has finished its last.
std::vector<FolderReading> read_folders(const AnalyzeParams& params) {
  const auto folders = sort_folders(params.study_folders);
  keep_freed_memory();
  std::vector<FolderReading> readings(folders.size());
  const std::size_t threads =
      std::min<std::size_t>(folders.size(), std::max(1U, std::thread::hardware_concurrency()));
  std::atomic<std::size_t> next{0};
  std::vector<std::future<void>> running;
  for (std::size_t thread = 0; thread < threads; ++thread) {
    running.push_back(std::async(std::launch::async, [&] {
      for (std::size_t i = next++; i < folders.size(); i = next++)
        readings[i] = read_folder(StudyFolder{folders[i]}, params);
    }));
  }
  for (auto& future : running) future.wait();
  for (auto& future : running) future.get();
  return readings;
}

// What stands beside answers that are counted; a folder without any has no say.
ReportSources pool_counted(const std::vector<FolderReading>& readings, std::vector<std::string>& warnings) {
  std::vector<PoolPart> parts;
  std::vector<ReportSources> sources;
  std::vector<std::string> names;
  std::vector<ConvergenceExhibit> exhibits;
  for (const FolderReading& reading : readings) {
    if (!has_answers(reading)) {
      exhibits.insert(exhibits.end(), reading.sources.convergences.begin(),
                      reading.sources.convergences.end());
      continue;
    }
    parts.push_back({reading.name, *reading.evidence, reading.sources});
    sources.push_back(reading.sources);
    names.push_back(reading.name);
  }
  for (const std::string& warning : find_pool_warnings(parts)) warnings.push_back(warning);
  ReportSources all = pool_sources(std::move(sources), names);
  all.convergences.insert(all.convergences.end(), exhibits.begin(), exhibits.end());
  return all;
}

Report pool_readings(std::vector<FolderReading> readings, const AnalyzeParams& params) {
  read_unfinished(readings, params);
  std::vector<std::string> names, warnings;
  std::vector<Evidence> evidence;
  ReportSources sources = pool_counted(readings, warnings);
  for (FolderReading& reading : readings) {
    for (const std::string& warning : reading.warnings)
      warnings.push_back(readings.size() > 1 ? reading.name + ": " + warning : warning);
    names.push_back(reading.name);
    evidence.push_back(std::move(*reading.evidence));
  }
  Evidence pool = pool_evidence(std::move(evidence), names);
  for (std::string& warning : find_repeater_warnings(pool)) warnings.push_back(std::move(warning));
  Report report = make_pooled_report(readings.front().study, std::move(pool), params.rule, std::move(sources),
                                     params.uncertainty, warnings);
  if (names.size() > 1) report.folders = names;
  return report;
}

void check_kinds(const std::vector<Report>& reports) {
  for (const Report& report : reports) {
    if (report.evidence.kind == reports.front().evidence.kind) continue;
    throw InputError(report.study.name, "",
                     fmt::format("answers of the kind {}, as of {}, or --kind to choose",
                                 format_kind(reports.front().evidence.kind), reports.front().study.name),
                     format_kind(report.evidence.kind));
  }
}

void print_study(const Report& report, bool alone) {
  if (!alone) fmt::print("study {}\n", report.study.name);
  fmt::print("{}{}", describe_sessions(report.evidence.artifact, Experiment::kArtifact),
             describe_sessions(report.evidence.material, Experiment::kMaterial));
  if (report.evidence.kind == SubjectKind::kPlanted)
    fmt::print("PLANTED answers: they tell nothing about these pictures\n");
  for (const std::string& warning : report.warnings) fmt::print("warning: {}\n", warning);
  fmt::print("{}", format_ee_text(report.study, report.findings, report.rule));
  for (const Trend& trend : report.trends) {
    if (trend.holds) fmt::print("trend: {}\n", describe_trend(trend));
  }
}

// Made again the export has the same bytes: a file with others is something else.
void check_can_save(const std::filesystem::path& path, const std::string& bytes) {
  if (!path_exists(path)) return;
  if (!is_file(path)) throw InputError(path.string(), "", "a file's name", "another kind's");
  if (digest_file(path) != digest_text(bytes))
    throw InputError(path.string(), "", "a free name or a file with the same bytes",
                     "one with others; --force replaces an earlier export");
}

void save_answers(const std::map<std::string, std::string>& files, const std::filesystem::path& folder,
                  bool force) {
  for (const auto& [name, bytes] : files) {
    if (!force) check_can_save(folder / name, bytes);
  }
  make_folder(folder);
  for (const auto& [name, bytes] : files) save_text(folder / name, bytes);
}

// What no report wrote, or somebody changed since.
std::string describe_others(const std::vector<std::string>& others) {
  if (others.empty()) return "";
  return fmt::format("not of this report, left as found: {}{}\n", others.front(),
                     others.size() > 1 ? fmt::format(" and {} more", others.size() - 1) : "");
}

// Studies by their digests. Files of a report are named by the study.
void check_names(const std::map<std::string, std::vector<FolderReading>>& by_study) {
  std::map<std::string, const FolderReading*> firsts;
  for (const auto& [digest, readings] : by_study) {
    const FolderReading& first = readings.front();
    const auto [entry, is_new] = firsts.try_emplace(first.study.name, &first);
    if (is_new) continue;
    throw InputError(
        first.name, "study.json",
        fmt::format("the study {} as in {}, or another name", first.study.name, entry->second->name),
        "one of that name with another digest");
  }
}

}  // namespace

std::vector<Report> load_reports(const AnalyzeParams& params) {
  std::map<std::string, std::vector<FolderReading>> by_study;
  auto all = read_folders(params);
  for (FolderReading& reading : all) by_study[reading.study.digest].push_back(std::move(reading));
  check_names(by_study);
  std::vector<Report> reports;
  for (auto& [digest, readings] : by_study) reports.push_back(pool_readings(std::move(readings), params));
  sort_reports(reports);
  check_kinds(reports);
  add_normalisation_trends(reports);
  return reports;
}

int run_prune(const AnalyzeParams& params) {
  const StudyFolder folder{params.study_folders.front()};
  const Study study = load_folder_study(folder);
  const Evidence evidence = load_evidence(folder, study, params.kind);
  refuse_unverified(folder, study, params);
  const Selection fresh = make_selection(study, tally_answers(evidence.artifact.answers, study),
                                         evidence.kind, params.rule, evidence.artifact.digest);
  const auto path = folder.selection(evidence.kind);
  std::optional<Selection> standing;
  if (std::filesystem::exists(path)) standing = load_selection(path, study);
  const auto used = find_used_selections(TrialLog::load_snapshot(folder.responses()), evidence.kind);
  const PruneOutcome outcome = decide_pruning(fresh, standing, used);
  if (outcome == PruneOutcome::kWritten) save_selection(fresh, path);
  fmt::print("{}{}{}", describe_sessions(evidence.artifact, Experiment::kArtifact),
             format_selection(fresh, study), describe_outcome(outcome, path.string(), used));
  const bool is_other = outcome == PruneOutcome::kFrozenOther || outcome == PruneOutcome::kMissingOther;
  return is_other ? kExitError : kExitOk;
}

int run_report(const AnalyzeParams& params) {
  const auto reports = load_reports(params);
  const StudyFolder first{params.study_folders.front()};
  const auto folder = params.out.empty() ? first.report_folder() : params.out;
  ReportFiles files = make_report_files(reports);
  if (params.plot) files.merge(draw_figures(reports));
  const auto others = save_report(files, folder, params.force);
  for (const Report& report : reports) print_study(report, reports.size() == 1);
  fmt::print("report: {}\n{}", (folder / kReportPage).string(), describe_others(others));
  return kExitOk;
}

int run_export(const AnalyzeParams& params) {
  AnalyzeParams cheap = params;
  cheap.uncertainty = {params.uncertainty.seed, 1, 1};
  const auto reports = load_reports(cheap);
  const ReportTable table{"answers.csv", make_answers_table(reports)};
  save_answers(
      {{table.file, format_csv(table.table)}, {"csv-metadata.json", format_json(make_csv_metadata({table}))}},
      params.out, params.force);
  fmt::print("{}: {}\n", format_count(table.table.rows.size(), "answer"), (params.out / table.file).string());
  return kExitOk;
}

int run_plan(const std::filesystem::path& source, const SubjectPlanParams& params,
             const std::filesystem::path& out) {
  const Study study =
      std::filesystem::is_directory(source) ? load_folder_study(StudyFolder{source}) : load_study(source);
  const Truth truth = load_truth(study.truth_path, study);
  const Windows windows = load_windows(study.windows_path, study);
  const auto rows = simulate_plan(study, truth, windows, params);
  fmt::print(
      "study {}: {} simulated {} for each number, rule {}, slope {} levels, lapse rate {}, seed {}\n{}",
      study.name, params.studies, choose_form(params.studies, "study", "studies"), format_rule(params.rule),
      params.slope, truth.lapse_rate, params.seed, format_plan(rows, find_true_width(study, truth)));
  if (out.empty()) return kExitOk;
  write_plan(rows, make_plan_json(study, truth, windows, params, rows), out);
  fmt::print("wrote plan.csv, plan.csv-metadata.json, plan.json, plan.svg and plan.pdf to {}\n",
             out.string());
  return kExitOk;
}

int run_windows(const AnalyzeParams& params, const std::filesystem::path& prediction) {
  const StudyFolder folder{params.study_folders.front()};
  const Study study = load_folder_study(folder);
  if (path_exists(params.out))
    throw InputError(params.out.string(), "", "a name that is free: windows may be edited by hand", "a file");
  const Windows standing = load_windows(folder.windows(), study);
  const bool predicted = !prediction.empty();
  if (!predicted) refuse_unverified(folder, study, params);
  const Tally tally = predicted
                          ? parse_prediction(load_text(prediction), prediction.string(), study)
                          : tally_answers(load_evidence(folder, study, params.kind).artifact.answers, study);
  const auto windows = choose_windows(study, tally, standing, params.rule,
                                      predicted ? WindowOrigin::kPredicted : WindowOrigin::kPilot);
  save_text(params.out, format_windows(windows, study,
                                       predicted ? "Chosen from a predicted visibility; edit by hand."
                                                 : "Chosen from a pilot's answers; edit by hand."));
  load_windows(params.out, study);
  std::size_t moved = 0;
  for (const auto& [column, window] : windows)
    moved += window.first_level != standing.by_column.at(column).first_level ? 1 : 0;
  fmt::print("{} windows, {} of them other than now: {}\n", windows.size(), moved, params.out.string());
  return kExitOk;
}

}  // namespace equilux
