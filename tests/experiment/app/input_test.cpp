// Held keys, early presses and long holds, without a window.
#include "experiment/app/input.h"

#include <gtest/gtest.h>

namespace equilux {
namespace {

InputEvent key(InputKind kind, Key name, std::int64_t time_ns) {
  InputEvent event;
  event.kind = kind;
  event.key = name;
  event.time_ns = time_ns;
  return event;
}
InputEvent press(Key name, std::int64_t time_ns) { return key(InputKind::kKeyPress, name, time_ns); }
InputEvent release(Key name, std::int64_t time_ns) { return key(InputKind::kKeyRelease, name, time_ns); }
InputEvent mouse(InputKind kind, double x, std::int64_t time_ns, int button = kAnswerButton) {
  InputEvent event;
  event.kind = kind;
  event.x = x;
  event.y = 600;
  event.code = button;
  event.time_ns = time_ns;
  return event;
}

class InputTest : public testing::Test {
 protected:
  std::optional<Side> read(const InputEvent& event) {
    const auto meaning = input_.read(event, Screen::kTrial);
    if (!meaning) return std::nullopt;
    const auto* answer = std::get_if<AnswerEvent>(&*meaning);
    EXPECT_NE(answer, nullptr);
    EXPECT_EQ(answer->time_ns, event.time_ns);
    return answer->side;
  }

  SubjectInput input_{make_layout({1136, 930}, {560, 420}, Experiment::kArtifact)};
};

TEST_F(InputTest, AKeyOrAClickAnswersItsSide) {
  input_.open(100);
  EXPECT_EQ(read(press(Key::kLeft, 101)), Side::kLeft);
  read(release(Key::kLeft, 102));
  input_.open(200);
  EXPECT_EQ(read(press(Key::kRight, 201)), Side::kRight);
  read(release(Key::kRight, 202));
  input_.open(300);
  EXPECT_EQ(read(mouse(InputKind::kMousePress, 100, 301)), Side::kLeft);
  read(mouse(InputKind::kMouseRelease, 100, 302));
  input_.open(400);
  EXPECT_EQ(read(mouse(InputKind::kMousePress, 700, 401)), Side::kRight);
}

TEST_F(InputTest, NothingIsAnAnswerBeforeTheOnsetOrTwice) {
  EXPECT_EQ(read(press(Key::kLeft, 50)), std::nullopt);
  read(release(Key::kLeft, 60));
  input_.open(100);
  EXPECT_EQ(read(press(Key::kLeft, 99)), std::nullopt);  // read late, pressed early
  read(release(Key::kLeft, 101));
  EXPECT_EQ(read(press(Key::kLeft, 102)), Side::kLeft);
  read(release(Key::kLeft, 103));
  EXPECT_EQ(read(press(Key::kLeft, 104)), std::nullopt);
}

TEST_F(InputTest, WhatIsHeldFromBeforeMustBeLetGoFirst) {
  read(press(Key::kLeft, 50));
  input_.open(100);
  EXPECT_EQ(read(key(InputKind::kKeyRepeat, Key::kLeft, 150)), std::nullopt);
  EXPECT_EQ(read(press(Key::kRight, 160)), std::nullopt);
  EXPECT_EQ(read(mouse(InputKind::kMousePress, 100, 170)), std::nullopt);
  read(release(Key::kLeft, 180));
  read(release(Key::kRight, 181));
  EXPECT_EQ(read(press(Key::kLeft, 182)), std::nullopt);  // the button is still down
  read(release(Key::kLeft, 183));
  read(mouse(InputKind::kMouseRelease, 100, 184));
  EXPECT_EQ(read(press(Key::kLeft, 185)), Side::kLeft);
}

TEST_F(InputTest, ClicksBesideThePicturesOrWithOtherButtonsAreNoAnswers) {
  input_.open(100);
  EXPECT_EQ(read(mouse(InputKind::kMousePress, 568, 110)), std::nullopt);
  read(mouse(InputKind::kMouseRelease, 568, 111));
  EXPECT_EQ(read(mouse(InputKind::kMousePress, 100, 112, 1)), std::nullopt);
  read(mouse(InputKind::kMouseRelease, 100, 113, 1));
  EXPECT_EQ(read(mouse(InputKind::kMousePress, 100, 114)), Side::kLeft);
}

TEST_F(InputTest, SpaceAndEnterLeaveOnlyTheInstructions) {
  for (const Key name : {Key::kSpace, Key::kEnter}) {
    const auto meaning = input_.read(press(name, 10), Screen::kInstructions);
    ASSERT_TRUE(meaning.has_value());
    EXPECT_TRUE(std::holds_alternative<ContinueEvent>(*meaning));
    EXPECT_FALSE(input_.read(key(InputKind::kKeyRepeat, name, 11), Screen::kInstructions).has_value());
    EXPECT_FALSE(input_.read(press(name, 12), Screen::kTrial).has_value());
  }
}

// Of every page, and of both keys that turn one back.
TEST_F(InputTest, APageTakesNoPressWithinItsGuardTime) {
  for (const Screen screen : {Screen::kInstructions, Screen::kFamiliar, Screen::kPractice, Screen::kFeedback,
                              Screen::kMain, Screen::kBreak}) {
    SubjectInput input(make_layout({1136, 930}, {560, 420}, Experiment::kArtifact));
    input.open_page(1000);
    EXPECT_FALSE(input.read(press(Key::kSpace, 1000 + kPageGuardNs - 1), screen).has_value());
    input.read(release(Key::kSpace, 1000 + kPageGuardNs - 1), screen);
    EXPECT_TRUE(input.read(press(Key::kSpace, 1000 + kPageGuardNs), screen).has_value());
  }
  input_.open_page(1000);
  EXPECT_FALSE(input_.read(press(Key::kBackspace, 1001), Screen::kFamiliar).has_value());
  input_.read(release(Key::kBackspace, 1002), Screen::kFamiliar);
  const auto meaning = input_.read(press(Key::kBackspace, 1000 + kPageGuardNs), Screen::kFamiliar);
  ASSERT_TRUE(meaning.has_value());
  EXPECT_TRUE(std::holds_alternative<BackEvent>(*meaning));
}

InputEvent character(std::int64_t time_ns) {
  InputEvent event;
  event.kind = InputKind::kCharacter;
  event.time_ns = time_ns;
  return event;
}

TEST(PageGuard, KeepsOutWhatIsHeldFromBeforeUntilItIsPressedAnew) {
  PageGuard guard;
  guard.open(0, 10);
  EXPECT_TRUE(guard.admit(press(Key::kEnter, 20)));
  guard.open(100, 10);
  EXPECT_FALSE(guard.admit(key(InputKind::kKeyRepeat, Key::kEnter, 150)));
  EXPECT_FALSE(guard.admit(character(150)));
  EXPECT_FALSE(guard.admit(press(Key::kEnter, 151))) << "without a release between";
  EXPECT_TRUE(guard.admit(press(Key::kSpace, 152))) << "another key";
  EXPECT_TRUE(guard.admit(character(152)));
  EXPECT_TRUE(guard.admit(release(Key::kEnter, 160)));
  EXPECT_TRUE(guard.admit(press(Key::kEnter, 161)));
  EXPECT_TRUE(guard.admit(key(InputKind::kKeyRepeat, Key::kEnter, 170)));
}

TEST(PageGuard, AKeyPressedTooEarlyStaysOutWhileItIsHeld) {
  PageGuard guard;
  guard.open(100, 10);
  EXPECT_FALSE(guard.admit(press(Key::kDown, 109)));
  EXPECT_FALSE(guard.admit(character(109)));
  EXPECT_FALSE(guard.admit(key(InputKind::kKeyRepeat, Key::kDown, 120)));
  EXPECT_FALSE(guard.admit(mouse(InputKind::kMousePress, 5, 109)));
  EXPECT_TRUE(guard.admit(mouse(InputKind::kMouseRelease, 5, 120)));
  EXPECT_TRUE(guard.admit(mouse(InputKind::kMousePress, 5, 121)));
}

// A press every 5 where 10 must pass: for ever, until there is a rest.
TEST(PageGuard, ThatNeedsQuietIsNotWornDownByKeysPressedAgainAndAgain) {
  for (const bool needs_quiet : {false, true}) {
    PageGuard guard;
    guard.open(100, 10, needs_quiet);
    int admitted = 0;
    std::int64_t now = 100;
    for (int i = 0; i < 50; ++i) {
      now += 5;
      admitted += guard.admit(press(Key::kEnter, now)) ? 1 : 0;
      guard.admit(release(Key::kEnter, now + 1));
    }
    EXPECT_EQ(admitted, needs_quiet ? 0 : 49);
    EXPECT_TRUE(guard.admit(press(Key::kEnter, now + 10)));
  }
}

TEST_F(InputTest, EscapeMustBeHeldForTwoSecondsOnEnd) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  EXPECT_FALSE(input_.find_pause(100 * kSecond).has_value());
  read(press(Key::kEscape, kSecond));
  EXPECT_FALSE(input_.find_pause(3 * kSecond - 1).has_value());
  EXPECT_TRUE(input_.find_pause(3 * kSecond).has_value());
  read(release(Key::kEscape, 3 * kSecond));
  EXPECT_FALSE(input_.find_pause(4 * kSecond).has_value());
  read(press(Key::kEscape, 4 * kSecond));
  EXPECT_FALSE(input_.find_pause(5 * kSecond).has_value());
}

TEST(EscapeHold, IsTakenOnceAfterTwoSecondsUntilItIsLetGo) {
  EscapeHold hold;
  EXPECT_FALSE(hold.take(kPauseHoldNs));
  hold.read(press(Key::kEscape, 100));
  EXPECT_FALSE(hold.take(99 + kPauseHoldNs));
  EXPECT_TRUE(hold.take(100 + kPauseHoldNs));
  hold.read(key(InputKind::kKeyRepeat, Key::kEscape, 200 + kPauseHoldNs));
  EXPECT_FALSE(hold.take(3 * kPauseHoldNs));
  hold.read(release(Key::kEscape, 3 * kPauseHoldNs));
  hold.read(press(Key::kEscape, 3 * kPauseHoldNs));
  hold.read(release(Key::kLeft, 3 * kPauseHoldNs + 1));
  EXPECT_TRUE(hold.take(4 * kPauseHoldNs));
}

constexpr int kCode = 262;
constexpr std::int64_t kSecond = 1'000'000'000;

// The window library lets go of all keys when the focus goes, and takes the next repeat for a press.
TEST(HeldKeys, AKeyThatIsHeldWhileTheFocusGoesAndComesRepeats) {
  HeldKeys keys;
  EXPECT_EQ(keys.read(InputKind::kKeyPress, kCode, kSecond), InputKind::kKeyPress);
  keys.lose_focus(2 * kSecond);
  EXPECT_EQ(keys.read(InputKind::kKeyRelease, kCode, 2 * kSecond), InputKind::kKeyRelease);
  keys.gain_focus(5 * kSecond);
  EXPECT_EQ(keys.read(InputKind::kKeyPress, kCode, 5 * kSecond + 40), InputKind::kKeyRepeat);
  EXPECT_EQ(keys.read(InputKind::kKeyRepeat, kCode, 5 * kSecond + 80), InputKind::kKeyRepeat);
  EXPECT_EQ(keys.read(InputKind::kKeyRelease, kCode, 6 * kSecond), InputKind::kKeyRelease);
  EXPECT_EQ(keys.read(InputKind::kKeyPress, kCode, 6 * kSecond + 1), InputKind::kKeyPress);
}

TEST(HeldKeys, IsHeldThroughSeveralLossesOfFocus) {
  HeldKeys keys;
  keys.read(InputKind::kKeyPress, kCode, 1);
  for (const std::int64_t at : {2, 3}) {
    keys.lose_focus(at * kSecond);
    keys.read(InputKind::kKeyRelease, kCode, at * kSecond);
    keys.gain_focus(at * kSecond + 1);
    EXPECT_EQ(keys.read(InputKind::kKeyPress, kCode, at * kSecond + 2), InputKind::kKeyRepeat);
  }
}

// The window system tells a loss twice, and a return that is over before the key repeats.
TEST(HeldKeys, IsHeldWhereTheFocusFlickers) {
  HeldKeys keys;
  keys.read(InputKind::kKeyPress, kCode, 1);
  keys.lose_focus(2 * kSecond);
  keys.read(InputKind::kKeyRelease, kCode, 2 * kSecond);
  keys.lose_focus(2 * kSecond + 1);
  keys.gain_focus(3 * kSecond);
  keys.lose_focus(3 * kSecond + 1);
  keys.gain_focus(4 * kSecond);
  EXPECT_EQ(keys.read(InputKind::kKeyPress, kCode, 4 * kSecond + 1), InputKind::kKeyRepeat);
}

TEST(HeldKeys, APressCountsOfAKeyThatWasUpOrHasHadTimeToRepeat) {
  HeldKeys keys;
  keys.read(InputKind::kKeyPress, kCode, 1);
  keys.lose_focus(2);
  keys.read(InputKind::kKeyRelease, kCode, 2);
  keys.gain_focus(kSecond);
  EXPECT_EQ(keys.read(InputKind::kKeyPress, kCode + 1, kSecond + 1), InputKind::kKeyPress);
  EXPECT_EQ(keys.read(InputKind::kKeyPress, kCode, kSecond + kRefocusNs), InputKind::kKeyPress);
}

}  // namespace
}  // namespace equilux
