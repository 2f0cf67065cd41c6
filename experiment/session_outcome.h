// What became of a session, counted from its rows.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "experiment/trial_log.h"

namespace equilux {

enum class SessionState {
  kComplete,    ///< every trial answered
  kUnfinished,  ///< may be going on now, or was interrupted
  kAborted,     ///< ended early, and not resumed since
};

struct SessionOutcome {
  SessionState state = SessionState::kUnfinished;
  std::string abort_reason;  ///< empty unless aborted
  std::string interruption;  ///< what broke off the last sitting; empty where that is not known
  int trials = 0;            ///< of all phases, as the next two
  int answered = 0;
  int too_fast = 0;
  int catch_answered = 0;
  int catch_right = 0;
  std::map<std::string, int> notes;  ///< by kind: what happened to the screen and may have disturbed
};

std::string format_state(SessionState state);

SessionOutcome find_outcome(const SessionRow& row, const std::vector<TrialRow>& trials,
                            const std::vector<EventRow>& events);

/// Of a session that goes on, a sentence for the experimenter: so that a code that was mistyped is seen to be
/// another's before its session goes on with the wrong person.
std::string describe_unfinished(const SessionRow& row, const std::vector<TrialRow>& trials,
                                const std::vector<EventRow>& events);

}  // namespace equilux
