// The real program on a real X server: what is on the screen, and what becomes of clicks and keys.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <thread>

#include "base/files.h"
#include "tests/e2e/app_fixture.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/raw_database.h"

namespace equilux {
namespace {

using testing::HasSubstr;

// Showings of a trial in the log.
int count_showings(const StudyFolder& folder, std::int64_t session, int trial) {
  return std::stoi(RawDatabase(folder.responses())
                       .value(fmt::format("SELECT count(*) FROM event WHERE session = {} AND trial = {} AND "
                                          "kind = 'showing'",
                                          session, trial)));
}

// Of all events of this kind, in order.
std::string load_details(const StudyFolder& folder, const std::string& kind) {
  return RawDatabase(folder.responses())
      .value(fmt::format("SELECT group_concat(detail, '; ') FROM event WHERE kind = '{}'", kind));
}

void expect_answered(const std::vector<TrialRow>& trials, int first, int end) {
  for (int i = first; i < end; ++i) {
    const TrialRow& trial = trials[static_cast<std::size_t>(i)];
    ASSERT_TRUE(trial.answer.has_value()) << "trial " << i;
    EXPECT_EQ(*trial.answer, choose_side(i)) << "trial " << i;
    EXPECT_GT(trial.response_time_ns.value_or(0), 0) << "trial " << i;
  }
}

// Instructions to thanks, at the places of the plan.
void run_whole_session(const StudyFolder& folder, const ScreenPlan& plan, Experiment experiment, int count,
                       const std::vector<std::string>& arguments) {
  XDisplay display;
  WatchedSession session(display, folder, plan, arguments);
  const std::string name = format_experiment(experiment);
  const std::int64_t id = session.wait_for_session(experiment);
  session.wait_for_page(name + "-instructions");
  ASSERT_FALSE(testing::Test::HasFatalFailure());
  const auto trials = session.load_trials(id);
  ASSERT_EQ(static_cast<int>(trials.size()), count);
  display.type_key("space");
  session.wait_for_trial(trials[0], name + "-trial");
  answer_all(session, trials, 0, count);
  session.wait_for_page(name + "-thanks");
  display.type_key("Return");
  EXPECT_EQ(session.program().wait(), 0) << session.program().read_output();
  EXPECT_THAT(session.program().read_output(), HasSubstr("is complete"));
  expect_answered(session.load_trials(id), 0, count);
  EXPECT_TRUE(TrialLog(folder.responses()).load_sessions().back().complete);
}

TEST_F(AppTest, ArtifactTrialsOfPaperSizeAreOnTheScreenPixelForPixel) {
  const StudyFolder folder = make_study(kPaperPlan);
  run_whole_session(folder, kPaperPlan, Experiment::kArtifact, kSmallArtifactTrials,
                    arguments_for(folder, "artifact"));
}

TEST_F(AppTest, MaterialTrialsOfPaperSizeShowTheReferenceAboveThePair) {
  const StudyFolder folder = make_study(kPaperPlan);
  run_whole_session(folder, kPaperPlan, Experiment::kMaterial, kSmallMaterialTrials,
                    arguments_for(folder, "material"));
}

TEST_F(AppTest, TheScreenIsRecordedWithTheSession) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  auto arguments = arguments_for(folder, "artifact");
  arguments.insert(arguments.end(), {"--diagonal", "19", "--distance", "61.5"});
  WatchedSession session(display, folder, kSmallPlan, arguments);
  session.wait_for_session(Experiment::kArtifact);
  const SessionRow row = TrialLog(folder.responses()).load_sessions().back();
  const ScreenRecord& screen = row.screen;
  EXPECT_EQ(screen.monitor, "screen");
  EXPECT_EQ(screen.framebuffer_width, 1280);
  EXPECT_EQ(screen.framebuffer_height, 1024);
  EXPECT_DOUBLE_EQ(screen.viewing_distance_m.value_or(0), 0.615);
  EXPECT_EQ(row.fields.at("viewing_distance_source"), "typed");
  // 19 in of 1639.2 pixels: 0.29441 mm a pixel; 280 pixels are 82.43 mm, 210 are 61.83 mm.
  EXPECT_NEAR(screen.degrees_wide.value_or(0), 7.669, 0.001);
  EXPECT_NEAR(screen.degrees_high.value_or(0), 5.755, 0.001);
}

TEST_F(AppTest, TheStartScreenAsksForWhatIsMissingAndSaysWhatIsWrong) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, {});
  session.wait_for_page("start");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Tab");
  display.type_text("P_07-b");
  display.type_key("F2");
  display.type_key("Return");
  session.wait_for_error("start-error");
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_FALSE(std::filesystem::exists(folder.responses()));
  display.type_text(folder.root.string());  // the keyboard is in the empty field
  display.type_key("Return");
  session.wait_for_page("setup");
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_FALSE(std::filesystem::exists(folder.responses())) << "nothing is written before the session begins";
  display.type_key("Return");
  const std::int64_t id = session.wait_for_session(Experiment::kMaterial);
  EXPECT_EQ(TrialLog(folder.responses()).load_sessions().back().participant, "P_07-b");
  session.wait_for_page("start-instructions");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("space");
  answer_all(session, session.load_trials(id), 0, kSmallMaterialTrials);
  session.wait_for_page("start-thanks");
  display.type_key("Return");
  EXPECT_EQ(session.program().wait(), 0);
}

// Nobody waits for the error: the path is typed while the start screen tries without one.
TEST_F(AppTest, WhatIsTypedWhileTheStartScreenIsBusyIsNotLost) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, {});
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Tab");
  display.type_text("P08");
  display.type_key("F1");
  display.type_key("Return");
  display.type_text(folder.root.string());
  display.type_key("Return");
  session.wait_for_error("busy-setup");  // which says that this screen's size is not known
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Return");
  ASSERT_NE(session.wait_for_session(Experiment::kArtifact), 0);
  EXPECT_EQ(TrialLog(folder.responses()).load_sessions().back().participant, "P08");
}

TEST_F(AppTest, AHeldKeyAnswersOnceAndMustBeLetGoBeforeTheNextAnswer) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  const std::int64_t id = session.wait_for_session(Experiment::kArtifact);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  const auto trials = session.load_trials(id);
  display.press_key("Left");  // before the first onset
  display.type_key("space");
  session.wait_for_trial(trials[0]);
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_TRUE(session.stays(trials[0]));
  EXPECT_EQ(session.count_answers(id), 0);

  display.release_key("Left");
  display.press_key("Right");  // answers, and stays down
  session.wait_for_trial(trials[1]);
  ASSERT_FALSE(HasFatalFailure());
  session.answer_by_key(Side::kLeft);
  session.answer_by_click(Side::kLeft);
  EXPECT_TRUE(session.stays(trials[1]));
  EXPECT_EQ(session.count_answers(id), 1);

  display.release_key("Right");
  session.answer_by_key(Side::kLeft);
  session.wait_for_trial(trials[2]);
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_EQ(session.load_trials(id)[0].answer, Side::kRight);
  EXPECT_EQ(session.load_trials(id)[1].answer, Side::kLeft);
}

TEST_F(AppTest, WhileAPairWaitsForItsAnswerTheProgramSleeps) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  const std::int64_t id = session.wait_for_session(Experiment::kArtifact);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("space");
  const auto trials = session.load_trials(id);
  answer_all(session, trials, 0, 4);
  session.wait_for_trial(trials[4]);
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_TRUE(session.stays(trials[4]));  // the next pair has been loaded
  const double before_s = session.program().read_cpu_seconds();
  EXPECT_TRUE(session.stays(trials[4]));
  EXPECT_LT(session.program().read_cpu_seconds() - before_s, 0.2);  // of at least 0.9
}

TEST_F(AppTest, AHeldButtonAnswersOnceAndClicksBesideThePicturesDoNot) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "material"));
  const std::int64_t id = session.wait_for_session(Experiment::kMaterial);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  const auto trials = session.load_trials(id);
  display.type_key("space");
  session.wait_for_trial(trials[0]);
  ASSERT_FALSE(HasFatalFailure());
  display.click(640, 660);  // the gap between the two
  display.click(640, 360);  // the reference above
  display.move_pointer(700, 600);
  display.press_button(3);
  display.release_button(3);
  EXPECT_TRUE(session.stays(trials[0]));
  display.press_button();
  session.wait_for_trial(trials[1]);
  ASSERT_FALSE(HasFatalFailure());
  display.move_pointer(400, 600);
  EXPECT_TRUE(session.stays(trials[1]));
  EXPECT_EQ(session.count_answers(id), 1);
  EXPECT_EQ(session.load_trials(id)[0].answer, Side::kRight);
}

TEST_F(AppTest, AWindowTooSmallForTheLayoutIsRefusedWithBothSizes) {
  const StudyFolder folder = make_study(kPaperPlan);
  XDisplay display(640, 480);
  for (const bool windowed : {false, true}) {
    auto arguments = arguments_for(folder, "artifact");
    if (windowed) arguments.push_back("--windowed");
    WatchedSession session(display, folder, kPaperPlan, arguments);
    EXPECT_EQ(session.program().wait(), 1);
    EXPECT_THAT(session.program().read_output(), HasSubstr("1136 x 930"));
    EXPECT_THAT(session.program().read_output(), HasSubstr("640 x 480"));
  }
  EXPECT_FALSE(std::filesystem::exists(folder.responses()));
}

TEST_F(AppTest, AnUnknownMonitorIsRefusedWithTheNamesOfThoseThereAre) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  auto arguments = arguments_for(folder, "artifact");
  arguments.insert(arguments.end(), {"--monitor", "HDMI-9"});
  WatchedSession session(display, folder, kSmallPlan, arguments);
  EXPECT_EQ(session.program().wait(), 1);
  EXPECT_THAT(session.program().read_output(), HasSubstr("one of screen, got \"HDMI-9\""));
}

TEST_F(AppTest, APlainWindowOfTheLayoutsSizeStandsInTheMiddleOfTheScreen) {
  const StudyFolder folder = make_study(kPaperPlan);
  ScreenPlan plan = kPaperPlan;  // 1136 x 930 and a margin of 32 each way
  plan.border = {(1280 - 1200) / 2, (1024 - 994) / 2};
  auto arguments = arguments_for(folder, "material");
  arguments.push_back("--windowed");
  run_whole_session(folder, plan, Experiment::kMaterial, kSmallMaterialTrials, arguments);
  const ScreenRecord screen = TrialLog(folder.responses()).load_sessions().back().screen;
  EXPECT_EQ(screen.framebuffer_width, 1200);
  EXPECT_EQ(screen.framebuffer_height, 994);
}

// The comparison itself: one step in one channel of one pixel, of a picture and of the grey.
TEST_F(AppTest, AScreenWrongByOneStepInOnePixelIsNoticed) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  const std::int64_t id = session.wait_for_session(Experiment::kArtifact);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("space");
  const TrialRow trial = session.load_trials(id)[0];
  session.wait_for_trial(trial);
  ASSERT_FALSE(HasFatalFailure());
  const LdrImage right = display.take_screenshot();
  ASSERT_FALSE(find_difference(right, folder, trial, kSmallPlan).has_value());
  for (const auto& [x, y] : {ScreenPlace{352, 557}, ScreenPlace{927, 766}, ScreenPlace{640, 600}}) {
    LdrImage wrong = right;
    wrong.values[(static_cast<std::size_t>(y) * 1280 + static_cast<std::size_t>(x)) * 3 + 2] ^= 1;
    EXPECT_TRUE(find_difference(wrong, folder, trial, kSmallPlan).has_value()) << x << ", " << y;
  }
  TrialRow swapped = trial;
  std::swap(swapped.test_key, swapped.pair_key);
  EXPECT_TRUE(find_difference(right, folder, swapped, kSmallPlan).has_value());
}

TEST_F(AppTest, AfterAKillTheSamePairIsShownAgainAndNoAnswerIsLost) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  std::int64_t id = 0;
  std::vector<TrialRow> trials;
  {
    WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
    id = session.wait_for_session(Experiment::kArtifact);
    session.wait_for_page("");
    ASSERT_FALSE(HasFatalFailure());
    trials = session.load_trials(id);
    display.type_key("space");
    answer_all(session, trials, 0, 3);
    session.wait_for_trial(trials[3]);
    ASSERT_FALSE(HasFatalFailure());
    EXPECT_EQ(count_showings(folder, id, 3), 1);
    session.program().send_signal(SIGKILL);
    EXPECT_EQ(session.program().wait(), 128 + SIGKILL);
  }
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  session.wait_for_page("resumed-instructions");
  ASSERT_FALSE(HasFatalFailure());
  expect_answered(session.load_trials(id), 0, 3);
  EXPECT_EQ(session.count_answers(id), 3);
  display.type_key("space");
  session.wait_for_trial(trials[3]);
  EXPECT_EQ(count_showings(folder, id, 3), 2);
  answer_all(session, trials, 3, kSmallArtifactTrials);
  session.wait_for_page("");
  display.type_key("Return");
  EXPECT_EQ(session.program().wait(), 0);
  expect_answered(session.load_trials(id), 0, kSmallArtifactTrials);
  EXPECT_EQ(TrialLog(folder.responses()).load_sessions().size(), 1U);
}

TEST_F(AppTest, EscapePausesOnlyWhenItIsHeldAndAnEndedSessionCanGoOn) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  std::vector<TrialRow> trials;
  std::int64_t id = 0;
  {
    WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
    id = session.wait_for_session(Experiment::kArtifact);
    session.wait_for_page("");
    ASSERT_FALSE(HasFatalFailure());
    trials = session.load_trials(id);
    display.type_key("space");
    answer_all(session, trials, 0, 1);
    session.wait_for_trial(trials[1]);
    ASSERT_FALSE(HasFatalFailure());
    display.type_key("Escape");
    EXPECT_TRUE(session.stays(trials[1]));
    display.press_key("Escape");
    session.wait_for_page("paused");
    ASSERT_FALSE(HasFatalFailure());
    display.release_key("Escape");
    display.type_key("F1");
    session.wait_for_trial(trials[1]);  // the same pair again
    ASSERT_FALSE(HasFatalFailure());
    EXPECT_EQ(count_showings(folder, id, 1), 2);
    display.press_key("Escape");
    session.wait_for_page("");
    ASSERT_FALSE(HasFatalFailure());
    display.release_key("Escape");
    display.type_key("F2");
    session.wait_for_page("ended-early");
    ASSERT_FALSE(HasFatalFailure());
    display.type_key("Return");
    EXPECT_EQ(session.program().wait(), 0);
    EXPECT_THAT(session.program().read_output(), HasSubstr("1 of 8 answers"));
    EXPECT_EQ(load_details(folder, "abort"), "ended by the experimenter");
  }
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("space");
  session.wait_for_trial(trials[1]);
  ASSERT_FALSE(HasFatalFailure());
  display.close_windows();
  EXPECT_EQ(session.program().wait(), 0);
  EXPECT_THAT(session.program().read_output(), HasSubstr("was interrupted: the window was closed; the same"));
  EXPECT_EQ(load_details(folder, "abort"), "ended by the experimenter") << "closing ends no session";
  EXPECT_EQ(load_details(folder, "interrupt"), "the window was closed");
  EXPECT_EQ(session.count_answers(id), 1);
}

TEST_F(AppTest, EscapeHeldLeavesTheStartScreenAndTheSetUpAndNothingIsRecorded) {
  const StudyFolder folder = make_study(kSmallPlan);
  auto to_setup = arguments_for(folder, "artifact");
  to_setup.push_back("--setup");
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{}, to_setup}) {
    XDisplay display;
    WatchedSession session(display, folder, kSmallPlan, arguments);
    if (arguments.empty()) session.wait_for_page("");
    if (!arguments.empty()) session.wait_for_error("");  // that the picture is small
    ASSERT_FALSE(HasFatalFailure());
    display.press_key("Escape");
    EXPECT_EQ(session.program().wait(), 0);
    EXPECT_FALSE(std::filesystem::exists(folder.responses()));
  }
}

TEST_F(AppTest, WhenTheLogCannotBeWrittenTheSessionStopsAndNothingMoreIsShown) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  const std::int64_t id = session.wait_for_session(Experiment::kArtifact);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  const auto trials = session.load_trials(id);
  display.type_key("space");
  answer_all(session, trials, 0, 2);
  session.wait_for_trial(trials[2]);
  ASSERT_FALSE(HasFatalFailure());
  session.program().limit_file_size(0);
  session.answer_by_key(Side::kLeft);
  session.wait_for_page("stopped");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Return");
  EXPECT_EQ(session.program().wait(), 1);
  EXPECT_THAT(session.program().read_output(), HasSubstr("responses.sqlite"));
  EXPECT_EQ(session.count_answers(id), 2);
}

TEST_F(AppTest, APictureThatWasChangedIsNotShown) {
  const StudyFolder folder = make_study(kSmallPlan);
  std::ofstream(folder.picture_folder() / "G0-MS-ind-ref-v0.png", std::ios::app) << 'x';
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  EXPECT_EQ(session.program().wait(), 1);
  EXPECT_THAT(session.program().read_output(), HasSubstr("G0-MS-ind-ref-v0.png: expected the digest"));
  EXPECT_FALSE(std::filesystem::exists(folder.responses())) << "a log would lock the folder's pictures";
}

// The pair after the next is read while one is looked at. Which picture it was the log and the terminal tell.
TEST_F(AppTest, APictureThatChangesMeanwhileInterruptsTheSessionWhichGoesOnWhenItIsMended) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  std::int64_t id = 0;
  std::string key;
  {
    WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
    id = session.wait_for_session(Experiment::kArtifact);
    session.wait_for_page("");
    ASSERT_FALSE(HasFatalFailure());
    const auto trials = session.load_trials(id);
    key = trials[2].test_key;
    const auto path = folder.picture_folder() / (key + ".png");
    const std::string kept = load_text(path);
    std::ofstream(path, std::ios::app) << 'x';
    display.type_key("space");
    session.wait_for_trial(trials[0]);
    ASSERT_FALSE(HasFatalFailure());
    session.answer_by_key(Side::kLeft);
    session.wait_for_page("stopped-by-picture");
    ASSERT_FALSE(HasFatalFailure());
    display.type_key("Return");
    EXPECT_EQ(session.program().wait(), 1);
    EXPECT_THAT(session.program().read_output(), HasSubstr(key));
    EXPECT_THAT(load_details(folder, "interrupt"), HasSubstr(key));
    save_text(path, kept);
  }
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("space");
  session.wait_for_trial(session.load_trials(id)[1]);
}

TEST_F(AppTest, ACharacterThatTheFontLacksIsRefusedBeforeAnythingIsShown) {
  const StudyFolder folder = make_study(kSmallPlan);
  save_text(folder.session(), R"({"schema": "equilux-session", "schema_version": 1,
    "consent": {"version": "1", "text": ["It takes 20 minutes \u2212 5 \u20ac.", "\u540c\u610f"]}})");
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  EXPECT_EQ(session.program().wait(), 1);
  EXPECT_THAT(session.program().read_output(), HasSubstr("session.json: /consent/text/1"));
  EXPECT_THAT(session.program().read_output(), HasSubstr("got U+540C"));
  EXPECT_FALSE(std::filesystem::exists(folder.responses()));
}

TEST_F(AppTest, ADistanceThatIsNoNumberIsNotTakenForTheStudys) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  auto arguments = arguments_for(folder, "artifact");
  arguments.push_back("--setup");
  WatchedSession session(display, folder, kSmallPlan, arguments);
  session.wait_for_error("setup-empty");  // which says that this screen's size is not known
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Tab");
  display.type_key("Tab");
  display.type_text("60cm");
  display.type_key("Return");
  session.wait_for_error("setup-no-number");
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_FALSE(std::filesystem::exists(folder.responses()));
  display.type_text("61.5");  // the keyboard is in the field that is wrong
  display.type_key("Return");
  ASSERT_NE(session.wait_for_session(Experiment::kArtifact), 0);
  const SessionRow row = TrialLog(folder.responses()).load_sessions().back();
  EXPECT_DOUBLE_EQ(row.screen.viewing_distance_m.value_or(0), 0.615);
  EXPECT_EQ(row.fields.at("viewing_distance_source"), "typed");
}

}  // namespace
}  // namespace equilux
