// An abort counts until the session is seen going on.
#include "experiment/session_outcome.h"

#include <fmt/format.h>

namespace equilux {
namespace {

void count_trial(SessionOutcome& summary, const TrialRow& trial) {
  ++summary.trials;
  if (!trial.answer) return;
  ++summary.answered;
  if (trial.too_fast) ++summary.too_fast;
  if (trial.phase != Phase::kCatch) return;
  ++summary.catch_answered;
  if (trial.answer == trial.test_side) ++summary.catch_right;
}

// A window that gets the focus back, or a monitor that returns, disturbs nobody more.
bool is_disturbance(const std::string& kind) {
  return kind == "slow_frame" || kind == "focus_lost" || kind == "resized" || kind == "monitor_disconnected";
}

}  // namespace

std::string format_state(SessionState state) {
  switch (state) {
    case SessionState::kComplete:
      return "complete";
    case SessionState::kAborted:
      return "aborted";
    default:
      return "unfinished";
  }
}

SessionOutcome find_outcome(const SessionRow& row, const std::vector<TrialRow>& trials,
                            const std::vector<EventRow>& events) {
  SessionOutcome summary;
  for (const TrialRow& trial : trials) count_trial(summary, trial);
  for (const EventRow& event : events) {
    if (is_disturbance(event.kind)) ++summary.notes[event.kind];
  }
  const auto reason = find_abort_reason(events);
  if (row.complete) {
    summary.state = SessionState::kComplete;
  } else if (reason) {
    summary.state = SessionState::kAborted;
    summary.abort_reason = *reason;
  } else {
    summary.interruption = find_interruption(events).value_or("");
  }
  return summary;
}

std::string describe_unfinished(const SessionRow& row, const std::vector<TrialRow>& trials,
                                const std::vector<EventRow>& events) {
  const SessionOutcome outcome = find_outcome(row, trials, events);
  const std::string end =
      outcome.abort_reason.empty() ? "" : fmt::format(", ended early ({})", outcome.abort_reason);
  return fmt::format(
      "Goes on with session {}, begun {}: {} of {} answered{}. Consent and questions are not asked again.",
      row.id, row.started_utc, outcome.answered, outcome.trials, end);
}

}  // namespace equilux
