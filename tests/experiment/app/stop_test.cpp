// What is said of a session that an error ends.
#include "experiment/app/stop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(Stop, NamesNoPictureToASubject) {
  Manifest manifest;
  manifest.pictures["G0-MS-ind-1k-C4-v0"];
  EXPECT_THAT(describe_cause("set/pictures/G0-MS-ind-1k-C4-v0.png: expected the digest 1, got 2", manifest),
              AllOf(HasSubstr("picture"), HasSubstr("terminal"), Not(HasSubstr("G0")), Not(HasSubstr("C4"))));
  EXPECT_EQ(describe_cause("responses.sqlite: disk is full", manifest), "responses.sqlite: disk is full");
}

TEST(Stop, SaysHowASessionGoesOnByItsProtocol) {
  SessionInputs inputs;
  EXPECT_THAT(describe_stop(inputs, StopState::kUnfinished),
              AllOf(HasSubstr("same participant code: it goes on"), Not(HasSubstr("hours"))));
  inputs.protocol.resume_within_hours = 2;
  EXPECT_THAT(describe_stop(inputs, StopState::kUnfinished), HasSubstr("within 2 hours"));
  inputs.protocol.may_resume = false;
  EXPECT_THAT(
      describe_stop(inputs, StopState::kUnfinished),
      AllOf(HasSubstr("is safe"), HasSubstr("lets nobody go on"), Not(HasSubstr("participant code"))));
}

TEST(Stop, PromisesNothingWhereNoSessionBeganOrItIsComplete) {
  const SessionInputs inputs;
  EXPECT_THAT(describe_stop(inputs, StopState::kNotBegun),
              AllOf(HasSubstr("nothing was recorded"), Not(HasSubstr("goes on"))));
  EXPECT_THAT(describe_stop(inputs, StopState::kComplete),
              AllOf(HasSubstr("complete"), Not(HasSubstr("goes on"))));
}

}  // namespace
}  // namespace equilux
