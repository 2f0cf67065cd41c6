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
  kFamiliar,      ///< a page of the familiarisation; ContinueEvent and BackEvent turn it, back to the
                  ///< instructions
  kPractice,      ///< practice is about to begin; waits for ContinueEvent
  kFeedback,      ///< whether the practice answer was right; waits for ContinueEvent
  kMain,          ///< practice is over; waits for ContinueEvent
  kTrial,         ///< a pair is to be shown, or is shown, and waits for an answer
  kBreak,         ///< a rest, as long as the subject likes; waits for ContinueEvent
  kPause,         ///< stopped by the experimenter; ContinueEvent goes on, AbortEvent ends
  kThanks,        ///< all is answered and recorded
  kAborted,       ///< ended early; what was answered stays
  kInterrupted,   ///< this sitting is over, against everybody's will; the session may go on in another
};

// Events. Times are of one monotonic clock. units: ns
struct ContinueEvent {
  std::int64_t time_ns = 0;
};
struct BackEvent {
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
/// The experimenter stops; the pair that was on the screen is shown again afterwards.
struct PauseEvent {
  std::int64_t time_ns = 0;
};
struct AbortEvent {
  std::string reason;
  std::int64_t time_ns = 0;
};
/// The sitting cannot go on, though nobody decided that the session ends: its window was closed.
struct InterruptEvent {
  std::string reason;
  std::int64_t time_ns = 0;
};
/// Something happened to the screen or the program: focus_lost, resized, dropped_frames, ...
struct NoteEvent {
  std::string kind;
  std::string detail;
  std::int64_t time_ns = 0;
};
using SessionEvent = std::variant<ContinueEvent, BackEvent, ShownEvent, AnswerEvent, PauseEvent, AbortEvent,
                                  InterruptEvent, NoteEvent>;

// Effects, to be carried out in order; each must be done before the next.
/// Record that `trial` is about to be shown (first showing of the session, or again after an interruption).
struct RecordShowing {
  int trial = 0;
  std::int64_t time_ns = 0;
};
/// Record the answer, and that `next` is about to be shown, in one transaction. `next` is empty before a
/// page.
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
/// Record an event of the session.
struct RecordNote {
  std::string kind;
  std::string detail;
  std::int64_t time_ns = 0;
};
using SessionEffect =
    std::variant<RecordShowing, RecordAnswer, ShowTrial, RecordFinish, RecordAbort, RecordNote>;

/// What the protocol says of a session's course.
struct SessionRules {
  int familiar_pages = 0;
  std::optional<int> break_every_trials = {};  ///< counted and catch trials
  std::optional<std::int64_t> break_every_ns = {};
  std::int64_t least_response_ns = 0;  ///< faster answers are marked
};

/// A session in progress. `trials` is the schedule with the answers so far; `current` its first unanswered
/// trial, or the count.
struct Session {
  Experiment experiment = Experiment::kArtifact;
  std::vector<TrialRow> trials;
  SessionRules rules = {};
  Screen screen = Screen::kInstructions;
  int current = 0;
  int page = 0;                               ///< of the familiarisation
  std::optional<int> last_answered = {};      ///< of this sitting
  std::optional<std::int64_t> onset_ns = {};  ///< of the current pair; empty while it is not on the screen
  int since_break = 0;                        ///< answers
  std::int64_t paused_at_ns = 0;              ///< when the last pause began
  std::optional<std::int64_t> break_from_ns = {};  ///< since when the subject has been at it without a break
  Screen paused = Screen::kInstructions;           ///< where a pause goes back to
};

/// A trial's place among those of its part: of the practice, or of all that follow it.
struct TrialProgress {
  int answered = 0;
  int count = 0;
};
TrialProgress find_progress(const Session& session);

/// A session over this schedule, which may hold answers from before an interruption.
Session make_session(Experiment experiment, std::vector<TrialRow> trials, const SessionRules& rules = {});

/// Nothing more can happen in this sitting.
bool is_over(const Session& session);

/// Takes an event and says what must be done. An event that does not fit the screen changes nothing and gives
/// no effects.
std::vector<SessionEffect> advance(Session& session, const SessionEvent& event);

}  // namespace equilux
