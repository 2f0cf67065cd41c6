// The experimenter's set-up: which size counts, and what is remarked on.
#include "experiment/app/setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>

#include "experiment/field_notes.h"
#include "experiment/intake.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// 110.7 pixels an inch: the paper's screen, on which a picture spans 16 x 12 degrees at 18 inches.
constexpr double kPitchM = 0.0254 / 110.7;
constexpr Size kPicture{560, 420};
const ViewingTarget kTarget{{16, 12}, 0.4572};

ScreenFacts make_facts() {
  ScreenFacts facts;
  facts.monitor = "DP-1";
  facts.mode = {1600, 1200};
  facts.mode_hz = 60;
  facts.measured_hz = 59.94;
  facts.gamma_ramp = "identity";
  return facts;
}

TEST(SetupTest, TheCardCountsBeforeTheDiagonalAndThatBeforeTheSystem) {
  ScreenFacts facts = make_facts();
  EXPECT_EQ(find_setup({}, facts, kTarget, kPicture).pitch_source, "not known");
  facts.reported_mm = {367, 275};
  SetupInput input;
  EXPECT_EQ(find_setup(input, facts, kTarget, kPicture).pitch_source, "system");
  input.diagonal_m = 2000 * kPitchM;
  EXPECT_EQ(find_setup(input, facts, kTarget, kPicture).pitch_source, "diagonal");
  input.card_px = 373;  // .0856 m at 110.7 pixels an inch: 373.07
  const ViewingSetup setup = find_setup(input, facts, kTarget, kPicture);
  EXPECT_EQ(setup.pitch_source, "card");
  EXPECT_NEAR(setup.pitch->x_m, kPitchM, 1e-3 * kPitchM);
  EXPECT_NEAR(setup.degrees->wide, 16, .1);
  EXPECT_THAT(setup.remarks, IsEmpty());
}

TEST(SetupTest, TheTypedDistanceTakesTheProtocolsPlace) {
  SetupInput input;
  input.diagonal_m = 2000 * kPitchM;
  EXPECT_EQ(find_setup(input, make_facts(), kTarget, kPicture).viewing_distance_m, .4572);
  input.viewing_distance_m = .9144;
  const ViewingSetup setup = find_setup(input, make_facts(), kTarget, kPicture);
  EXPECT_EQ(setup.viewing_distance_m, .9144);
  EXPECT_EQ(setup.distance_source, "typed");
  input.viewing_distance_m = 0;
  EXPECT_EQ(find_setup(input, make_facts(), kTarget, kPicture).distance_source, "target");
  EXPECT_THAT(setup.remarks, ElementsAre(AllOf(HasSubstr("at 91 cm"), HasSubstr("8.0 x 6.0"))));
}

TEST(SetupTest, SizesThatDisagreeAreNamed) {
  SetupInput input;
  input.diagonal_m = 2000 * kPitchM * 1.05;
  input.card_px = 373;
  EXPECT_THAT(find_setup(input, make_facts(), kTarget, kPicture).remarks,
              ElementsAre(AllOf(HasSubstr("by the card"), HasSubstr("by the diagonal"))));
  input.diagonal_m = 2000 * kPitchM * 1.02;
  EXPECT_THAT(find_setup(input, make_facts(), kTarget, kPicture).remarks, IsEmpty());
}

TEST(SetupTest, WhatIsOddAboutTheScreenIsRemarkedOn) {
  SetupInput input;
  input.card_px = 373;
  ScreenFacts facts = make_facts();
  facts.content_scale = 1.5;
  facts.gamma_ramp = "changed";
  facts.measured_hz = 144;
  EXPECT_THAT(find_setup(input, facts, kTarget, kPicture).remarks,
              ElementsAre(HasSubstr("by 1.50"), HasSubstr("gamma ramp"), HasSubstr("144.0 Hz")));
  facts = make_facts();
  facts.mode_hz = 0;  // a system that does not say
  EXPECT_THAT(find_setup(input, facts, kTarget, kPicture).remarks, IsEmpty());
}

TEST(SetupTest, TheFieldsOfASessionTellHowItWasSetUp) {
  SetupInput input;
  input.card_px = 373;
  const ScreenFacts facts = make_facts();
  const auto fields = find_screen_fields(find_setup(input, facts, kTarget, kPicture), facts);
  EXPECT_EQ(fields.at("pixel_pitch_source"), "card");
  EXPECT_EQ(fields.at("viewing_distance_source"), "target");
  EXPECT_EQ(fields.at("pixel_pitch_x_mm"), "0.22949");
  EXPECT_EQ(fields.at("refresh_hz_measured"), "59.940");
  EXPECT_EQ(fields.at("video_mode"), "1600x1200");
}

TEST(SetupTest, AChangedGammaRampIsKept) {
  std::vector<std::uint16_t> identity(256), halved(1024);
  for (std::size_t i = 0; i < identity.size(); ++i) identity[i] = static_cast<std::uint16_t>(257 * i);
  for (std::size_t i = 0; i < halved.size(); ++i)
    halved[i] = static_cast<std::uint16_t>(32767.5 * static_cast<double>(i) / 1023);
  ScreenFacts facts = make_facts();
  EXPECT_FALSE(find_screen_fields(find_setup({}, facts, kTarget, kPicture), facts).contains("gamma_curve"));
  facts.gamma_curve = find_gamma_curve({identity, halved, {0, 65535}});
  EXPECT_EQ(facts.gamma_curve,
            "0 0.125 0.251 0.376 0.502 0.624 0.749 0.875 1; 0 0.0625 0.125 0.188 0.25 0.312 0.375 0.437 0.5; "
            "0 0 0 0 1 1 1 1 1");
  EXPECT_EQ(find_screen_fields(find_setup({}, facts, kTarget, kPicture), facts).at("gamma_curve"),
            facts.gamma_curve);
}

ScreenFacts at_rate(double mode_hz, std::optional<double> measured_hz) {
  ScreenFacts facts;
  facts.mode_hz = mode_hz;
  facts.measured_hz = measured_hz;
  return facts;
}

// One and a half frames: 25 ms at 60 Hz, 10.4 ms at 144 Hz, 62.5 ms at 24 Hz.
TEST(SetupTest, AShowingIsSlowFromOneDroppedFrameOnWhereTheRateIsTheScreensOwn) {
  constexpr std::int64_t kUs = 1'000;
  for (const auto& [hz, most_us] :
       {std::pair(60.0, 25'000), std::pair(144.0, 10'416), std::pair(24.0, 62'500)}) {
    EXPECT_FALSE(is_slow_showing(most_us * kUs, at_rate(hz, hz))) << hz;
    EXPECT_TRUE(is_slow_showing((most_us + 1) * kUs, at_rate(hz, hz))) << hz;
  }
  EXPECT_TRUE(is_slow_showing(26'000 * kUs, at_rate(60, 59.0)));
}

// Else two frames, and never less than 50 ms; without a rate 50 ms alone.
TEST(SetupTest, WhereFramesAreNotInStepWithTheScreenAShowingIsSlowBy50Ms) {
  constexpr std::int64_t kMs = 1'000'000;
  for (const ScreenFacts& facts : {at_rate(60, 700.0), at_rate(60, 144.0), at_rate(0, 60.0), at_rate(60, 0.0),
                                   at_rate(60, std::nullopt)}) {
    EXPECT_FALSE(is_slow_showing(50 * kMs, facts)) << facts.measured_hz.value_or(-1);
    EXPECT_TRUE(is_slow_showing(50 * kMs + 1, facts)) << facts.measured_hz.value_or(-1);
  }
  EXPECT_FALSE(is_slow_showing(83 * kMs, at_rate(60, 24.0))) << "two frames of a film";
  EXPECT_TRUE(is_slow_showing(84 * kMs, at_rate(60, 24.0)));
}

// Intervals of 60 and 144 Hz with one dropped frame; and of a screen that does not wait.
TEST(SetupTest, TheRefreshRateIsThatOfTheMedianInterval) {
  for (const double hz : {60.0, 144.0}) {
    std::vector<std::int64_t> shown;
    for (int i = 0; i < 40; ++i)
      shown.push_back(static_cast<std::int64_t>((i + (i > 20 ? 1 : 0)) * 1e9 / hz));
    EXPECT_NEAR(find_refresh_hz(shown).value_or(0), hz, 1e-4);
  }
  EXPECT_FALSE(find_refresh_hz({5, 5, 5, 5}).has_value());
  EXPECT_FALSE(find_refresh_hz({1, 2}).has_value());
}

// What is not of this program's window: a merge's, a lane's.
std::set<std::string> list_other_fields() { return {"prompt", "lane", "clock_behind_hours", "renamed_from"}; }

TEST(FieldNotes, DescribeEveryFieldThatASessionWrites) {
  std::set<std::string> written = list_other_fields();
  ScreenFacts facts = make_facts();
  facts.gamma_curve = "0 1";
  const ViewingSetup setup = find_setup({0.5, 0, 0.6}, facts, kTarget, kPicture);
  for (const auto& [name, value] : find_screen_fields(setup, facts)) written.insert(name);
  SessionProtocol protocol;
  protocol.consent = Consent{"1", {"text"}};
  Intake intake;
  for (const Question question :
       {Question::kAgeBand, Question::kAcuity, Question::kColourVision, Question::kAmbientLight})
    intake.answers[question] = enumerate_choices(question).front();
  for (const auto& [name, value] : find_fields(intake, protocol)) written.insert(name);
  std::set<std::string> described;
  for (const ColumnNote& note : field_notes()) described.insert(note.name);
  EXPECT_EQ(described, written);
}

TEST(FieldNotes, NameTheLevelsOfEveryQuestion) {
  for (const Question question :
       {Question::kAgeBand, Question::kAcuity, Question::kColourVision, Question::kAmbientLight}) {
    std::vector<std::string> described;
    for (const ColumnNote& note : field_notes()) {
      if (note.name != format_question(question)) continue;
      for (const auto& [level, meaning] : note.levels) described.push_back(level);
    }
    EXPECT_EQ(described, enumerate_choices(question)) << format_question(question);
  }
}

}  // namespace
}  // namespace equilux
