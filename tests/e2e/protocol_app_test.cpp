// A session with everything that a protocol can ask for, by real keys and clicks.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <thread>

#include "base/files.h"
#include "base/json.h"
#include "tests/e2e/app_fixture.h"
#include "tests/experiment/raw_database.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A protocol with everything in it: what it asks for comes in order, and is in the log afterwards.
constexpr const char* kWholeProtocol = R"({
  "schema": "equilux-session", "schema_version": 1,
  "consent": {"version": "7", "text": ["This is what you are asked to agree to.", "You may stop at any time."]},
  "questions": {"acuity": "required", "age_band": "optional", "ambient_light": "optional"},
  "familiarisation": {"objects": true, "examples": 1, "practice_trials": 2},
  "breaks": {"every_trials": 6}, "least_response_ms": 30, "catch_trials": {"count": 2, "pass": 1}
})";

void write_protocol(const StudyFolder& folder) { std::ofstream(folder.session()) << kWholeProtocol; }

// Without questions: who agrees begins.
void write_long_consent(const StudyFolder& folder) {
  Json::Array text;
  for (int i = 1; i <= 30; ++i)
    text.emplace_back(fmt::format(
        "{}. This is one of thirty paragraphs, each of which takes two lines or more, since it says at some "
        "length that you may stop at any time and what is kept of your answers.",
        i));
  const Json consent = Json().set("version", "7").set("text", text);
  save_text(
      folder.session(),
      format_json(Json().set("schema", "equilux-session").set("schema_version", 1).set("consent", consent)));
}

// As an impatient hand does, .15 s from one to the next.
void press_again_and_again(XDisplay& display, const std::string& key, int count) {
  for (int i = 0; i < count; ++i) {
    display.type_key(key);
    std::this_thread::sleep_for(std::chrono::milliseconds(150));
  }
}

std::vector<std::string> list_command(std::vector<std::string> command,
                                      const std::vector<std::string>& arguments) {
  command.insert(command.begin(), std::string(EQUILUX_BIN_DIR) + "/equilux-session");
  command.insert(command.end(), arguments.begin(), arguments.end());
  return command;
}

std::map<std::string, std::string> show_on(const XDisplay& display) {
  return {{"DISPLAY", display.name()}, {"LIBGL_ALWAYS_SOFTWARE", "1"}};
}

class ProtocolAppTest : public AppTest {};

TEST_F(ProtocolAppTest, AWholeProtocolLeadsFromConsentToThanks) {
  const StudyFolder folder = make_study(kPaperPlan);
  write_protocol(folder);
  XDisplay display;
  WatchedSession session(display, folder, kPaperPlan, arguments_for(folder, "artifact"));
  session.wait_for_consent("protocol-consent");
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_FALSE(std::filesystem::exists(folder.responses()));
  display.type_key("Return");
  session.wait_for_page("protocol-questions");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Return");
  session.wait_for_error("protocol-question-missing");  // acuity is required
  ASSERT_FALSE(HasFatalFailure());
  display.click(274, 441);  // "well, without glasses or lenses"
  session.wait_for_page("protocol-question-answered");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Return");
  const std::int64_t id = session.wait_for_session(Experiment::kArtifact);
  session.wait_for_page("protocol-instructions");
  ASSERT_FALSE(HasFatalFailure());
  const auto trials = session.load_trials(id);
  ASSERT_EQ(trials.size(), 2U + 2U + kSmallArtifactTrials);
  for (const char* name : {"protocol-object", "", "protocol-example", "protocol-practice"}) {
    display.type_key("space");
    session.wait_for_page(name);
    ASSERT_FALSE(HasFatalFailure());
  }
  display.type_key("space");
  for (std::size_t i = 0; i < 2; ++i) {
    session.wait_for_trial(trials[i]);
    ASSERT_FALSE(HasFatalFailure());
    const bool right = i == 0;
    session.answer_by_key((trials[i].test_side == Side::kLeft) == right ? Side::kLeft : Side::kRight);
    session.wait_for_page(right ? "protocol-feedback-right" : "protocol-feedback-wrong");
    ASSERT_FALSE(HasFatalFailure());
    display.type_key("space");
  }
  session.wait_for_page("protocol-main");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("space");
  answer_all(session, trials, 2, 8);
  session.wait_for_page("protocol-break");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("space");
  answer_all(session, trials, 8, 12);
  session.wait_for_page("protocol-thanks");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("F3");
  session.wait_for_page("protocol-summary");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Return");
  EXPECT_EQ(session.program().wait(), 0);
  EXPECT_THAT(session.program().read_output(), HasSubstr("10 of 10 answers"));
  EXPECT_THAT(session.program().read_output(), HasSubstr("Catch trials"));
  const TrialLog log(folder.responses());
  const SessionRow row = log.load_sessions().back();
  EXPECT_TRUE(row.complete);
  EXPECT_EQ(row.fields.at("consent_version"), "7");
  EXPECT_FALSE(row.fields.at("gl_renderer").empty());
  EXPECT_EQ(row.fields.at("acuity"), "normal");
  EXPECT_FALSE(row.fields.contains("age_band"));
  EXPECT_EQ(log.load_answers(SubjectKind::kPerson, Experiment::kArtifact).size(),
            static_cast<std::size_t>(kSmallArtifactTrials));
}

int count_resumes(const StudyFolder& folder, std::int64_t session) {
  int count = 0;
  for (const EventRow& event : TrialLog::load_snapshot(folder.responses()).load_events(session))
    count += event.kind == "resume" ? 1 : 0;
  return count;
}

int count_showings(const StudyFolder& folder) {
  return std::stoi(
      RawDatabase(folder.responses()).value("SELECT count(*) FROM event WHERE kind = 'showing'"));
}

// Who has agreed and was asked is asked neither again.
TEST_F(ProtocolAppTest, AnInterruptedSessionGoesOnWithoutConsentAndQuestions) {
  const StudyFolder folder = make_study(kSmallPlan);
  write_protocol(folder);
  XDisplay display;
  std::int64_t id = 0;
  {
    WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
    session.wait_for_consent("");
    ASSERT_FALSE(HasFatalFailure());
    display.type_key("Return");
    session.wait_for_page("");
    ASSERT_FALSE(HasFatalFailure());
    display.click(274, 441);
    session.wait_for_page("");
    ASSERT_FALSE(HasFatalFailure());
    display.type_key("Return");
    id = session.wait_for_session(Experiment::kArtifact);
    session.program().send_signal(SIGKILL);
    ASSERT_TRUE(session.program().wait());
  }
  // Found again on the start screen, then the set-up screen.
  WatchedSession session(display, folder, kSmallPlan, {folder.root.string()});
  session.wait_for_page("start-interrupted");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("F4");
  display.type_key("Return");
  session.wait_for_error("setup-interrupted");  // it has remarks, the start screen has none
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Return");
  EXPECT_TRUE(wait_until([&] { return count_resumes(folder, id) == 1; })) << session.program().read_output();
  EXPECT_EQ(TrialLog::load_snapshot(folder.responses()).load_sessions().size(), 1U);
  session.wait_for_page("");
  display.close_windows();
  EXPECT_EQ(session.program().wait(), 0);
  EXPECT_THAT(session.program().read_output(), HasSubstr("resume: 1"));
}

// As a subject does by Alt-F4: nobody decided that the session ends, so F4 offers it.
TEST_F(ProtocolAppTest, ASessionWhoseWindowWasClosedIsOfferedToGoOn) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  std::int64_t id = 0;
  {
    WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
    id = session.wait_for_session(Experiment::kArtifact);
    session.wait_for_page("");
    ASSERT_FALSE(HasFatalFailure());
    display.type_key("space");
    const auto trials = session.load_trials(id);
    answer_all(session, trials, 0, 1);
    session.wait_for_trial(trials[1]);
    ASSERT_FALSE(HasFatalFailure());
    display.close_windows();
    EXPECT_EQ(session.program().wait(), 0);
  }
  WatchedSession session(display, folder, kSmallPlan, {folder.root.string()});
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("F4");
  display.type_key("Return");
  session.wait_for_error("setup-after-close");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Return");
  EXPECT_TRUE(wait_until([&] { return count_resumes(folder, id) == 1; })) << session.program().read_output();
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("space");
  session.wait_for_trial(session.load_trials(id)[1]);
  EXPECT_EQ(session.count_answers(id), 1);
}

// A double click on the start, or a second experimenter.
TEST_F(ProtocolAppTest, ASecondWindowOfTheSameSessionIsRefused) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display, other;
  const auto run_second = [&] {
    ChildProcess second(list_command({"run"}, arguments_for(folder, "artifact")), show_on(other));
    EXPECT_EQ(second.wait(), 1);
    return second.read_output();
  };
  {
    WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
    const std::int64_t id = session.wait_for_session(Experiment::kArtifact);
    session.wait_for_page("");
    ASSERT_FALSE(HasFatalFailure());
    EXPECT_THAT(run_second(),
                AllOf(HasSubstr(folder.responses().string()),
                      HasSubstr("session 1 of P01, artifact experiment, which runs in another")));
    ChildProcess status(list_command({"status"}, {folder.root.string()}));
    EXPECT_EQ(status.wait(), 0);
    EXPECT_THAT(status.read_output(), HasSubstr("P01"));
    display.type_key("space");
    session.wait_for_trial(session.load_trials(id)[0]);
    ASSERT_FALSE(HasFatalFailure());
    EXPECT_EQ(count_resumes(folder, id), 0);
    session.program().send_signal(SIGKILL);
    ASSERT_TRUE(session.program().wait());
  }
  WatchedSession session(other, folder, kSmallPlan, arguments_for(folder, "artifact"));
  session.wait_for_page("");
  EXPECT_EQ(count_resumes(folder, 1), 1) << "a killed program holds nothing";
}

// The set-up screen comes though it was not asked for, and says so.
TEST_F(ProtocolAppTest, AClockBehindTheLogIsToldBeforeASessionGoesOn) {
  const StudyFolder folder = make_study(kSmallPlan);
  std::ofstream(folder.session())
      << R"({"schema": "equilux-session", "schema_version": 1, "resume": {"within_hours": 24}})";
  XDisplay display;
  std::int64_t id = 0;
  {
    WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
    id = session.wait_for_session(Experiment::kArtifact);
    session.wait_for_page("");
    ASSERT_FALSE(HasFatalFailure());
    session.program().send_signal(SIGKILL);
    ASSERT_TRUE(session.program().wait());
  }
  RawDatabase(folder.responses())
      .query("UPDATE session SET started_utc = strftime('%Y-%m-%dT%H:%M:%fZ', 'now', '+16 hours')");
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  session.wait_for_error("clock-behind");
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_EQ(count_resumes(folder, id), 0);
  display.type_key("Return");
  EXPECT_TRUE(wait_until([&] { return count_resumes(folder, id) == 1; })) << session.program().read_output();
  EXPECT_THAT(RawDatabase(folder.responses()).value("SELECT detail FROM event WHERE kind = 'resume'"),
              HasSubstr("clock_behind_hours"));
}

TEST_F(ProtocolAppTest, AClosedSessionOfAProtocolThatRunsInOneGoStaysAsItIs) {
  const StudyFolder folder = make_study(kSmallPlan);
  std::ofstream(folder.session())
      << R"({"schema": "equilux-session", "schema_version": 1, "resume": {"allowed": false}})";
  XDisplay display;
  {
    WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
    session.wait_for_session(Experiment::kArtifact);
    session.wait_for_page("");
    ASSERT_FALSE(HasFatalFailure());
    display.close_windows();
    EXPECT_EQ(session.program().wait(), 0);
    EXPECT_THAT(session.program().read_output(), HasSubstr("the protocol lets nobody go on with it"));
  }
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  EXPECT_EQ(session.program().wait(), 1);
  EXPECT_THAT(session.program().read_output(),
              HasSubstr("/resume: expected sessions that run in one go, got session 1 of P01"));
}

TEST_F(ProtocolAppTest, WhoDeclinesLeavesNoTrace) {
  const StudyFolder folder = make_study(kSmallPlan);
  write_protocol(folder);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  session.wait_for_consent("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("BackSpace");
  session.wait_for_page("protocol-declined");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Return");
  EXPECT_EQ(session.program().wait(), 0);
  EXPECT_THAT(session.program().read_output(), HasSubstr("does not take part"));
  EXPECT_FALSE(std::filesystem::exists(folder.responses()));
}

// One Down shows the frame, around agreeing; the next moves it to the refusal.
TEST_F(ProtocolAppTest, EnterOnTheRefusalThatHasTheFrameDeclines) {
  const StudyFolder folder = make_study(kSmallPlan);
  write_protocol(folder);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  session.wait_for_consent("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Down");
  for (const char* key : {"Down", "Return"}) display.press_key(key);  // before the frame has moved
  for (const char* key : {"Down", "Return"}) display.release_key(key);
  session.wait_for_page("declined-by-frame");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Return");
  EXPECT_EQ(session.program().wait(), 0);
  EXPECT_THAT(session.program().read_output(), HasSubstr("does not take part"));
  EXPECT_FALSE(std::filesystem::exists(folder.responses()));
}

// They leave the set-up, but never the consent: there is no rest between them.
TEST_F(ProtocolAppTest, KeysSentAheadGiveNoConsent) {
  const StudyFolder folder = make_study(kSmallPlan);
  write_protocol(folder);
  XDisplay display;
  auto arguments = arguments_for(folder, "artifact");
  arguments.push_back("--setup");
  WatchedSession session(display, folder, kSmallPlan, arguments);
  press_again_and_again(display, "Return", 50);
  session.wait_for_consent("consent-after-keys");
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_FALSE(session.has_changed());
  EXPECT_FALSE(std::filesystem::exists(folder.responses()));
  display.type_key("BackSpace");
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Return");
  EXPECT_EQ(session.program().wait(), 0);
  EXPECT_THAT(session.program().read_output(), HasSubstr("does not take part"));
}

// On every letter size, by keys alone.
TEST_F(ProtocolAppTest, ALongConsentIsReadToItsEndBeforeAnybodyAgrees) {
  for (const std::string scale : {"1", "3"}) {
    const StudyFolder folder = make_small_study(folder_.path() / scale, 280, 210);
    write_long_consent(folder);
    XDisplay display;
    auto arguments = arguments_for(folder, "artifact");
    arguments.insert(arguments.end(), {"--text-scale", scale});
    WatchedSession session(display, folder, kSmallPlan, arguments);
    session.wait_for_consent("long-consent-" + scale);
    ASSERT_FALSE(HasFatalFailure());
    display.type_key("Return");
    EXPECT_FALSE(session.has_changed());
    for (const auto& [down, up] : {std::pair("Next", "Prior"), std::pair("Down", "Up")}) {
      display.type_key(down);
      EXPECT_TRUE(session.has_changed()) << down;
      display.type_key("Return");
      display.type_key(up);
      EXPECT_FALSE(session.has_changed()) << up;
    }
    EXPECT_FALSE(std::filesystem::exists(folder.responses()));
    display.type_key("End");
    session.wait_for_page("long-consent-end-" + scale);
    ASSERT_FALSE(HasFatalFailure());
    display.type_key("Home");
    session.wait_for_page("");
    ASSERT_FALSE(HasFatalFailure());
    display.type_key("Return");
    EXPECT_NE(session.wait_for_session(Experiment::kArtifact), 0);
  }
}

void turn_wheel(XDisplay& display, int button, int count) {
  for (int i = 0; i < count; ++i) {
    display.press_button(button);
    display.release_button(button);
  }
}

constexpr int kWheelUp = 4, kWheelDown = 5;

// The English texts with instructions of 4,000 bytes, as many as a text may have.
void write_long_instructions(const StudyFolder& folder) {
  constexpr std::size_t kMost = 4000;
  const std::filesystem::path english =
      std::filesystem::path(EQUILUX_SOURCE_DIR) / "experiment/texts/en.json";
  Json table = parse_json(load_text(english), english.string());
  std::string text;
  for (int i = 1; text.size() < kMost; ++i)
    text += fmt::format("{}. Look at the object, and at nothing beside it. ", i);
  Json texts = *table.find("texts");
  texts.set("instructions_artifact", text.substr(0, kMost));
  save_text(folder.root / "texts-en.json", format_json(table.set("texts", texts)));
}

// The smallest screen that the pictures have room on: by keys and by the wheel, and left from either end.
TEST_F(ProtocolAppTest, InstructionsLongerThanASmallScreenScrollToTheirButton) {
  const StudyFolder folder = make_study(kSmallPlan);
  write_long_instructions(folder);
  XDisplay display(720, 510);
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  session.wait_for_session(Experiment::kArtifact);
  session.wait_for_consent("long-instructions");  // until it tells that there is more
  ASSERT_FALSE(HasFatalFailure());
  const LdrImage top = display.take_screenshot();
  display.move_pointer(360, 255);
  turn_wheel(display, kWheelDown, 3);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  turn_wheel(display, kWheelUp, 3);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_EQ(display.take_screenshot(), top);
  for (const char* key : {"Next", "Down", "End"}) {
    display.type_key(key);
    session.wait_for_page(*key == 'E' ? "long-instructions-end" : "");
    ASSERT_FALSE(HasFatalFailure()) << key;
  }
  const LdrImage end = display.take_screenshot();
  turn_wheel(display, kWheelUp, 1);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  turn_wheel(display, kWheelDown, 3);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_EQ(display.take_screenshot(), end) << "the wheel comes as far as the keys";
  display.click(100, 330);  // "Begin"
  EXPECT_TRUE(wait_until([&] { return count_showings(folder) == 1; })) << session.program().read_output();
}

TEST_F(ProtocolAppTest, ALongConsentIsReadToItsEndByTheWheelOnASmallScreen) {
  const StudyFolder folder = make_study(kSmallPlan);
  write_long_consent(folder);
  XDisplay display(720, 510);
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  session.wait_for_consent("small-consent");
  ASSERT_FALSE(HasFatalFailure());
  display.move_pointer(360, 255);
  display.type_key("Return");
  EXPECT_FALSE(session.has_changed());
  turn_wheel(display, kWheelDown, 60);
  session.wait_for_consent("");
  ASSERT_FALSE(HasFatalFailure());
  session.keep("small-consent-end");
  EXPECT_FALSE(std::filesystem::exists(folder.responses()));
  display.type_key("Return");
  EXPECT_NE(session.wait_for_session(Experiment::kArtifact), 0);
}

TEST_F(ProtocolAppTest, TheFirstPageOfObjectsLeadsBackToTheInstructions) {
  const StudyFolder folder = make_study(kSmallPlan);
  save_text(folder.session(),
            R"({"schema": "equilux-session", "schema_version": 1, "familiarisation": {"objects": true}})");
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  const LdrImage instructions = display.take_screenshot();
  display.type_key("space");
  display.type_key("space");  // too early
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("BackSpace");
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_EQ(display.take_screenshot(), instructions);
}

}  // namespace
}  // namespace equilux
