// session.json: read, defaulted, refused.
#include "protocols/session_protocol.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/files.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class SessionProtocolFile : public testing::Test {
 protected:
  SessionProtocol load(const std::string& members) {
    return load_session_protocol(folder_.write(
        "session.json", R"({"schema": "equilux-session", "schema_version": 1)" + members + "}"));
  }
  std::string refusal_of(const std::string& members) {
    return message_of<InputError>([&] { load(members); });
  }
  const TempFolder folder_;
};

TEST_F(SessionProtocolFile, WithoutAFileASessionIsTrialsAlone) {
  const SessionProtocol protocol = load_session_protocol(folder_ / "missing.json");
  EXPECT_FALSE(protocol.consent || protocol.catch_trials || protocol.break_every_trials ||
               protocol.break_every_minutes);
  EXPECT_EQ(protocol.practice_trials + protocol.examples + protocol.least_response_ms, 0);
  EXPECT_TRUE(protocol.questions.empty());
  EXPECT_TRUE(protocol.may_resume);
  EXPECT_EQ(protocol.digest, "");
}

TEST_F(SessionProtocolFile, ReadsEveryMember) {
  const SessionProtocol protocol = load(R"(, "language": "de",
      "consent": {"version": "3", "text": ["a", "b"]},
      "questions": {"acuity": "required", "age_band": "optional"},
      "familiarisation": {"objects": true, "examples": 4, "practice_trials": 6},
      "breaks": {"every_trials": 100, "every_minutes": 7.5}, "least_response_ms": 250,
      "catch_trials": {"count": 8, "pass": 7}, "resume": {"allowed": false, "within_hours": 24})");
  EXPECT_EQ(protocol.language, "de");
  ASSERT_TRUE(protocol.consent);
  EXPECT_EQ(protocol.consent->version, "3");
  EXPECT_EQ(protocol.consent->text, (std::vector<std::string>{"a", "b"}));
  ASSERT_EQ(protocol.questions.size(), 2u);
  EXPECT_EQ(protocol.questions[0].question, Question::kAgeBand);
  EXPECT_FALSE(protocol.questions[0].required);
  EXPECT_TRUE(protocol.questions[1].required);
  EXPECT_TRUE(protocol.shows_objects);
  EXPECT_EQ(protocol.examples, 4);
  EXPECT_EQ(protocol.practice_trials, 6);
  EXPECT_EQ(protocol.break_every_trials, std::optional(100));
  EXPECT_EQ(protocol.break_every_minutes, std::optional(7.5));
  EXPECT_EQ(protocol.least_response_ms, 250);
  EXPECT_EQ(protocol.catch_trials->count, 8);
  EXPECT_EQ(protocol.catch_trials->pass, 7);
  EXPECT_FALSE(protocol.may_resume);
  EXPECT_EQ(protocol.resume_within_hours, std::optional(24.0));
}

TEST_F(SessionProtocolFile, AnotherConsentFormOrLanguageIsTheSameProtocol) {
  const std::string digest = load(R"(, "least_response_ms": 200)").digest;
  EXPECT_EQ(load(R"(, "least_response_ms": 200, "language": "fr",
                      "consent": {"version": "2", "text": ["neu"]}, "description": "x")")
                .digest,
            digest);
  EXPECT_NE(load(R"(, "least_response_ms": 201)").digest, digest);
}

TEST_F(SessionProtocolFile, RefusesWhatItDoesNotKnowAndWhatCannotBe) {
  EXPECT_THAT(refusal_of(R"(, "brakes": {})"), HasSubstr("brakes"));
  EXPECT_THAT(refusal_of(R"(, "questions": {"shoe_size": "optional"})"), HasSubstr("/questions"));
  EXPECT_THAT(refusal_of(R"(, "breaks": {"every_trials": 0})"), HasSubstr("/breaks/every_trials"));
  EXPECT_THAT(refusal_of(R"(, "catch_trials": {"count": 4, "pass": 5})"),
              AllOf(HasSubstr("/catch_trials/pass"), HasSubstr("at most count, 4"), HasSubstr("got 5")));
  EXPECT_THAT(refusal_of(R"(, "consent": {"version": "", "text": ["a"]})"), HasSubstr("/consent/version"));
}

// What comes along can be used as it is.
TEST_F(SessionProtocolFile, ThoseOfTheFourStudiesAreWhole) {
  for (const char* name : {"pocket", "paper", "validation", "normalisation"}) {
    const auto path = std::filesystem::path(EQUILUX_SOURCE_DIR) / "protocols" / name / "session.json";
    ASSERT_TRUE(path_exists(path)) << name;
    const SessionProtocol protocol = load_session_protocol(path);
    EXPECT_TRUE(protocol.consent && protocol.catch_trials) << name;
    EXPECT_GT(protocol.practice_trials, 0) << name;
  }
}

}  // namespace
}  // namespace equilux
