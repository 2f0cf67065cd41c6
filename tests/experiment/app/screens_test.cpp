// The start form as values; how it looks is for the window tests.
#include "experiment/app/screens.h"

#include <cstdio>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"

namespace equilux {
namespace {

AppParams filled() {
  AppParams params;
  params.study_folder = "studies/pocket";
  params.experiment = Experiment::kMaterial;
  params.participant = "P01";
  params.monitor = "HDMI-1";
  params.diagonal_m = 0.6;
  return params;
}

std::string error_of(const AppParams& params) {
  try {
    read_start_form(make_start_form(params), params);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(StartFormTest, WhatWasGivenComesBackWithWhatIsNotAskedFor) {
  const AppParams chosen = read_start_form(make_start_form(filled()), filled());
  EXPECT_EQ(chosen.study_folder, "studies/pocket");
  EXPECT_EQ(chosen.experiment, Experiment::kMaterial);
  EXPECT_EQ(chosen.participant, "P01");
  EXPECT_EQ(chosen.monitor, "HDMI-1");
  EXPECT_EQ(chosen.diagonal_m, 0.6);
}

TEST(StartFormTest, BlanksAroundATextAreDropped) {
  AppParams params = filled();
  params.participant = "  P02\t";
  EXPECT_EQ(read_start_form(make_start_form(params), params).participant, "P02");
}

TEST(StartFormTest, EachFieldThatIsMissingIsNamed) {
  AppParams params = filled();
  params.participant = "  ";
  EXPECT_THAT(error_of(params), testing::HasSubstr("Participant code"));
  params.experiment.reset();
  EXPECT_THAT(error_of(params), testing::HasSubstr("Experiment"));
  params.study_folder.clear();
  EXPECT_THAT(error_of(params), testing::HasSubstr("Study folder"));
}

TEST(SetupFormTest, TheNextMonitorIsTheOneAfterItAndRound) {
  EXPECT_EQ(find_next_monitor({"a", "b", "c"}, "a"), "b");
  EXPECT_EQ(find_next_monitor({"a", "b", "c"}, "c"), "a");
  EXPECT_EQ(find_next_monitor({"a"}, "a"), "") << "no other";
  EXPECT_EQ(find_next_monitor({"a"}, "unplugged"), "a");
  EXPECT_EQ(find_next_monitor({}, "unplugged"), "");
}

TEST(SetupFormTest, WhatWasMeasuredOnAnotherMonitorDoesNotCount) {
  SetupForm form = make_setup_form(0.6);
  std::snprintf(form.distance_cm.data(), form.distance_cm.size(), "61");
  switch_card(form);
  form.was_card_matched = true;
  forget_monitor(form);
  EXPECT_EQ(read_setup_form(form).diagonal_m, 0);
  EXPECT_EQ(read_setup_form(form).card_px, 0);
  EXPECT_DOUBLE_EQ(read_setup_form(form).viewing_distance_m, 0.61) << "from the eyes to the screen";
}

TEST(SetupFormTest, WhatTheCommandLineGaveStandsInTheForm) {
  const SetupForm form = make_setup_form(24 * .0254, .615);
  EXPECT_STREQ(form.diagonal_inches.data(), "24");
  EXPECT_STREQ(form.distance_cm.data(), "61.5");
  EXPECT_DOUBLE_EQ(read_setup_form(form).viewing_distance_m, .615);
}

// Where the bar is first says nothing of this screen.
TEST(SetupFormTest, ACardCountsOnceTheBarWasMatchedToIt) {
  SetupForm form = make_setup_form(0);
  switch_card(form);
  EXPECT_GT(form.card_px, 0);
  EXPECT_EQ(read_setup_form(form).card_px, 0);
  form.was_card_matched = true;
  EXPECT_EQ(read_setup_form(form).card_px, form.card_px);
  switch_card(form);
  EXPECT_EQ(form.card_px, 0);
  switch_card(form);
  EXPECT_EQ(read_setup_form(form).card_px, 0);
}

SetupForm typed(const char* diagonal, const char* distance) {
  SetupForm form = make_setup_form(0);
  std::snprintf(form.diagonal_inches.data(), form.diagonal_inches.size(), "%s", diagonal);
  std::snprintf(form.distance_cm.data(), form.distance_cm.size(), "%s", distance);
  return form;
}

TEST(SetupFormTest, ReadsNumbersWithPointOrComma) {
  const SetupForm form = typed(" 24 ", "61,5");
  EXPECT_TRUE(is_right(form));
  EXPECT_DOUBLE_EQ(read_setup_form(form).diagonal_m, 24 * .0254);
  EXPECT_DOUBLE_EQ(read_setup_form(form).viewing_distance_m, .615);
}

TEST(SetupFormTest, WhatIsLeftEmptyIsNotGiven) {
  EXPECT_TRUE(is_right(typed("", " ")));
  EXPECT_EQ(read_setup_form(typed("", " ")).diagonal_m, 0);
  EXPECT_EQ(read_setup_form(typed("", " ")).viewing_distance_m, 0);
}

TEST(SetupFormTest, WhatIsNoSizeIsNamedAndLeavesTheFormWrong) {
  for (const char* text : {"24\"", "60 cm", "0x10", "nan", "inf", "1e2", "-5", "0", "1.234,5", "99999"}) {
    EXPECT_FALSE(is_right(typed(text, "60"))) << text;
    EXPECT_FALSE(is_right(typed("24", text))) << text;
    EXPECT_THAT(find_errors(typed(text, "60")).diagonal, testing::HasSubstr(text));
    EXPECT_THAT(find_errors(typed("24", text)).distance, testing::HasSubstr("cm from 1 to 10000"));
    EXPECT_EQ(read_setup_form(typed("24", text)).viewing_distance_m, 0);
  }
}

TEST(ConsentFormTest, EnterIsTheChoiceThatHasTheFrame) {
  ConsentForm form;
  form.is_read = true;
  EXPECT_EQ(find_choice(form, Key::kEnter), true) << "as its button says";
  form.focused = true;
  EXPECT_EQ(find_choice(form, Key::kEnter), true);
  form.focused = false;
  EXPECT_EQ(find_choice(form, Key::kEnter), false);
  for (const auto focused : {std::optional<bool>(), std::optional(true), std::optional(false)}) {
    form.focused = focused;
    EXPECT_EQ(find_choice(form, Key::kBackspace), false);
    EXPECT_EQ(find_choice(form, Key::kSpace), std::nullopt);
  }
}

TEST(ConsentFormTest, NobodyAgreesToATextWhoseEndWasNotOnTheScreen) {
  ConsentForm form;
  EXPECT_EQ(find_choice(form, Key::kEnter), std::nullopt);
  EXPECT_EQ(take_choice(form, true), std::nullopt);
  EXPECT_EQ(take_choice(form, false), false);
  EXPECT_EQ(find_choice(form, Key::kBackspace), false);
  form.focused = false;
  EXPECT_EQ(find_choice(form, Key::kEnter), false);
}

TEST(PausePageTest, SaysWhatIsShownAgain) {
  PauseView view{{3, 36}, true, {}, ""};
  EXPECT_EQ(describe_pause(view),
            "3 of 36 answers of this part are recorded. The pair that was on the screen is shown again.");
  view.shows_pair_again = false;
  EXPECT_THAT(describe_pause(view), testing::HasSubstr("The page that was on the screen"));
}

}  // namespace
}  // namespace equilux
