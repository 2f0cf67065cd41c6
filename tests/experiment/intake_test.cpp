// Consent and questions without a window.
#include "experiment/intake.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>

#include "experiment/texts.h"

namespace equilux {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;

SessionProtocol make_protocol() {
  SessionProtocol protocol;
  protocol.consent = Consent{"7", {"text"}};
  protocol.questions = {{Question::kAgeBand, false}, {Question::kAcuity, true}};
  return protocol;
}

TEST(Intake, WithoutConsentAndQuestionsThereIsNothingToDo) {
  EXPECT_EQ(make_intake({}).step, IntakeStep::kDone);
  SessionProtocol protocol = make_protocol();
  protocol.consent.reset();
  EXPECT_EQ(make_intake(protocol).step, IntakeStep::kQuestions);
}

TEST(Intake, LeadsFromConsentThroughTheQuestions) {
  const SessionProtocol protocol = make_protocol();
  Intake intake = make_intake(protocol);
  submit_answers(intake, protocol);
  EXPECT_EQ(intake.step, IntakeStep::kConsent);
  give_consent(intake, protocol, true);
  submit_answers(intake, protocol);
  EXPECT_EQ(intake.step, IntakeStep::kQuestions) << "acuity is required";
  EXPECT_THAT(find_unanswered(intake, protocol), ElementsAre(Question::kAcuity));
  choose_answer(intake, protocol, Question::kAcuity, "corrected");
  submit_answers(intake, protocol);
  EXPECT_EQ(intake.step, IntakeStep::kDone);
  EXPECT_EQ(
      find_fields(intake, protocol),
      (std::map<std::string, std::string>{{"acuity", "corrected"},
                                          {"consent_digest", digest_json(make_json(protocol.consent->text))},
                                          {"consent_version", "7"},
                                          {"language", "en"}}));
}

TEST(Intake, WhoDeclinesIsAskedNothingMore) {
  const SessionProtocol protocol = make_protocol();
  Intake intake = make_intake(protocol);
  give_consent(intake, protocol, false);
  give_consent(intake, protocol, true);
  choose_answer(intake, protocol, Question::kAcuity, "normal");
  EXPECT_EQ(intake.step, IntakeStep::kDeclined);
  EXPECT_THAT(intake.answers, IsEmpty());
}

TEST(Intake, TakesOnlyAnswersThatAreOffered) {
  const SessionProtocol protocol = make_protocol();
  Intake intake = make_intake(protocol);
  give_consent(intake, protocol, true);
  choose_answer(intake, protocol, Question::kAcuity, "superb");
  choose_answer(intake, protocol, Question::kColourVision, "normal");
  EXPECT_THAT(intake.answers, IsEmpty());
  choose_answer(intake, protocol, Question::kAgeBand, "25-34");
  choose_answer(intake, protocol, Question::kAgeBand, "");
  EXPECT_THAT(intake.answers, IsEmpty()) << "an answer can be taken back";
}

// 2,000 codes of 22^6, of which four fifths have a digit: that two are equal by chance has a probability of 2
// %; none may be one that is taken.
TEST(Intake, ACodeIsNewAndSaysNothing) {
  std::vector<std::string> taken;
  for (int i = 0; i < 2000; ++i) {
    taken.push_back(draw_code(taken));
    EXPECT_EQ(taken.back().size(), 6u);
    EXPECT_NE(taken.back().find_first_of("0123456789"), std::string::npos) << taken.back();
    EXPECT_EQ(taken.back().find_first_of("0O1IL2Z5S8BAEU"), std::string::npos) << taken.back();
  }
  EXPECT_EQ(std::set<std::string>(taken.begin(), taken.end()).size(), taken.size());
}

TEST(Intake, EveryAnswerHasAText) {
  const Texts texts = load_texts("en", "");
  for (const Question question :
       {Question::kAgeBand, Question::kAcuity, Question::kColourVision, Question::kAmbientLight}) {
    EXPECT_TRUE(texts.has(format_question(question)));
    for (const std::string& choice : enumerate_choices(question))
      EXPECT_TRUE(texts.has(format_question(question) + "." + choice)) << choice;
  }
}

}  // namespace
}  // namespace equilux
