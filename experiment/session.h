// The session as a pure state machine: event in, effects out. No clock, window or database inside.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "experiment/trial_log.h"

namespace equilux {

/// What the subject is looking at.
enum class Screen {
  kInstructions,  ///< the question and how to answer; waits for ContinueEvent
  kTrial,         ///< a pair is to be shown, or is shown, and waits for an answer
  kThanks,        ///< all is answered and recorded
  kAborted,       ///< ended early; what was answered stays
};

// Events. Times are of one monotonic clock. units: ns
struct ContinueEvent {
  std::int64_t time_ns = 0;
};
/// The pair of `trial` is on the screen since then.
struct ShownEvent {
  int trial = 0;
  std::int64_t time_ns = 0;
};
/// A side was pressed. Ignored unless a pair is on the screen and the press came after its onset.
struct AnswerEvent {
  Side side = Side::kLeft;
  std::int64_t time_ns = 0;
};
struct AbortEvent {
  std::string reason;
  std::int64_t time_ns = 0;
};
using SessionEvent = std::variant<ContinueEvent, ShownEvent, AnswerEvent, AbortEvent>;

// Effects, to be carried out in order; each must be done before the next.
/// Record that `trial` is about to be shown (first showing of the session, or again after a resume).
struct RecordShowing {
  int trial = 0;
  std::int64_t time_ns = 0;
};
/// Record the answer, and that `next` is about to be shown, in one transaction.
struct RecordAnswer {
  Answer answer;
  std::optional<int> next;
  std::int64_t time_ns = 0;
};
/// Put the pair on the screen, then report ShownEvent.
struct ShowTrial {
  int trial = 0;
};
struct RecordFinish {
  std::int64_t time_ns = 0;
};
struct RecordAbort {
  std::string reason;
  std::int64_t time_ns = 0;
};
using SessionEffect = std::variant<RecordShowing, RecordAnswer, ShowTrial, RecordFinish, RecordAbort>;

/// A session in progress. `trials` is the schedule with the answers so far; `current` its first unanswered
/// trial, or the count.
struct Session {
  Experiment experiment = Experiment::kArtifact;
  std::vector<TrialRow> trials;
  Screen screen = Screen::kInstructions;
  int current = 0;
  std::optional<std::int64_t> onset_ns;  ///< of the current pair; empty while it is not on the screen
};

/// A session over this schedule, which may hold answers from before an interruption.
Session make_session(Experiment experiment, std::vector<TrialRow> trials);

/// Takes an event and says what must be done. An event that does not fit the screen changes nothing and gives
/// no effects.
std::vector<SessionEffect> advance(Session& session, const SessionEvent& event);

}  // namespace equilux
