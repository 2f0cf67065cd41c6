// An abort counts until the session is seen going on.
#include "experiment/session_summary.h"

namespace equilux {
namespace {

std::optional<std::string> find_abort(const std::vector<EventRow>& events) {
  std::optional<std::string> reason;
  for (const EventRow& event : events) {
    if (event.kind == "abort") reason = event.detail;
    if (event.kind == "resume" || event.kind == "showing" || event.kind == "answer") reason.reset();
  }
  return reason;
}

void count_trial(SessionSummary& summary, const TrialRow& trial) {
  ++summary.trials;
  if (!trial.answer) return;
  ++summary.answered;
  if (trial.too_fast) ++summary.too_fast;
  if (trial.phase != Phase::kCatch) return;
  ++summary.catch_answered;
  if (trial.answer == trial.test_side) ++summary.catch_right;
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

SessionSummary summarise_session(const SessionRow& row, const std::vector<TrialRow>& trials,
                                 const std::vector<EventRow>& events) {
  SessionSummary summary;
  for (const TrialRow& trial : trials) count_trial(summary, trial);
  const auto reason = find_abort(events);
  if (row.complete) {
    summary.state = SessionState::kComplete;
  } else if (reason) {
    summary.state = SessionState::kAborted;
    summary.abort_reason = *reason;
  }
  return summary;
}

}  // namespace equilux
