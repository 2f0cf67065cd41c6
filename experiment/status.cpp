// The log's sessions as a table of text, and what comes next.
#include "experiment/status.h"

#include <algorithm>
#include <fmt/format.h>
#include <set>

#include "experiment/open_session.h"
#include "experiment/session_outcome.h"
#include "experiment/trial_log.h"

namespace equilux {
namespace {

constexpr const char* kNoSessions = "No sessions yet.\n";

std::string format_head() {
  return fmt::format("{:>7}  {:8}{:11}{:>5}  {:20}{:11}{:>9}{:>10}{:>13}  {}\n", "session", "kind",
                     "experiment", "index", "participant", "state", "answered", "too fast", "catch right",
                     "started");
}

std::string format_catch(const SessionOutcome& summary) {
  return summary.catch_answered == 0 ? "-"
                                     : fmt::format("{}/{}", summary.catch_right, summary.catch_answered);
}

std::string format_end(const SessionOutcome& summary) {
  if (!summary.abort_reason.empty()) return fmt::format("  aborted: {}", summary.abort_reason);
  if (!summary.interruption.empty()) return fmt::format("  interrupted: {}", summary.interruption);
  return "";
}

std::string format_notes(const SessionOutcome& summary) {
  std::vector<std::string> notes;
  for (const auto& [kind, count] : summary.notes) notes.push_back(fmt::format("{} {}", kind, count));
  return notes.empty() ? "" : fmt::format("  {}", fmt::join(notes, ", "));
}

std::string format_line(const TrialLog& log, const SessionRow& row) {
  const SessionOutcome summary = find_outcome(row, log.load_trials(row.id), log.load_events(row.id));
  return fmt::format("{:7}  {:8}{:11}{:5}  {:20}{:11}{:>9}{:>10}{:>13}  {}{}{}\n", row.id,
                     format_kind(row.kind), format_experiment(row.experiment), row.subject_index,
                     row.participant, format_state(summary.state),
                     fmt::format("{}/{}", summary.answered, summary.trials), summary.too_fast,
                     format_catch(summary), row.started_utc, format_notes(summary), format_end(summary));
}

std::string format_next(const TrialLog& log, const std::vector<SessionRow>& sessions, Experiment experiment) {
  std::set<SubjectKind> kinds = {SubjectKind::kPerson};
  for (const SessionRow& row : sessions) kinds.insert(row.kind);
  const Lane lane = find_lane(&log, {});
  std::vector<std::string> parts;
  for (const SubjectKind kind : kinds)
    parts.push_back(fmt::format("{} {}", format_kind(kind), log.find_free_index(kind, experiment, lane)));
  return fmt::format("Next free index, {}: {}.\n", format_experiment(experiment), fmt::join(parts, ", "));
}

}  // namespace

std::string format_status(const StudyFolder& folder) {
  load_folder_study(folder);
  if (!TrialLog::is_at(folder.responses())) return kNoSessions;
  const TrialLog log = TrialLog::load_snapshot(folder.responses());
  const auto sessions = log.load_sessions();
  const auto withdrawn = log.count_withdrawn();
  if (sessions.empty() && withdrawn == 0) return kNoSessions;
  std::string text = sessions.empty() ? kNoSessions : format_head();
  for (const SessionRow& row : sessions) text += format_line(log, row);
  text += fmt::format("\nWithdrawn participants: {}{}.\n", withdrawn,
                      withdrawn > 1 ? " (who withdrew at several stations counts at each)" : "");
  for (const Experiment experiment : {Experiment::kArtifact, Experiment::kMaterial})
    text += format_next(log, sessions, experiment);
  const Lane lane = find_lane(&log, {});
  return text + fmt::format("Station of this log: {}{}.\n", log.load_station().substr(0, 8),
                            lane == Lane{} ? "" : ", " + format_lane(lane));
}

}  // namespace equilux
