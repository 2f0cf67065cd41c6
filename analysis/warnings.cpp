// What a reader should know before believing a table.
#include "analysis/warnings.h"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <set>

#include "analysis/evidence.h"
#include "analysis/prompts.h"
#include "analysis/words.h"

namespace equilux {
namespace {

using Warnings = std::vector<std::string>;

std::set<std::string> digests_of(const std::vector<SessionRow>& sessions,
                                 std::string SessionDigests::*member) {
  std::set<std::string> digests;
  for (const SessionRow& session : sessions) digests.insert(session.digests.*member);
  return digests;
}

// A session of schema 1 did not record its protocol: it agrees with any.
bool is_unknown(const SessionDigests& digests, std::string SessionDigests::*member) {
  return member == &SessionDigests::protocol && digests.protocol.empty();
}

void warn_of_digests(Warnings& warnings, const Evidence& evidence, Experiment experiment,
                     std::string SessionDigests::*member, const std::string& now, const std::string& what) {
  const auto& sessions = evidence.of(experiment).finished;
  const auto others = std::count_if(sessions.begin(), sessions.end(), [&](const SessionRow& row) {
    return row.digests.*member != now && !is_unknown(row.digests, member);
  });
  if (others == 0) return;
  warnings.push_back(fmt::format("Of {} {} used {} other than the one in the folder now ({}...).",
                                 format_count(sessions.size(), format_experiment(experiment) + " session"),
                                 others, what, now.substr(0, 12)));
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
  const std::int64_t ended = count_ended_early(evidence), left_out = evidence.unfinished;
  warnings.push_back(fmt::format(
      "{} {} not finished ({} ended early by the experimenter, {} left unfinished): {} {} {} left out.",
      format_count(left_out, format_experiment(experiment) + " session"),
      choose_form(left_out, "was", "were"), ended, left_out - ended, choose_form(left_out, "its", "their"),
      format_count(answered, "answer"), choose_form(answered, "is", "are")));
}

void warn_of_unanswered(Warnings& warnings, const ExperimentEvidence& evidence, Experiment experiment) {
  if (evidence.unanswered == 0) return;
  const std::int64_t count = evidence.unanswered;
  warnings.push_back(fmt::format("{} of finished {} sessions {} no answer: {} left out.",
                                 format_count(count, "trial"), format_experiment(experiment),
                                 choose_form(count, "has", "have"), choose_form(count, "it is", "they are")));
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
  protocols.erase("");
  if (protocols.size() < 2) return;
  warnings.push_back(
      fmt::format("The sessions followed {} session protocols: their practice, breaks, least times or catch "
                  "trials differ.",
                  protocols.size()));
}

// "3 of 7 sessions (by 4 at most)"
std::string describe_spread(const Spread& spread, const std::string& thing) {
  const std::size_t end = thing.find(' ');
  return fmt::format("{} of {}{} (by {} at most)", spread.over,
                     format_count(spread.measured, thing.substr(0, end)),
                     end == std::string::npos ? "" : thing.substr(end), spread.largest);
}

void warn_of_balance(Warnings& warnings, const Balance& balance, Experiment experiment) {
  const bool in_sessions = balance.sessions.over > 0, in_cells = balance.cells.over > 0;
  if (!in_sessions && !in_cells) return;
  std::vector<std::string> places;
  if (in_sessions) places.push_back("in " + describe_spread(balance.sessions, "session"));
  if (in_cells)
    places.push_back((in_sessions ? "of " : "in ") + describe_spread(balance.cells, "cell over sessions"));
  warnings.push_back(fmt::format(
      "Sides and views of the test pictures of the {} experiment are less balanced than the rule has them: "
      "counts of the four combinations differ by more than {} {}. {}.",
      format_experiment(experiment), kBalanceAllows, fmt::join(places, ", and "),
      !in_cells      ? "In a session nothing should leave such gaps"
      : !in_sessions ? "Subjects left out, and logs added up, leave such gaps in cells"
                     : "Subjects left out, and logs added up, leave such gaps in cells; in a session nothing "
                       "should"));
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

std::string list_first(const std::vector<std::string>& names) {
  constexpr std::size_t kListed = 5;
  const auto shown = names.begin() + static_cast<std::ptrdiff_t>(std::min(names.size(), kListed));
  const std::string list = fmt::format("{}", fmt::join(names.begin(), shown, ", "));
  return names.size() > kListed ? fmt::format("{} and {} more", list, names.size() - kListed) : list;
}

// Codes that finished an experiment more than once, with their sessions.
struct Repeaters {
  std::vector<std::string> names;
  std::size_t codes = 0;       // of all sessions
  bool is_of_one_log = false;  // one of them within a log
};

Repeaters find_repeaters(const ExperimentEvidence& evidence) {
  std::map<std::string, std::size_t> finished;
  for (const SessionRow& row : evidence.finished) ++finished[row.participant];
  finished.erase("");
  std::set<std::pair<std::string, std::string>> seen;
  Repeaters repeaters;
  for (const SessionSummary& summary : evidence.summaries) {
    if (!summary.complete || !finished.contains(summary.participant)) continue;
    repeaters.is_of_one_log |= !seen.emplace(summary.participant, summary.folder).second;
  }
  repeaters.codes = finished.size();
  for (const auto& [participant, count] : finished) {
    if (count > 1) repeaters.names.push_back(fmt::format("{} ({} times)", participant, count));
  }
  return repeaters;
}

// In one log nobody finishes an experiment twice, unless logs were merged into it.
void warn_of_repeaters(Warnings& warnings, const ExperimentEvidence& evidence, Experiment experiment,
                       SubjectKind kind) {
  const Repeaters repeaters = find_repeaters(evidence);
  if (repeaters.names.empty()) return;
  warnings.push_back(fmt::format(
      "{} finished the {} experiment more than once, {}: {}. The {} sessions are of {}. "
      "One subject each are the sessions of a code for what draws subjects again or leaves them out: ranges "
      "of cuts, resampled EE, intervals of trends, verdicts turned by one, the order effect. Each session "
      "counts as another subject in k and n, and so in flags, cuts, verdicts, intervals of cells "
      "(Clopper-Pearson, Jeffreys), p, q, posteriors and what is supported: if a code is one {}, those are "
      "too "
      "sure of themselves.",
      kind == SubjectKind::kPerson ? "Participants" : "Simulated subjects of one code",
      format_experiment(experiment),
      repeaters.is_of_one_log ? "as a log merged from several may have it" : "in different logs",
      list_first(repeaters.names), evidence.finished.size(), format_count(repeaters.codes, "code"),
      kind == SubjectKind::kPerson ? "person" : "subject"));
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

std::vector<std::string> find_repeater_warnings(const Evidence& evidence) {
  Warnings warnings;
  warn_of_repeaters(warnings, evidence.artifact, Experiment::kArtifact, evidence.kind);
  warn_of_repeaters(warnings, evidence.material, Experiment::kMaterial, evidence.kind);
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
  warn_of_questions(warnings, report.evidence.artifact, Experiment::kArtifact);
  warn_of_questions(warnings, report.evidence.material, Experiment::kMaterial);
  return warnings;
}

}  // namespace equilux
