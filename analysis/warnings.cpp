// What a reader should know before believing a table.
#include "analysis/warnings.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <set>

#include "analysis/evidence.h"
#include "analysis/prompts.h"

namespace equilux {
namespace {

using Warnings = std::vector<std::string>;

std::set<std::string> digests_of(const std::vector<SessionRow>& sessions,
                                 std::string SessionDigests::*member) {
  std::set<std::string> digests;
  for (const SessionRow& session : sessions) digests.insert(session.digests.*member);
  return digests;
}

void warn_of_digests(Warnings& warnings, const Evidence& evidence, Experiment experiment,
// A session of schema 1 did not record its protocol: it agrees with any.
bool is_unknown(const SessionDigests& digests, std::string SessionDigests::*member) {
  return member == &SessionDigests::protocol && digests.protocol.empty();
}

                     std::string SessionDigests::*member, const std::string& now, const std::string& what) {
  const auto& sessions = evidence.of(experiment).finished;
  const auto others = std::count_if(sessions.begin(), sessions.end(), [&](const SessionRow& row) {
    return row.digests.*member != now && !is_unknown(row.digests, member);
  });
  if (others == 0) return;
  warnings.push_back(fmt::format("Of {} {} sessions {} used {} other than the one in the folder now ({}...).",
                                 sessions.size(), format_experiment(experiment), others, what,
                                 now.substr(0, 12)));
}

void warn_of_selection(Warnings& warnings, const Evidence& evidence,
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

void warn_of_placeholders(Warnings& warnings, const Windows& windows) {
  std::size_t placeholders = 0;
  for (const auto& [column, window] : windows.by_column) {
    placeholders += window.origin == WindowOrigin::kPlaceholder ? 1 : 0;
  }
  if (placeholders == 0) return;
  warnings.push_back(fmt::format(
      "The clamp windows of {} of {} columns are placeholders: no pilot, prediction or eye chose them.",
      placeholders, windows.by_column.size()));
}

void warn_of_uneven_cells(Warnings& warnings, const Tally& tally, Experiment experiment) {
  std::set<std::int64_t> sizes;
  for (const auto& [cell, count] : tally) {
    if (count.n > 0) sizes.insert(count.n);
  }
  if (sizes.size() < 2) return;
  warnings.push_back(fmt::format("Cells of the {} experiment have between {} and {} answers.",
                                 format_experiment(experiment), *sizes.begin(), *sizes.rbegin()));
}

void warn_of_left_out(Warnings& warnings, const ExperimentEvidence& evidence, Experiment experiment) {
  if (evidence.unfinished == 0 || evidence.summaries.empty()) return;
  std::int64_t answered = 0;
  for (const SessionSummary& summary : evidence.summaries)
    answered += summary.complete ? 0 : summary.answered;
  const std::int64_t ended = count_ended_early(evidence);
  warnings.push_back(fmt::format(
      "{} {} sessions were not finished ({} ended early by the experimenter, {} left unfinished): "
      "their {} answers are left out.",
      evidence.unfinished, format_experiment(experiment), ended, evidence.unfinished - ended, answered));
}

void warn_of_unanswered(Warnings& warnings, const ExperimentEvidence& evidence, Experiment experiment) {
  if (evidence.unanswered == 0) return;
  warnings.push_back(fmt::format("{} trials of finished {} sessions have no answer: they are left out.",
                                 evidence.unanswered, format_experiment(experiment)));
}

void warn_of_others(Warnings& warnings, const Report& report) {
  if (report.evidence.others.empty()) return;
  warnings.push_back(fmt::format("Finished sessions of other kinds are not counted here: {}.",
                                 describe_totals(report.evidence.others)));
}

void warn_of_withdrawn(Warnings& warnings, const Report& report) {
  if (report.evidence.withdrawn == 0 || report.evidence.kind != SubjectKind::kPerson) return;
  warnings.push_back(
      fmt::format("Withdrawals that the logs record: {}; nothing of those answers is left to count. A "
                  "participant who withdrew from two logs is counted twice.",
                  report.evidence.withdrawn));
}

void warn_of_protocols(Warnings& warnings, const Report& report) {
  std::set<std::string> protocols = digests_of(report.evidence.artifact.finished, &SessionDigests::protocol);
  protocols.merge(digests_of(report.evidence.material.finished, &SessionDigests::protocol));
  if (protocols.size() < 2) return;
  warnings.push_back(
      fmt::format("The sessions followed {} session protocols: their practice, breaks, least times or catch "
                  "trials differ.",
  protocols.erase("");
                  protocols.size()));
}

void warn_of_balance(Warnings& warnings, const Balance& balance, Experiment experiment) {
  const Spread &sessions = balance.sessions, &cells = balance.cells;
  if (sessions.over == 0 && cells.over == 0) return;
  warnings.push_back(fmt::format(
      "Sides and views of the test pictures of the {} experiment are less balanced than the rule has them: "
      "counts of the four combinations differ by more than {} in {} of {} sessions (by {} at most), and of "
      "{} "
      "of {} cells over sessions (by {} at most). Subjects left out, and logs added up, leave such gaps in "
      "cells; in a session nothing should.",
      format_experiment(experiment), kBalanceAllows, sessions.over, sessions.measured, sessions.largest,
      cells.over, cells.measured, cells.largest));
}

void warn_of_languages(Warnings& warnings, const Report& report) {
  std::map<std::string, std::size_t> languages = count_languages(report.evidence.artifact);
  for (const auto& [language, sessions] : count_languages(report.evidence.material))
    languages[language] += sessions;
  languages.erase("");
  if (languages.size() < 2) return;
  std::vector<std::string> parts;
  for (const auto& [language, sessions] : languages)
    parts.push_back(fmt::format("{} {}", language, sessions));
  warnings.push_back(
      fmt::format("The finished sessions were held in {} languages ({}): subjects read different questions.",
                  languages.size(), fmt::join(parts, ", ")));
}

// Within a language, so that a translation is no other question.
void warn_of_questions(Warnings& warnings, const ExperimentEvidence& evidence, Experiment experiment) {
  for (const auto& [language, prompts] : find_recorded_prompts(evidence)) {
    if (prompts.size() < 2) continue;
    warnings.push_back(fmt::format(
        "The finished {} sessions {} recorded {} different questions: subjects read different ones.",
        format_experiment(experiment),
        language.empty() ? "without a language" : fmt::format("in the language {}", language),
        prompts.size()));
  }
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

std::vector<std::string> find_answer_warnings(const Report& report) {
  Warnings warnings;
  warn_of_uneven_cells(warnings, report.artifact, Experiment::kArtifact);
  warn_of_uneven_cells(warnings, report.material, Experiment::kMaterial);
  warn_of_balance(warnings, report.artifact_balance, Experiment::kArtifact);
  warn_of_balance(warnings, report.material_balance, Experiment::kMaterial);
  warn_of_left_out(warnings, report.evidence.artifact, Experiment::kArtifact);
  warn_of_left_out(warnings, report.evidence.material, Experiment::kMaterial);
  warn_of_unanswered(warnings, report.evidence.artifact, Experiment::kArtifact);
  warn_of_unanswered(warnings, report.evidence.material, Experiment::kMaterial);
  warn_of_others(warnings, report);
  warn_of_withdrawn(warnings, report);
  warn_of_protocols(warnings, report);
  warn_of_languages(warnings, report);
  return warnings;
}

}  // namespace equilux
  warn_of_questions(warnings, report.evidence.artifact, Experiment::kArtifact);
  warn_of_questions(warnings, report.evidence.material, Experiment::kMaterial);
