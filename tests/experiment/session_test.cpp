// The session by its events alone: no clock, no window, no log.
#include "experiment/session.h"

#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "base/error.h"
#include "tests/experiment/fake_trials.h"

namespace equilux {
namespace {

Session start(int count) { return make_session(Experiment::kArtifact, make_fake_trials(count)); }

// Brings the pair that is due on the screen.
void show(Session& session, std::int64_t time_ns) {
  EXPECT_TRUE(advance(session, ShownEvent{session.current, time_ns}).empty());
}

template <typename T>
const T& effect_at(const std::vector<SessionEffect>& effects, std::size_t index) {
  EXPECT_LT(index, effects.size());
  const T* effect = std::get_if<T>(&effects.at(index));
  EXPECT_NE(effect, nullptr) << "effect " << index << " is number " << effects.at(index).index();
  return *effect;
}

TEST(Session, RecordsAShowingBeforeItShows) {
  Session session = start(3);
  EXPECT_EQ(session.screen, Screen::kInstructions);
  const auto effects = advance(session, ContinueEvent{10});
  ASSERT_EQ(effects.size(), 2u);
  EXPECT_EQ(effect_at<RecordShowing>(effects, 0).trial, 0);
  EXPECT_EQ(effect_at<RecordShowing>(effects, 0).time_ns, 10);
  EXPECT_EQ(effect_at<ShowTrial>(effects, 1).trial, 0);
  EXPECT_EQ(session.screen, Screen::kTrial);
}

TEST(Session, RecordsAnAnswerWithTheNextShowingBeforeItShowsTheNext) {
  Session session = start(3);
  advance(session, ContinueEvent{0});
  show(session, 100);
  const auto effects = advance(session, AnswerEvent{Side::kRight, 350});
  ASSERT_EQ(effects.size(), 2u);
  const auto& recorded = effect_at<RecordAnswer>(effects, 0);
  EXPECT_EQ(recorded.answer.trial, 0);
  EXPECT_EQ(recorded.answer.side, Side::kRight);
  EXPECT_EQ(recorded.answer.response_time_ns, 250);
  EXPECT_EQ(recorded.next, std::optional(1));
  EXPECT_EQ(recorded.time_ns, 350);
  EXPECT_EQ(effect_at<ShowTrial>(effects, 1).trial, 1);
  EXPECT_EQ(session.trials[0].answer, std::optional(Side::kRight));
  EXPECT_EQ(session.trials[0].response_time_ns, std::optional<std::int64_t>(250));
}

TEST(Session, IgnoresAPressBeforeTheOnset) {
  Session session = start(2);
  advance(session, ContinueEvent{0});
  EXPECT_TRUE(advance(session, AnswerEvent{Side::kLeft, 50}).empty());
  show(session, 100);
  EXPECT_TRUE(advance(session, AnswerEvent{Side::kLeft, 99}).empty());
  EXPECT_TRUE(advance(session, AnswerEvent{Side::kLeft, 100}).empty());
  EXPECT_EQ(session.current, 0);
  EXPECT_EQ(advance(session, AnswerEvent{Side::kLeft, 101}).size(), 2u);
}

TEST(Session, IgnoresASecondPress) {
  Session session = start(2);
  advance(session, ContinueEvent{0});
  show(session, 100);
  advance(session, AnswerEvent{Side::kLeft, 200});
  EXPECT_TRUE(advance(session, AnswerEvent{Side::kRight, 201}).empty());
  EXPECT_EQ(session.trials[0].answer, std::optional(Side::kLeft));
  EXPECT_FALSE(session.trials[1].answer);
  EXPECT_EQ(session.current, 1);
}

TEST(Session, MeasuresFromTheFirstOnsetOfAShowing) {
  Session session = start(2);
  advance(session, ContinueEvent{0});
  show(session, 100);
  show(session, 180);
  const auto effects = advance(session, AnswerEvent{Side::kLeft, 200});
  EXPECT_EQ(effect_at<RecordAnswer>(effects, 0).answer.response_time_ns, 100);
}

TEST(Session, IgnoresTheOnsetOfAnotherPair) {
  Session session = start(3);
  advance(session, ContinueEvent{0});
  EXPECT_TRUE(advance(session, ShownEvent{1, 100}).empty());
  EXPECT_FALSE(session.onset_ns);
  EXPECT_TRUE(advance(session, AnswerEvent{Side::kLeft, 200}).empty());
}

TEST(Session, FinishesAfterTheLastAnswer) {
  Session session = start(1);
  advance(session, ContinueEvent{0});
  show(session, 100);
  const auto effects = advance(session, AnswerEvent{Side::kLeft, 300});
  ASSERT_EQ(effects.size(), 2u);
  EXPECT_FALSE(effect_at<RecordAnswer>(effects, 0).next);
  EXPECT_EQ(effect_at<RecordFinish>(effects, 1).time_ns, 300);
  EXPECT_EQ(session.screen, Screen::kThanks);
  EXPECT_EQ(session.current, 1);
}

TEST(Session, ShowsTheWaitingPairAgainAfterAnInterruption) {
  auto trials = make_fake_trials(3);
  trials[0].answer = Side::kLeft;
  Session session = make_session(Experiment::kArtifact, trials);
  EXPECT_EQ(session.current, 1);
  const auto effects = advance(session, ContinueEvent{5});
  EXPECT_EQ(effect_at<RecordShowing>(effects, 0).trial, 1);
  EXPECT_EQ(effect_at<ShowTrial>(effects, 1).trial, 1);
}

TEST(Session, SkipsPairsThatWereAnsweredBefore) {
  auto trials = make_fake_trials(4);
  trials[1].answer = trials[2].answer = Side::kLeft;
  Session session = make_session(Experiment::kArtifact, trials);
  advance(session, ContinueEvent{0});
  show(session, 1);
  EXPECT_EQ(effect_at<RecordAnswer>(advance(session, AnswerEvent{Side::kLeft, 2}), 0).next, std::optional(3));
}

TEST(Session, OnlyFinishesWhereAllWasAnsweredBeforeAnInterruption) {
  auto trials = make_fake_trials(2);
  for (TrialRow& trial : trials) trial.answer = Side::kRight;
  Session session = make_session(Experiment::kArtifact, trials);
  const auto effects = advance(session, ContinueEvent{9});
  ASSERT_EQ(effects.size(), 1u);
  EXPECT_EQ(effect_at<RecordFinish>(effects, 0).time_ns, 9);
  EXPECT_EQ(session.screen, Screen::kThanks);
}

TEST(Session, AbortsFromInstructionsAndTrials) {
  for (const bool begun : {false, true}) {
    Session session = start(2);
    if (begun) advance(session, ContinueEvent{0});
    const auto effects = advance(session, AbortEvent{"felt unwell", 7});
    ASSERT_EQ(effects.size(), 1u);
    EXPECT_EQ(effect_at<RecordAbort>(effects, 0).reason, "felt unwell");
    EXPECT_EQ(effect_at<RecordAbort>(effects, 0).time_ns, 7);
    EXPECT_EQ(session.screen, Screen::kAborted);
  }
}

// Wherever the window was closed: the trials stay as they are, and no end is recorded.
TEST(Session, AnInterruptionIsNotedAsSuchFromAnyScreen) {
  for (const int steps : {0, 1, 2, 3}) {
    Session session = start(2);
    if (steps > 0) advance(session, ContinueEvent{0});
    if (steps > 1) show(session, 1);
    if (steps > 2) advance(session, PauseEvent{2});
    const auto effects = advance(session, InterruptEvent{"the window was closed", 7});
    ASSERT_EQ(effects.size(), 1u) << steps;
    EXPECT_EQ(effect_at<RecordNote>(effects, 0).kind, "interrupt");
    EXPECT_EQ(effect_at<RecordNote>(effects, 0).detail, "the window was closed");
    EXPECT_EQ(effect_at<RecordNote>(effects, 0).time_ns, 7);
    EXPECT_EQ(session.screen, Screen::kInterrupted);
    EXPECT_TRUE(is_over(session));
    EXPECT_EQ(session.current, 0);
  }
}

// Every event on the screens that wait for none of them.
TEST(Session, TakesNothingAfterItsEnd) {
  Session finished = start(1);
  advance(finished, ContinueEvent{0});
  show(finished, 1);
  advance(finished, AnswerEvent{Side::kLeft, 2});
  Session aborted = start(1);
  advance(aborted, AbortEvent{"", 0});
  Session interrupted = start(1);
  advance(interrupted, InterruptEvent{"", 0});
  for (Session* session : {&finished, &aborted, &interrupted}) {
    const Screen screen = session->screen;
    for (const SessionEvent& event : std::initializer_list<SessionEvent>{
             ContinueEvent{3}, ShownEvent{0, 3}, ShownEvent{1, 3}, AnswerEvent{Side::kRight, 4},
             PauseEvent{5}, AbortEvent{"", 5}, InterruptEvent{"", 5}}) {
      EXPECT_TRUE(advance(*session, event).empty());
      EXPECT_EQ(session->screen, screen);
    }
  }
}

TEST(Session, TakesNoAnswerOnTheInstructions) {
  Session session = start(1);
  EXPECT_TRUE(advance(session, AnswerEvent{Side::kLeft, 1}).empty());
  EXPECT_TRUE(advance(session, ShownEvent{0, 1}).empty());
  EXPECT_EQ(session.screen, Screen::kInstructions);
  EXPECT_FALSE(session.onset_ns);
}

TEST(Session, RefusesTrialsOutOfOrder) {
  auto trials = make_fake_trials(2);
  std::swap(trials[0], trials[1]);
  EXPECT_THROW(make_session(Experiment::kArtifact, trials), CheckFailure);
}

// Two practice trials, then six counted ones.
Session start_with_pages(const SessionRules& rules) {
  auto trials = make_fake_trials(8);
  trials[0].phase = trials[1].phase = Phase::kPractice;
  return make_session(Experiment::kArtifact, trials, rules);
}

// The pair that is due is shown at `time_ns` and answered `after_ns` later.
std::vector<SessionEffect> answer(Session& session, std::int64_t time_ns, std::int64_t after_ns = 100) {
  show(session, time_ns);
  return advance(session, AnswerEvent{Side::kLeft, time_ns + after_ns});
}

TEST(Session, LeadsFromFamiliarPagesThroughPracticeWithFeedbackToTheMainPart) {
  Session session = start_with_pages({.familiar_pages = 2});
  EXPECT_TRUE(advance(session, ContinueEvent{1}).empty());
  EXPECT_EQ(session.screen, Screen::kFamiliar);
  advance(session, ContinueEvent{2});
  EXPECT_EQ(session.page, 1);
  advance(session, BackEvent{3});
  EXPECT_EQ(session.page, 0);
  advance(session, BackEvent{3});
  EXPECT_EQ(session.screen, Screen::kInstructions);
  EXPECT_TRUE(advance(session, BackEvent{3}).empty());
  EXPECT_EQ(session.screen, Screen::kInstructions);
  EXPECT_TRUE(advance(session, ContinueEvent{4}).empty());
  EXPECT_EQ(session.page, 0);
  advance(session, ContinueEvent{4});
  advance(session, ContinueEvent{5});
  EXPECT_EQ(session.screen, Screen::kPractice);
  EXPECT_EQ(effect_at<ShowTrial>(advance(session, ContinueEvent{6}), 1).trial, 0);
  EXPECT_EQ(find_progress(session).count, 2);
  const auto effects = answer(session, 100);
  ASSERT_EQ(effects.size(), 1u);
  EXPECT_FALSE(effect_at<RecordAnswer>(effects, 0).next);
  EXPECT_EQ(session.screen, Screen::kFeedback);
  EXPECT_EQ(session.last_answered, std::optional(0));
  EXPECT_EQ(effect_at<ShowTrial>(advance(session, ContinueEvent{300}), 1).trial, 1);
  answer(session, 400);
  EXPECT_TRUE(advance(session, ContinueEvent{600}).empty());
  EXPECT_EQ(session.screen, Screen::kMain);
  EXPECT_EQ(effect_at<ShowTrial>(advance(session, ContinueEvent{700}), 1).trial, 2);
  EXPECT_EQ(effect_at<RecordAnswer>(answer(session, 800), 0).next, std::optional(3));
  EXPECT_EQ(find_progress(session).answered, 1);
  EXPECT_EQ(find_progress(session).count, 6);
}

TEST(Session, RestsAfterSoManyTrialsButNotAfterTheLast) {
  Session session = start_with_pages({.break_every_trials = 3});
  for (TrialRow& trial : session.trials)
    trial.answer = trial.number < 2 ? std::optional(Side::kLeft) : std::nullopt;
  session.current = 2;
  advance(session, ContinueEvent{0});
  advance(session, ContinueEvent{0});
  answer(session, 100);
  answer(session, 300);
  const auto effects = answer(session, 500);
  EXPECT_FALSE(effect_at<RecordAnswer>(effects, 0).next);
  EXPECT_EQ(effect_at<RecordNote>(effects, 1).kind, "break");
  EXPECT_EQ(session.screen, Screen::kBreak);
  EXPECT_TRUE(advance(session, AnswerEvent{Side::kLeft, 700}).empty());
  EXPECT_EQ(effect_at<RecordShowing>(advance(session, ContinueEvent{9000}), 0).trial, 5);
  answer(session, 9100);
  answer(session, 9300);
  answer(session, 9500);
  EXPECT_EQ(session.screen, Screen::kThanks);
}

TEST(Session, RestsAfterSoLongSinceTheLastBreak) {
  Session session = make_session(Experiment::kArtifact, make_fake_trials(6), {.break_every_ns = 1000});
  advance(session, ContinueEvent{50});
  answer(session, 100);
  EXPECT_EQ(session.screen, Screen::kTrial);
  answer(session, 949, 100);
  EXPECT_EQ(session.screen, Screen::kTrial) << "999 after the first showing";
  answer(session, 1050, 1);
  EXPECT_EQ(session.screen, Screen::kBreak);
  advance(session, ContinueEvent{5000});
  answer(session, 5100);
  EXPECT_EQ(session.screen, Screen::kTrial);
}

TEST(Session, DoesNotCountAPauseAsTimeWithoutABreak) {
  Session session = make_session(Experiment::kArtifact, make_fake_trials(6), {.break_every_ns = 1000});
  advance(session, ContinueEvent{50});
  answer(session, 100);
  advance(session, PauseEvent{200});
  advance(session, ContinueEvent{9000});
  answer(session, 9001, 100);
  EXPECT_EQ(session.screen, Screen::kTrial) << "8800 of 9051 were a pause";
  answer(session, 9700, 149);
  EXPECT_EQ(session.screen, Screen::kTrial) << "999 at it";
  answer(session, 9849, 1);
  EXPECT_EQ(session.screen, Screen::kBreak);
}

TEST(Session, MarksAnswersThatCameTooSoonAndKeepsThem) {
  Session session = make_session(Experiment::kArtifact, make_fake_trials(2), {.least_response_ns = 200});
  advance(session, ContinueEvent{0});
  EXPECT_TRUE(effect_at<RecordAnswer>(answer(session, 100, 199), 0).answer.too_fast);
  EXPECT_TRUE(session.trials[0].too_fast);
  EXPECT_FALSE(effect_at<RecordAnswer>(answer(session, 500, 200), 0).answer.too_fast);
}

TEST(Session, ShowsThePairAgainAfterAPause) {
  Session session = start(3);
  advance(session, ContinueEvent{0});
  show(session, 100);
  const auto paused = advance(session, PauseEvent{150});
  EXPECT_EQ(effect_at<RecordNote>(paused, 0).kind, "pause");
  EXPECT_EQ(session.screen, Screen::kPause);
  EXPECT_TRUE(advance(session, AnswerEvent{Side::kLeft, 160}).empty());
  EXPECT_TRUE(advance(session, PauseEvent{170}).empty());
  const auto effects = advance(session, ContinueEvent{900});
  EXPECT_EQ(effect_at<RecordNote>(effects, 0).kind, "continue");
  EXPECT_EQ(effect_at<RecordShowing>(effects, 1).trial, 0);
  EXPECT_EQ(effect_at<ShowTrial>(effects, 2).trial, 0);
  const auto answered = answer(session, 1000, 40);
  EXPECT_EQ(effect_at<RecordAnswer>(answered, 0).answer.response_time_ns, 40) << "from the second onset";
}

TEST(Session, GoesBackFromAPauseToThePageItStoppedAt) {
  Session session = start_with_pages({.familiar_pages = 3});
  advance(session, ContinueEvent{0});
  advance(session, ContinueEvent{1});
  advance(session, PauseEvent{2});
  EXPECT_EQ(advance(session, ContinueEvent{3}).size(), 1u);
  EXPECT_EQ(session.screen, Screen::kFamiliar);
  EXPECT_EQ(session.page, 1);
  advance(session, PauseEvent{4});
  EXPECT_EQ(effect_at<RecordAbort>(advance(session, AbortEvent{"fire alarm", 5}), 0).reason, "fire alarm");
  EXPECT_EQ(session.screen, Screen::kAborted);
}

TEST(Session, AfterAnInterruptionSkipsWhatTheSubjectHasSeen) {
  Session session = start_with_pages({.familiar_pages = 3});
  session.trials[0].answer = Side::kLeft;
  session = make_session(Experiment::kArtifact, session.trials, session.rules);
  advance(session, ContinueEvent{0});
  EXPECT_EQ(session.screen, Screen::kPractice);
  for (int i = 1; i < 4; ++i) session.trials[static_cast<std::size_t>(i)].answer = Side::kLeft;
  session = make_session(Experiment::kArtifact, session.trials, session.rules);
  EXPECT_EQ(effect_at<ShowTrial>(advance(session, ContinueEvent{0}), 1).trial, 4);
}

TEST(Session, RecordsWhatHappenedToTheScreenWithoutGoingOn) {
  Session session = start(2);
  advance(session, ContinueEvent{0});
  show(session, 100);
  const auto effects = advance(session, NoteEvent{"focus_lost", "", 150});
  ASSERT_EQ(effects.size(), 1u);
  EXPECT_EQ(effect_at<RecordNote>(effects, 0).kind, "focus_lost");
  EXPECT_EQ(effect_at<RecordNote>(effects, 0).time_ns, 150);
  EXPECT_EQ(session.onset_ns, std::optional<std::int64_t>(100));
}

// A screen of a given rate, and a subject who presses after so long: what is drawn is seen at the next frame;
// at 0 Hz frames do not wait.
struct Sitting {
  std::vector<std::int64_t> responses_ns;
  int breaks = 0;
};

Sitting sit(int trials, double hz, std::int64_t response_ns, std::int64_t break_every_ns) {
  Session session =
      make_session(Experiment::kArtifact, make_fake_trials(trials), {.break_every_ns = break_every_ns});
  Sitting sitting;
  std::int64_t clock_ns = 12345;
  const auto wait_for_frame = [&] {
    if (hz == 0) return;
    const auto frames = static_cast<std::int64_t>(static_cast<double>(clock_ns) * hz / 1e9) + 1;
    clock_ns = static_cast<std::int64_t>(std::ceil(static_cast<double>(frames) * 1e9 / hz));
  };
  advance(session, ContinueEvent{clock_ns});
  while (session.screen != Screen::kThanks) {
    if (session.screen == Screen::kBreak) {
      ++sitting.breaks;
      advance(session, ContinueEvent{clock_ns += 1000});
    }
    wait_for_frame();
    advance(session, ShownEvent{session.current, clock_ns});
    EXPECT_TRUE(advance(session, AnswerEvent{Side::kLeft, clock_ns}).empty()) << "pressed at the onset";
    clock_ns += response_ns;
    const auto effects = advance(session, AnswerEvent{Side::kLeft, clock_ns});
    sitting.responses_ns.push_back(effect_at<RecordAnswer>(effects, 0).answer.response_time_ns);
    if (session.screen == Screen::kTrial) {
      EXPECT_EQ(effect_at<ShowTrial>(effects, effects.size() - 1).trial, session.current) << "at once";
    }
  }
  return sitting;
}

class SessionAtRate : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Screens, SessionAtRate, testing::Values(0.0, 60.0, 144.0), [](const auto& rate) {
  return std::to_string(static_cast<int>(rate.param)) + "Hz";
});

TEST_P(SessionAtRate, MeasuresThePressFromTheOnsetAndAsksForTheNextPairAtOnce) {
  constexpr std::int64_t kResponseNs = 1'234'567'891, kMinuteNs = 60'000'000'000;
  const Sitting sitting = sit(120, GetParam(), kResponseNs, kMinuteNs);
  EXPECT_EQ(sitting.responses_ns, std::vector<std::int64_t>(120, kResponseNs)) << "whatever the rate";
  // 120 answers of 1.23 s take 148 s and at most a frame each: two minutes are over in them, no third.
  EXPECT_EQ(sitting.breaks, 2);
}

}  // namespace
}  // namespace equilux
