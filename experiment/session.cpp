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

Effects take(Session& session, const ContinueEvent& event) {
  if (session.screen != Screen::kInstructions) return {};
  if (session.current == count_of(session)) {  // interrupted after the last answer
    session.screen = Screen::kThanks;
    return {RecordFinish{event.time_ns}};
  }
  session.screen = Screen::kTrial;
  return {RecordShowing{session.current, event.time_ns}, ShowTrial{session.current}};
}

Effects take(Session& session, const ShownEvent& event) {
  const bool expected = session.screen == Screen::kTrial && event.trial == session.current;
  if (expected && !session.onset_ns) session.onset_ns = event.time_ns;
  return {};
}

Effects take(Session& session, const AnswerEvent& event) {
  if (session.screen != Screen::kTrial || !session.onset_ns || event.time_ns <= *session.onset_ns) return {};
  const Answer answer{session.current, event.side, event.time_ns - *session.onset_ns};
  TrialRow& trial = session.trials[static_cast<std::size_t>(session.current)];
  trial.answer = answer.side;
  trial.response_time_ns = answer.response_time_ns;
  session.onset_ns.reset();
  session.current = find_unanswered(session, session.current + 1);
  if (session.current < count_of(session)) {
    return {RecordAnswer{answer, session.current, event.time_ns}, ShowTrial{session.current}};
  }
  session.screen = Screen::kThanks;
  return {RecordAnswer{answer, std::nullopt, event.time_ns}, RecordFinish{event.time_ns}};
}

Effects take(Session& session, const AbortEvent& event) {
  if (session.screen != Screen::kInstructions && session.screen != Screen::kTrial) return {};
  session.screen = Screen::kAborted;
  session.onset_ns.reset();
  return {RecordAbort{event.reason, event.time_ns}};
}

}  // namespace

Session make_session(Experiment experiment, std::vector<TrialRow> trials) {
  for (std::size_t i = 0; i < trials.size(); ++i) {
    EQ_CHECK(trials[i].number == static_cast<int>(i), trials[i].number, i);
  }
  Session session;
  session.experiment = experiment;
  session.trials = std::move(trials);
  session.current = find_unanswered(session, 0);
  return session;
}

std::vector<SessionEffect> advance(Session& session, const SessionEvent& event) {
  return std::visit([&](const auto& happened) { return take(session, happened); }, event);
}

}  // namespace equilux
