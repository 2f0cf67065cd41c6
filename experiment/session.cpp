// The walk through one session: instructions, pairs, thanks; each event answered by what must be done.
#include "experiment/session.h"

#include <algorithm>

#include "base/error.h"

namespace equilux {
namespace {

using Effects = std::vector<SessionEffect>;

int count_of(const Session& session) { return static_cast<int>(session.trials.size()); }

int find_unanswered(const Session& session, int from) {
  const auto waiting = std::find_if(session.trials.begin() + from, session.trials.end(),
                                    [](const TrialRow& trial) { return !trial.answer; });
  return static_cast<int>(waiting - session.trials.begin());
}

bool is_practice(const Session& session, int trial) {
  return session.trials[static_cast<std::size_t>(trial)].phase == Phase::kPractice;
}

bool has_answers(const Session& session) {
  return std::any_of(session.trials.begin(), session.trials.end(),
                     [](const TrialRow& trial) { return trial.answer.has_value(); });
}

// The pair that is due, from a page.
Effects show_current(Session& session, std::int64_t time_ns) {
  session.screen = Screen::kTrial;
  session.onset_ns.reset();
  if (!session.break_from_ns) session.break_from_ns = time_ns;
  return {RecordShowing{session.current, time_ns}, ShowTrial{session.current}};
}

// From the pages before the trials to practice or, after an interruption, to where it stopped.
Effects enter_trials(Session& session, std::int64_t time_ns) {
  if (is_practice(session, session.current)) {
    session.screen = Screen::kPractice;
    return {};
  }
  const bool is_after_practice = session.current > 0 && is_practice(session, session.current - 1);
  if (!is_after_practice) return show_current(session, time_ns);
  session.screen = Screen::kMain;
  return {};
}

Effects leave_instructions(Session& session, std::int64_t time_ns) {
  if (session.current == count_of(session)) {  // interrupted after the last answer
    session.screen = Screen::kThanks;
    return {RecordFinish{time_ns}};
  }
  if (session.rules.familiar_pages == 0 || has_answers(session)) return enter_trials(session, time_ns);
  session.screen = Screen::kFamiliar;
  session.page = 0;
  return {};
}

Effects turn_page(Session& session, std::int64_t time_ns) {
  if (session.page + 1 == session.rules.familiar_pages) return enter_trials(session, time_ns);
  ++session.page;
  return {};
}

Effects leave_feedback(Session& session, std::int64_t time_ns) {
  if (is_practice(session, session.current)) return show_current(session, time_ns);
  session.screen = Screen::kMain;
  return {};
}

Effects begin_after_break(Session& session, std::int64_t time_ns) {
  session.since_break = 0;
  session.break_from_ns = time_ns;
  return show_current(session, time_ns);
}

Effects leave_pause(Session& session, std::int64_t time_ns) {
  session.screen = session.paused;
  if (session.break_from_ns) *session.break_from_ns += time_ns - session.paused_at_ns;  // a pause is no work
  Effects effects{RecordNote{"continue", "", time_ns}};
  if (session.screen == Screen::kTrial) {
    for (SessionEffect& effect : show_current(session, time_ns)) effects.push_back(std::move(effect));
  }
  return effects;
}

Effects take(Session& session, const ContinueEvent& event) {
  switch (session.screen) {
    case Screen::kInstructions:
      return leave_instructions(session, event.time_ns);
    case Screen::kFamiliar:
      return turn_page(session, event.time_ns);
    case Screen::kPractice:
      return show_current(session, event.time_ns);
    case Screen::kFeedback:
      return leave_feedback(session, event.time_ns);
    case Screen::kMain:
    case Screen::kBreak:
      return begin_after_break(session, event.time_ns);
    case Screen::kPause:
      return leave_pause(session, event.time_ns);
    default:
      return {};
  }
}

Effects take(Session& session, const BackEvent&) {
  if (session.screen != Screen::kFamiliar) return {};
  if (session.page == 0) {
    session.screen = Screen::kInstructions;
  } else {
    --session.page;
  }
  return {};
}

Effects take(Session& session, const ShownEvent& event) {
  const bool expected = session.screen == Screen::kTrial && event.trial == session.current;
  if (expected && !session.onset_ns) session.onset_ns = event.time_ns;
  return {};
}

bool is_break_due(const Session& session, std::int64_t now_ns) {
  const SessionRules& rules = session.rules;
  if (rules.break_every_trials && session.since_break >= *rules.break_every_trials) return true;
  return rules.break_every_ns && session.break_from_ns &&
         now_ns - *session.break_from_ns >= *rules.break_every_ns;
}

// Fills the trial that is on the screen, and goes on to the next one.
Answer fill_answer(Session& session, const AnswerEvent& event) {
  const std::int64_t response_ns = event.time_ns - *session.onset_ns;
  const Answer answer{session.current, event.side, response_ns,
                      response_ns < session.rules.least_response_ns};
  TrialRow& trial = session.trials[static_cast<std::size_t>(session.current)];
  trial.answer = answer.side;
  trial.response_time_ns = answer.response_time_ns;
  trial.too_fast = answer.too_fast;
  session.onset_ns.reset();
  session.last_answered = session.current;
  session.current = find_unanswered(session, session.current + 1);
  return answer;
}

Effects take(Session& session, const AnswerEvent& event) {
  if (session.screen != Screen::kTrial || !session.onset_ns || event.time_ns <= *session.onset_ns) return {};
  const bool practised = is_practice(session, session.current);
  const Answer answer = fill_answer(session, event);
  if (!practised) ++session.since_break;
  if (session.current == count_of(session)) {
    session.screen = Screen::kThanks;
    return {RecordAnswer{answer, std::nullopt, event.time_ns}, RecordFinish{event.time_ns}};
  }
  if (practised) {
    session.screen = Screen::kFeedback;
    return {RecordAnswer{answer, std::nullopt, event.time_ns}};
  }
  if (is_break_due(session, event.time_ns)) {
    session.screen = Screen::kBreak;
    return {RecordAnswer{answer, std::nullopt, event.time_ns}, RecordNote{"break", "", event.time_ns}};
  }
  return {RecordAnswer{answer, session.current, event.time_ns}, ShowTrial{session.current}};
}

Effects take(Session& session, const PauseEvent& event) {
  if (is_over(session) || session.screen == Screen::kPause) return {};
  session.paused = session.screen;
  session.paused_at_ns = event.time_ns;
  session.screen = Screen::kPause;
  session.onset_ns.reset();
  return {RecordNote{"pause", "", event.time_ns}};
}

Effects take(Session& session, const AbortEvent& event) {
  if (is_over(session)) return {};
  session.screen = Screen::kAborted;
  session.onset_ns.reset();
  return {RecordAbort{event.reason, event.time_ns}};
}

Effects take(Session& session, const InterruptEvent& event) {
  if (is_over(session)) return {};
  session.screen = Screen::kInterrupted;
  session.onset_ns.reset();
  return {RecordNote{"interrupt", event.reason, event.time_ns}};
}

Effects take(Session&, const NoteEvent& event) {
  return {RecordNote{event.kind, event.detail, event.time_ns}};
}

}  // namespace

bool is_over(const Session& session) {
  return session.screen == Screen::kThanks || session.screen == Screen::kAborted ||
         session.screen == Screen::kInterrupted;
}

TrialProgress find_progress(const Session& session) {
  const int place = std::min(session.current, count_of(session) - 1);
  if (place < 0) return {};
  const bool practice = is_practice(session, place);
  TrialProgress progress;
  for (const TrialRow& trial : session.trials) {
    if ((trial.phase == Phase::kPractice) != practice) continue;
    ++progress.count;
    progress.answered += trial.answer ? 1 : 0;
  }
  return progress;
}

Session make_session(Experiment experiment, std::vector<TrialRow> trials, const SessionRules& rules) {
  for (std::size_t i = 0; i < trials.size(); ++i) {
    EQ_CHECK(trials[i].number == static_cast<int>(i), trials[i].number, i);
  }
  Session session;
  session.experiment = experiment;
  session.trials = std::move(trials);
  session.rules = rules;
  session.current = find_unanswered(session, 0);
  return session;
}

std::vector<SessionEffect> advance(Session& session, const SessionEvent& event) {
  return std::visit([&](const auto& happened) { return take(session, happened); }, event);
}

}  // namespace equilux
