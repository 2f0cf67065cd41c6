// The start form as values; how it looks is for the window tests.
#include "experiment/app/screens.h"

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

}  // namespace
}  // namespace equilux
