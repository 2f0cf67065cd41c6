// Evidence to a report, and a report to its files.
#include "analysis/report.h"

#include <algorithm>
#include <future>
#include <map>
#include <set>
#include <tuple>

#include "analysis/graph.h"
#include "analysis/report_tables.h"
#include "analysis/tables.h"
#include "base/error.h"

namespace equilux {
namespace {

std::set<std::string> digests_of(const std::vector<SessionRow>& sessions,
                                 std::string SessionDigests::*member) {
  std::set<std::string> digests;
  for (const SessionRow& session : sessions) digests.insert(session.digests.*member);
  return digests;
}

void warn_of_digests(std::vector<std::string>& warnings, const Evidence& evidence, Experiment experiment,
                     std::string SessionDigests::*member, const std::string& now, const std::string& what) {
  const auto& sessions = evidence.of(experiment).finished;
  const auto others = std::count_if(sessions.begin(), sessions.end(),
                                    [&](const SessionRow& row) { return row.digests.*member != now; });
  if (others == 0) return;
  warnings.push_back(fmt::format("Of {} {} sessions {} used {} other than the one in the folder now ({}...).",
                                 sessions.size(), format_experiment(experiment), others, what,
                                 now.substr(0, 12)));
}

void warn_of_selection(std::vector<std::string>& warnings, const Evidence& evidence,
                       const std::optional<Selection>& selection) {
  const auto& sessions = evidence.material.finished;
  if (sessions.empty()) return;
  if (!selection) {
    warnings.push_back(fmt::format(
        "The selection that the material sessions used is missing: there is no selection-{}.json.",
        format_kind(evidence.kind)));
    return;
  }
  warn_of_digests(warnings, evidence, Experiment::kMaterial, &SessionDigests::selection,
                  digest_selection(*selection), "a selection");
  if (selection->answers_digest != evidence.artifact.digest) {
    warnings.push_back(
        "The selection was pruned from other artifact answers than those counted here: artifact sessions "
        "were finished after pruning, or withdrawn after it, or it was pruned elsewhere. The levels that the "
        "material experiment tested follow those answers.");
  }
}

void warn_of_placeholders(std::vector<std::string>& warnings, const Windows& windows) {
  std::size_t placeholders = 0;
  for (const auto& [column, window] : windows.by_column) {
    placeholders += window.origin == WindowOrigin::kPlaceholder ? 1 : 0;
  }
  if (placeholders == 0) return;
  warnings.push_back(fmt::format(
      "The clamp windows of {} of {} columns are placeholders: no pilot, prediction or eye chose them.",
      placeholders, windows.by_column.size()));
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

void keep_if_same(auto& all, const auto& part) {
  if (all != part) all = {};
}

void pool_column(SelectedColumn& all, const SelectedColumn& part) {
  all.levels.insert(all.levels.end(), part.levels.begin(), part.levels.end());
  std::sort(all.levels.begin(), all.levels.end());
  all.levels.erase(std::unique(all.levels.begin(), all.levels.end()), all.levels.end());
  keep_if_same(all.status, part.status);
  keep_if_same(all.artifact_cut, part.artifact_cut);
}

// A column is kept where either keeps a level.
void pool_selection(Selection& all, const Selection& part) {
  keep_if_same(all.rule, part.rule);
  keep_if_same(all.answers_digest, part.answers_digest);
  for (std::size_t c = 0; c < all.columns.size(); ++c) pool_column(all.columns[c], part.columns[c]);
}

// Without a selection in one of them, nothing was dropped.
void pool_selections(ReportSources& all, const std::vector<ReportSources>& parts,
                     const std::vector<std::string>& folders) {
  std::vector<FolderSelection> selections;
  std::set<std::string> digests;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (!parts[i].selection) continue;
    const Selection& selection = *parts[i].selection;
    selections.push_back({folders[i], selection.rule, digest_selection(selection), selection.answers_digest});
    digests.insert(selections.back().digest);
  }
  const bool all_have = selections.size() == parts.size();
  if (all_have && digests.size() == 1) return;
  all.selections = std::move(selections);
  if (!all_have) {
    all.selection.reset();
    return;
  }
  for (const ReportSources& part : parts) pool_selection(*all.selection, *part.selection);
}

// Pictures that both have, and those of them that differ.
struct PictureComparison {
  std::size_t common = 0, different = 0;
  std::string first;
};

PictureComparison compare_pictures(const Manifest& one, const Manifest& other) {
  PictureComparison sum;
  for (const auto& [key, picture] : one.pictures) {
    const auto same = other.pictures.find(key);
    if (same == other.pictures.end()) continue;
    ++sum.common;
    if (same->second.digest == picture.digest) continue;
    ++sum.different;
    if (sum.first.empty()) sum.first = key;
  }
  return sum;
}

bool are_same_pictures(const std::optional<Manifest>& one, const std::optional<Manifest>& other) {
  if (!one || !other) return !one && !other;
  const PictureComparison sum = compare_pictures(*one, *other);
  return one->seed == other->seed && sum.different == 0 && sum.common == one->pictures.size() &&
         sum.common == other->pictures.size();
}

// Against the first folder that has a manifest.
bool warn_of_manifests(std::vector<std::string>& warnings, const std::vector<PoolPart>& parts) {
  const PoolPart* first = nullptr;
  bool found = false;
  for (const PoolPart& part : parts) {
    if (!part.sources.manifest) continue;
    if (!first) {
      first = &part;
      continue;
    }
    const PictureComparison sum = compare_pictures(*first->sources.manifest, *part.sources.manifest);
    if (sum.different == 0) continue;
    found = true;
    warnings.push_back(
        fmt::format("Answers about different pictures are added up: of {} pictures that {} and {} both have, "
                    "{} differ, the first {}.",
                    sum.common, first->folder, part.folder, sum.different, sum.first));
  }
  return found;
}

// Folders by a digest, told in a sentence: "a (0123456789ab...); b, c (ba9876543210...)".
using FoldersByDigest = std::map<std::string, std::vector<std::string>>;

std::string list_folders(const FoldersByDigest& folders) {
  std::vector<std::string> groups;
  for (const auto& [digest, names] : folders)
    groups.push_back(fmt::format("{} ({}...)", fmt::join(names, ", "), digest.substr(0, 12)));
  return fmt::format("{}", fmt::join(groups, "; "));
}

// By what sessions recorded. Those that might show other pictures, by other windows or another selection, say
// nothing of one another.
void warn_of_sessions(std::vector<std::string>& warnings, const std::vector<PoolPart>& parts,
                      Experiment experiment) {
  std::map<std::string, FoldersByDigest> by_choice;
  for (const PoolPart& part : parts) {
    std::set<std::pair<std::string, std::string>> used;
    for (const SessionRow& row : part.evidence.of(experiment).finished)
      used.emplace(row.digests.windows + row.digests.selection, row.digests.manifest);
    for (const auto& [choice, digest] : used) by_choice[choice][digest].push_back(part.folder);
  }
  for (const auto& [choice, folders] : by_choice) {
    if (folders.size() < 2) continue;
    warnings.push_back(fmt::format(
        "Answers about different pictures are added up: {} sessions recorded different sets of pictures, {}.",
        format_experiment(experiment), list_folders(folders)));
  }
}

void warn_of_windows(std::vector<std::string>& warnings, const std::vector<PoolPart>& parts) {
  FoldersByDigest folders;
  for (const PoolPart& part : parts) {
    if (part.sources.windows) folders[part.sources.windows->digest].push_back(part.folder);
  }
  if (folders.size() < 2) return;
  warnings.push_back(
      fmt::format("The clamp windows differ between folders, so that levels of a column have answers of some "
                  "alone: {}.",
                  list_folders(folders)));
}

void pool_prompts(Prompts& all, const Prompts& part) {
  for (const auto& [language, prompts] : part) all[language].insert(prompts.begin(), prompts.end());
}

// What all folders have alike.
template <typename T>
void pool_if_same(std::optional<T>& all, const std::optional<T>& part) {
  if (!all || !part || all->digest != part->digest) all.reset();
}

void warn_of_left_out(Report& report, const ExperimentEvidence& evidence, Experiment experiment) {
  if (evidence.unfinished == 0 || evidence.summaries.empty()) return;
  std::int64_t answered = 0;
  for (const SessionSummary& summary : evidence.summaries)
    answered += summary.complete ? 0 : summary.answered;
  const std::int64_t ended = count_ended_early(evidence);
  report.warnings.push_back(fmt::format(
      "{} {} sessions were not finished ({} ended early by the experimenter, {} left unfinished): "
      "their {} answers are left out.",
      evidence.unfinished, format_experiment(experiment), ended, evidence.unfinished - ended, answered));
}

void warn_of_unanswered(Report& report, const ExperimentEvidence& evidence, Experiment experiment) {
  if (evidence.unanswered == 0) return;
  report.warnings.push_back(
      fmt::format("{} trials of finished {} sessions have no answer: they are left out.", evidence.unanswered,
                  format_experiment(experiment)));
}

void warn_of_others(Report& report) {
  if (report.evidence.others.empty()) return;
  report.warnings.push_back(fmt::format("Finished sessions of other kinds are not counted here: {}.",
                                        describe_totals(report.evidence.others)));
}

void warn_of_withdrawn(Report& report) {
  if (report.evidence.withdrawn == 0 || report.evidence.kind != SubjectKind::kPerson) return;
  report.warnings.push_back(
      fmt::format("Withdrawals that the logs record: {}; nothing of those answers is left to count. A "
                  "participant who withdrew from two logs is counted twice.",
                  report.evidence.withdrawn));
}

void warn_of_protocols(Report& report) {
  std::set<std::string> protocols = digests_of(report.evidence.artifact.finished, &SessionDigests::protocol);
  protocols.merge(digests_of(report.evidence.material.finished, &SessionDigests::protocol));
  if (protocols.size() < 2) return;
  report.warnings.push_back(
      fmt::format("The sessions followed {} session protocols: their practice, breaks, least times or catch "
                  "trials differ.",
                  protocols.size()));
}

void warn_of_balance(Report& report, const Balance& balance, Experiment experiment) {
  const Spread &sessions = balance.sessions, &cells = balance.cells;
  if (sessions.over == 0 && cells.over == 0) return;
  report.warnings.push_back(fmt::format(
      "Sides and views of the test pictures of the {} experiment are less balanced than the rule has them: "
      "counts of the four combinations differ by more than {} in {} of {} sessions (by {} at most), and of "
      "{} "
      "of {} cells over sessions (by {} at most). Subjects left out, and logs added up, leave such gaps in "
      "cells; in a session nothing should.",
      format_experiment(experiment), kBalanceAllows, sessions.over, sessions.measured, sessions.largest,
      cells.over, cells.measured, cells.largest));
}

void warn_of_languages(Report& report) {
  std::map<std::string, std::size_t> languages = count_languages(report.evidence.artifact);
  for (const auto& [language, sessions] : count_languages(report.evidence.material))
    languages[language] += sessions;
  languages.erase("");
  if (languages.size() < 2) return;
  std::vector<std::string> parts;
  for (const auto& [language, sessions] : languages)
    parts.push_back(fmt::format("{} {}", language, sessions));
  report.warnings.push_back(
      fmt::format("The finished sessions were held in {} languages ({}): subjects read different questions.",
                  languages.size(), fmt::join(parts, ", ")));
}

std::vector<std::int64_t> find_marked(const SubjectsReport& subjects) {
  std::vector<std::int64_t> marked;
  for (const SubjectFinding& finding : subjects.sessions) {
    if (!finding.marks.empty()) marked.push_back(finding.summary.session);
  }
  std::sort(marked.begin(), marked.end());
  return marked;
}

SubjectsReport report_subjects(ExperimentEvidence& evidence, const ResponseMatrix& matrix,
                               std::uint64_t seed) {
  auto& summaries = evidence.summaries;
  std::sort(summaries.begin(), summaries.end(), [](const SessionSummary& a, const SessionSummary& b) {
    return std::tie(a.folder, a.subject_index, a.session) < std::tie(b.folder, b.subject_index, b.session);
  });
  return {find_subjects(summaries, matrix), find_order_effect(summaries, seed)};
}

// Verdicts without the sessions that are marked, against those with all.
std::vector<Column> find_flipped_without_marked(const Report& report) {
  const auto artifact = find_marked(report.artifact_subjects),
             material = find_marked(report.material_subjects);
  if (artifact.empty() && material.empty()) return {};
  const auto without = [&](const Tally& all, const ExperimentEvidence& evidence,
                           const std::vector<std::int64_t>& marked) {
    Tally rest = all;
    for (const auto& [cell, count] : tally_answers(select_answers(evidence, marked), report.study)) {
      rest[cell].k -= count.k;
      rest[cell].n -= count.n;
    }
    return rest;
  };
  const auto rest =
      find_equivalence(report.study, without(report.artifact, report.evidence.artifact, artifact),
                       without(report.material, report.evidence.material, material),
                       report.selection ? &*report.selection : nullptr);
  std::vector<Column> flipped;
  for (std::size_t c = 0; c < rest.size(); ++c) {
    if (rest[c].under(report.rule).verdict != report.findings[c].under(report.rule).verdict)
      flipped.push_back(rest[c].column);
  }
  return flipped;
}

std::map<std::int64_t, std::string> find_codes(const ExperimentEvidence& evidence) {
  std::map<std::int64_t, std::string> codes;
  for (const SessionRow& row : evidence.finished) codes[row.id] = row.participant;
  return codes;
}

void add_uncertainty(Report& report) {
  const ResponseMatrix artifact = make_response_matrix(report.evidence.artifact.answers);
  const ResponseMatrix material = make_response_matrix(report.evidence.material.answers);
  const Selection* selection = report.selection ? &*report.selection : nullptr;
  // Beside the rest, which is as long and reads other things.
  std::future<Uncertainty> uncertainty = std::async(std::launch::async, [&] {
    return find_uncertainty(report.study, report.findings,
                            group_by_person(artifact, find_codes(report.evidence.artifact)),
                            group_by_person(material, find_codes(report.evidence.material)), report.params);
  });
  report.artifact_cells = find_cell_statistics(report.artifact);
  report.material_cells = find_cell_statistics(report.material);
  for (std::size_t i = 0; i < kOtherPercents.size(); ++i) {
    report.at_other_percents[i] =
        find_equivalence(report.study, report.artifact, report.material, selection, kOtherPercents[i]);
  }
  report.artifact_subjects = report_subjects(report.evidence.artifact, artifact, report.params.seed);
  report.material_subjects = report_subjects(report.evidence.material, material, report.params.seed);
  report.uncertainty = uncertainty.get();
  report.trends = find_trends(report.study, report.findings, report.rule, report.uncertainty);
  report.flipped_without_marked = find_flipped_without_marked(report);
}

}  // namespace

std::vector<std::string> find_source_warnings(const Study& study, const Evidence& evidence,
                                              const ReportSources& sources) {
  std::vector<std::string> warnings;
  if (sources.manifest && sources.manifest->study_digest != study.digest)
    warnings.push_back("The manifest belongs to another version of the study.");
  for (const ConvergenceExhibit& exhibit : sources.convergences) {
    if (exhibit.convergence.source == study.name) continue;
    warnings.push_back(fmt::format("Error against run time of {} was measured of {}, not of this study.",
                                   exhibit.convergence.condition, exhibit.convergence.source));
  }
  if (sources.windows) {
    warn_of_digests(warnings, evidence, Experiment::kArtifact, &SessionDigests::windows,
                    sources.windows->digest, "a windows.json");
  }
  for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
    if (sources.protocol)
      warn_of_digests(warnings, evidence, experiment, &SessionDigests::protocol, sources.protocol->digest,
                      "a session.json");
  }
  warn_of_selection(warnings, evidence, sources.selection);
  if (sources.windows) warn_of_placeholders(warnings, *sources.windows);
  return warnings;
}

std::vector<std::string> find_pool_warnings(const std::vector<PoolPart>& parts) {
  std::vector<std::string> warnings;
  if (!warn_of_manifests(warnings, parts)) {
    for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial})
      warn_of_sessions(warnings, parts, experiment);
  }
  warn_of_windows(warnings, parts);
  return warnings;
}

ReportSources pool_sources(std::vector<ReportSources> parts, const std::vector<std::string>& folders) {
  EQ_CHECK(!parts.empty() && parts.size() == folders.size(), parts.size(), folders.size());
  ReportSources all = parts.front();
  pool_selections(all, parts, folders);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    ReportSources& part = parts[i];
    pool_if_same(all.windows, part.windows);
    if (!are_same_pictures(all.manifest, part.manifest)) all.manifest.reset();
    pool_if_same(all.protocol, part.protocol);
    pool_if_same(all.truth, part.truth);
    pool_prompts(all.artifact_prompts, part.artifact_prompts);
    pool_prompts(all.material_prompts, part.material_prompts);
    for (ConvergenceExhibit& exhibit : part.convergences) all.convergences.push_back(std::move(exhibit));
  }
  return all;
}

Report make_report(const Study& study, Evidence evidence, Rule rule, ReportSources sources,
                   const UncertaintyParams& params) {
  const auto warnings = find_source_warnings(study, evidence, sources);
  return make_pooled_report(study, std::move(evidence), rule, std::move(sources), params, warnings);
}

Report make_pooled_report(const Study& study, Evidence evidence, Rule rule, ReportSources sources,
                          const UncertaintyParams& params, const std::vector<std::string>& warnings) {
  Report report;
  report.study = study;
  report.evidence = std::move(evidence);
  report.rule = rule;
  report.params = params;
  report.artifact = tally_answers(report.evidence.artifact.answers, study);
  report.material = tally_answers(report.evidence.material.answers, study);
  report.selection = std::move(sources.selection);
  report.selections = std::move(sources.selections);
  report.windows = std::move(sources.windows);
  report.manifest = std::move(sources.manifest);
  report.convergences = std::move(sources.convergences);
  report.protocol = std::move(sources.protocol);
  report.truth = std::move(sources.truth);
  report.artifact_prompts = std::move(sources.artifact_prompts);
  report.material_prompts = std::move(sources.material_prompts);
  report.findings = find_equivalence(study, report.artifact, report.material,
                                     report.selection ? &*report.selection : nullptr);
  report.artifact_balance = find_balance(report.evidence.artifact);
  report.material_balance = find_balance(report.evidence.material);
  add_uncertainty(report);
  report.warnings = warnings;
  warn_of_uneven_cells(report, report.artifact, Experiment::kArtifact);
  warn_of_uneven_cells(report, report.material, Experiment::kMaterial);
  warn_of_balance(report, report.artifact_balance, Experiment::kArtifact);
  warn_of_balance(report, report.material_balance, Experiment::kMaterial);
  warn_of_left_out(report, report.evidence.artifact, Experiment::kArtifact);
  warn_of_left_out(report, report.evidence.material, Experiment::kMaterial);
  warn_of_unanswered(report, report.evidence.artifact, Experiment::kArtifact);
  warn_of_unanswered(report, report.evidence.material, Experiment::kMaterial);
  warn_of_others(report);
  warn_of_withdrawn(report);
  warn_of_protocols(report);
  warn_of_languages(report);
  return report;
}

void sort_reports(std::vector<Report>& reports) {
  std::sort(reports.begin(), reports.end(), [](const Report& a, const Report& b) {
    if (a.findings.size() != b.findings.size()) return a.findings.size() > b.findings.size();
    return a.study.name < b.study.name;
  });
  for (std::size_t i = 1; i < reports.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (reports[i].study.name == reports[j].study.name)
        throw InputError(reports[i].study.name, "", "studies of one name to be one study",
                         "two with different digests");
    }
  }
}

void add_normalisation_trends(std::vector<Report>& reports) {
  for (Report& normalised : reports) {
    if (!normalised.study.normalise) continue;
    for (const Report& plain : reports) {
      if (plain.study.normalise) continue;
      const Trend trend = compare_studies(
          {plain.study.name, plain.findings, plain.uncertainty},
          {normalised.study.name, normalised.findings, normalised.uncertainty}, normalised.rule);
      if (trend.status != TrendStatus::kNoPairs) normalised.trends.push_back(trend);
    }
    adjust_trends(normalised.trends);
  }
}

ReportFiles make_report_files(const std::vector<Report>& reports) {
  ReportFiles files;
  const auto tables = make_report_tables(reports);
  for (const ReportTable& table : tables) files[table.file] = format_csv(table.table);
  files["csv-metadata.json"] = format_json(make_csv_metadata(tables));
  files["report.json"] = format_json(make_report_json(reports));
  for (const Report& report : reports) {
    const std::string study = reports.size() > 1 ? report.study.name + "-" : "";
    for (const Object& object : enumerate_objects(report.study)) {
      files[fmt::format("graph-{}{}.svg", study, format_key(object))] = draw_lone_graph(
          object, findings_of(report.findings, object), report.rule, report.study.name, report.evidence.kind);
    }
  }
  files[kReportPage] = format_page(reports);
  return files;
}

}  // namespace equilux
