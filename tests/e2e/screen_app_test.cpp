// What happens to the screen of a session: another size of the window, frames that come late, larger letters.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>

#include "base/files.h"
#include "tests/e2e/app_fixture.h"
#include "tests/experiment/raw_database.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class ScreenAppTest : public AppTest {
 protected:
  // Kinds and details of the events of these kinds, in order.
  static std::vector<std::string> load_events(const StudyFolder& folder, const std::string& kinds) {
    std::vector<std::string> events;
    const auto rows = RawDatabase(folder.responses())
                          .query("SELECT kind || ' ' || detail FROM event WHERE kind IN (" + kinds +
                                 ") ORDER BY time_ns, id");
    for (const auto& row : rows) events.push_back(row[0]);
    return events;
  }
  static std::vector<std::string> load_changes(const StudyFolder& folder) {
    return load_events(folder, "'resized', 'pause', 'continue', 'abort', 'interrupt'");
  }
  static std::vector<std::string> load_monitor_events(const StudyFolder& folder) {
    return load_events(
        folder, "'monitor_disconnected', 'monitor_connected', 'pause', 'continue', 'abort', 'interrupt'");
  }
  static void wait_for_changes(const StudyFolder& folder, std::size_t count) {
    ASSERT_TRUE(wait_until([&] { return load_changes(folder).size() >= count; }))
        << testing::PrintToString(load_changes(folder));
  }
  static int count_showings(const StudyFolder& folder, int trial) {
    return std::stoi(
        RawDatabase(folder.responses())
            .value("SELECT count(*) FROM event WHERE kind = 'showing' AND trial = " + std::to_string(trial)));
  }
  // The environment of a program whose frames come late while that file stands there.
  static std::map<std::string, std::string> come_late(const std::filesystem::path& while_it_stands,
                                                      int late_ms) {
    return {{"LD_PRELOAD", EQUILUX_SLOW_SWAP},
            {"EQUILUX_SLOW_WHILE", while_it_stands.string()},
            {"EQUILUX_SLOW_MS", std::to_string(late_ms)},
            {"ASAN_OPTIONS", "detect_leaks=0:verify_asan_link_order=0"}};
  }
  // From the instructions to the pair before which `answered` were answered.
  static std::vector<TrialRow> go_to_trial(XDisplay& display, WatchedSession& session, Experiment experiment,
                                           int answered) {
    const std::int64_t id = session.wait_for_session(experiment);
    session.wait_for_page("");
    if (testing::Test::HasFatalFailure()) return {};
    const auto trials = session.load_trials(id);
    display.type_key("space");
    answer_all(session, trials, 0, answered);
    if (testing::Test::HasFatalFailure()) return {};
    session.wait_for_trial(trials[static_cast<std::size_t>(answered)]);
    return trials;
  }

  // From the pause that came while it was on the screen, to the end: it is shown again.
  static void go_on_from_third_pair(XDisplay& display, WatchedSession& session, const StudyFolder& folder,
                                    const std::vector<TrialRow>& trials) {
    display.type_key("F1");
    session.wait_for_trial(trials[2]);
    ASSERT_FALSE(HasFatalFailure());
    EXPECT_EQ(count_showings(folder, 2), 2);
    answer_all(session, trials, 2, kSmallArtifactTrials);
    session.wait_for_page("");
    ASSERT_FALSE(HasFatalFailure());
    display.type_key("Return");
    EXPECT_EQ(session.program().wait(), 0);
  }
};

// Too small for the pictures, then as large as it was.
TEST_F(ScreenAppTest, AWindowThatBecomesTooSmallPausesUntilItHasItsSizeAgain) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  const auto trials = go_to_trial(display, session, Experiment::kArtifact, 2);
  ASSERT_FALSE(HasFatalFailure());
  display.resize_windows(560, 400);
  wait_for_changes(folder, 2);
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("F1");
  session.answer_by_key(Side::kLeft);
  EXPECT_TRUE(session.stays_away(trials[2]));
  session.keep("resized-too-small");
  EXPECT_THAT(load_changes(folder), ElementsAre("resized 560 x 400", "pause "));
  EXPECT_TRUE(session.program().is_running()) << session.program().read_output();

  display.resize_windows(1280, 1024);
  session.wait_for_page("resized-back");
  ASSERT_FALSE(HasFatalFailure());
  go_on_from_third_pair(display, session, folder, trials);
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_THAT(session.program().read_output(), AllOf(HasSubstr("is complete"), HasSubstr("resized: 2")));
  EXPECT_THAT(load_changes(folder),
              ElementsAre("resized 560 x 400", "pause ", "resized 1280 x 1024", "continue "));
}

// Where there is room enough the pictures would be at another place than before, and the monitor's mode may
// be another, so that they are of another size: it waits just the same. It may go on as a new sitting.
TEST_F(ScreenAppTest, AWindowOfAnotherSizeGoesOnInASittingOfItsOwn) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display(1400, 1100);
  ScreenPlan plan = kSmallPlan;  // in the middle of the larger screen
  for (ScreenPlace* place : {&plan.left, &plan.right, &plan.upper}) {
    place->x += 60;
    place->y += 38;
  }
  plan.question_top += 38;
  plan.question_bottom += 38;
  {
    WatchedSession session(display, folder, plan, arguments_for(folder, "artifact"));
    go_to_trial(display, session, Experiment::kArtifact, 1);
    ASSERT_FALSE(HasFatalFailure());
    display.resize_windows(1404, 1104);
    session.wait_for_error("resized-larger");
    ASSERT_FALSE(HasFatalFailure());
    display.close_windows();
    EXPECT_EQ(session.program().wait(), 0);
    EXPECT_THAT(load_changes(folder),
                ElementsAre("resized 1404 x 1104", "pause ", "interrupt the window was closed"));
  }
  XDisplay other;
  WatchedSession session(other, folder, kSmallPlan, arguments_for(folder, "artifact"));
  const std::int64_t id = session.wait_for_session(Experiment::kArtifact);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  other.type_key("space");
  session.wait_for_trial(session.load_trials(id)[1]);
}

// What is pressed meanwhile answers nothing and goes on to nothing; afterwards the pair is shown again.
TEST_F(ScreenAppTest, AMonitorThatIsUnpluggedPausesUntilItIsBack) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  const auto trials = go_to_trial(display, session, Experiment::kArtifact, 2);
  ASSERT_FALSE(HasFatalFailure());
  display.unplug_monitor();
  session.wait_for_error("monitor-gone");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("F1");
  session.answer_by_key(Side::kLeft);
  session.answer_by_click(Side::kLeft);
  EXPECT_TRUE(session.stays_away(trials[2]));
  EXPECT_EQ(load_monitor_events(folder), std::vector<std::string>({"monitor_disconnected screen", "pause "}));
  EXPECT_TRUE(session.program().is_running()) << session.program().read_output();

  display.plug_in_monitor();
  session.wait_for_page("monitor-back");
  ASSERT_FALSE(HasFatalFailure());
  go_on_from_third_pair(display, session, folder, trials);
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_THAT(session.program().read_output(),
              AllOf(HasSubstr("is complete"), HasSubstr("monitor_disconnected: 1")));
  EXPECT_EQ(load_monitor_events(folder), std::vector<std::string>({"monitor_disconnected screen", "pause ",
                                                                   "monitor_connected screen", "continue "}));
}

// Unplugged while nothing of the session is on the screen yet: no pair comes, and the experimenter may end
// it.
TEST_F(ScreenAppTest, ASessionWhoseMonitorIsGoneCanBeEndedWithAReason) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  session.wait_for_session(Experiment::kArtifact);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.unplug_monitor();
  session.wait_for_error("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("space");
  display.click(640, 495);  // the reason
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_text("cable");
  display.type_key("F2");  // before the next frame: the reason is kept all the same
  session.wait_for_page("monitor-gone-ended");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Return");
  EXPECT_EQ(session.program().wait(), 0);
  EXPECT_EQ(load_monitor_events(folder),
            std::vector<std::string>({"monitor_disconnected screen", "pause ", "abort cable"}));
  EXPECT_EQ(count_showings(folder, 0), 0);
}

// On a page nothing is at a wrong place, but the next pair would be.
TEST_F(ScreenAppTest, AResizeOnThePageBeforeThePairsPausesToo) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  const std::int64_t id = session.wait_for_session(Experiment::kArtifact);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.resize_windows(1300, 1040);
  session.wait_for_error("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("space");
  display.resize_windows(1280, 1024);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("F1");
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_EQ(count_showings(folder, 0), 0);
  display.type_key("space");
  session.wait_for_trial(session.load_trials(id)[0]);
}

TEST_F(ScreenAppTest, APairThatComesLateIsNotedAndToldAtTheEnd) {
  const StudyFolder folder = make_study(kSmallPlan);
  const std::filesystem::path slow = folder_.path() / "slow";
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"),
                         come_late(slow, 120));
  const auto trials = go_to_trial(display, session, Experiment::kArtifact, 2);
  ASSERT_FALSE(HasFatalFailure());
  save_text(slow, "");
  session.answer_by_key(choose_side(2));
  session.wait_for_trial(trials[3]);
  ASSERT_FALSE(HasFatalFailure());
  std::filesystem::remove(slow);
  answer_all(session, trials, 3, kSmallArtifactTrials);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("F3");
  session.wait_for_page("slow-summary");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("Return");
  EXPECT_EQ(session.program().wait(), 0);
  const auto late = load_events(folder, "'slow_frame'");  // others too, where the machine is busy
  EXPECT_THAT(session.program().read_output(), HasSubstr(fmt::format("slow_frame: {}\n", late.size())));
  const auto find_ms = [](const std::string& event) {
    int trial = -1, ms = 0;
    EXPECT_EQ(std::sscanf(event.c_str(), "slow_frame trial %d: %d ms", &trial, &ms), 2) << event;
    return std::pair(trial, ms);
  };
  std::map<int, int> ms_by_trial;
  for (const std::string& event : late) ms_by_trial.insert(find_ms(event));
  EXPECT_GE(ms_by_trial[3], 120) << testing::PrintToString(late);
}

// Of a disk that spins up, or a folder of another machine: the files of the next pair are read while this one
// waits for its answer, which is timed when it is pressed.
TEST_F(ScreenAppTest, AnAnswerIsTimedWhenItIsPressedHoweverSlowlyTheNextPairIsRead) {
  constexpr int kReadMs = 2000;  // of a file
  const StudyFolder folder = make_study(kSmallPlan);
  const std::filesystem::path slow = folder_.path() / "slow";
  XDisplay display;
  auto environment = come_late(slow, kReadMs);
  environment["LD_PRELOAD"] = EQUILUX_SLOW_READ;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"), environment);
  const auto trials = go_to_trial(display, session, Experiment::kArtifact, 1);
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_TRUE(session.stays(trials[1]));  // the pair after it has been read
  save_text(slow, "");
  session.answer_by_key(choose_side(1));
  session.wait_for_trial(trials[2]);
  ASSERT_FALSE(HasFatalFailure());
  session.answer_by_key(choose_side(2));
  const std::int64_t pressed_ns = std::chrono::steady_clock::now().time_since_epoch().count();
  session.wait_for_trial(trials[3]);
  ASSERT_FALSE(HasFatalFailure());
  std::filesystem::remove(slow);
  const std::int64_t answered_ns = std::stoll(
      RawDatabase(folder.responses()).value("SELECT time_ns FROM event WHERE kind = 'answer' AND trial = 2"));
  EXPECT_LT(answered_ns - pressed_ns, kReadMs / 2 * 1'000'000LL);
  EXPECT_GT(std::chrono::steady_clock::now().time_since_epoch().count() - pressed_ns, kReadMs * 1'000'000LL)
      << "otherwise nothing was slow";
}

// A window of another program comes in front while an answer's key is down.
TEST_F(ScreenAppTest, AKeyThatIsHeldOverALossOfFocusAnswersOnce) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  const auto trials = go_to_trial(display, session, Experiment::kArtifact, 1);
  ASSERT_FALSE(HasFatalFailure());
  display.press_key("Right");  // answers, and stays down
  session.wait_for_trial(trials[2]);
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_TRUE(session.stays(trials[2]));  // the server repeats the key by now
  for (int times = 0; times < 3; ++times) {
    display.take_focus();
    display.give_focus_back();
    EXPECT_TRUE(session.stays(trials[2])) << times;
  }
  EXPECT_GE(load_events(folder, "'focus_lost'").size(), 3u);
  display.release_key("Right");
  session.answer_by_key(Side::kLeft);
  session.wait_for_trial(trials[3]);
}

// The page may stand until the experimenter comes, who copies the log first.
TEST_F(ScreenAppTest, TheLogIsWholeInItsFileWhileTheLastPageStands) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  const auto trials = go_to_trial(display, session, Experiment::kArtifact, 0);
  ASSERT_FALSE(HasFatalFailure());
  answer_all(session, trials, 0, kSmallArtifactTrials);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  const auto copy = folder_.path() / "copy.sqlite";
  std::filesystem::copy_file(folder.responses(), copy);
  const TrialLog log = TrialLog::load_snapshot(copy);
  ASSERT_EQ(log.load_sessions().size(), 1u);
  EXPECT_TRUE(log.load_sessions()[0].complete);
}

// A Tab's press and release are a frame apart, which must not look like a key that is held.
TEST_F(ScreenAppTest, AKeyThatIsStruckOnceWhereFramesAreSlowMovesByOne) {
  const StudyFolder folder = make_study(kSmallPlan);
  const std::filesystem::path slow = folder_.path() / "slow";
  auto arguments = arguments_for(folder, "artifact");
  arguments.push_back("--setup");
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments, come_late(slow, 350));
  session.wait_for_error("");
  ASSERT_FALSE(HasFatalFailure());
  save_text(slow, "");
  for (const char* key : {"Tab", "Tab", "6", "1", "Return"}) display.type_key(key);
  ASSERT_NE(session.wait_for_session(Experiment::kArtifact), 0);
  const ScreenRecord screen = TrialLog(folder.responses()).load_sessions().back().screen;
  EXPECT_DOUBLE_EQ(screen.viewing_distance_m.value_or(0), 0.61);
}

// Rows of the question's place on which something is written.
int count_written_rows(const LdrImage& screen, const ScreenPlan& plan) {
  int rows = 0;
  for (int y = plan.question_top; y < plan.question_bottom; ++y) {
    const auto* row =
        screen.values.data() + static_cast<std::size_t>(3 * y) * static_cast<std::size_t>(screen.width);
    rows += std::any_of(row, row + 3 * screen.width, [](std::uint8_t value) { return value < 40; }) ? 1 : 0;
  }
  return rows;
}

// Letters grow as far as there is room between the pictures, which stay where they are, to the pixel.
TEST_F(ScreenAppTest, ATextScaleEnlargesTheQuestionAndMovesNoPicture) {
  std::vector<int> rows;
  for (const std::string scale : {"0.5", "1", "2", "3"}) {
    const StudyFolder folder = make_small_study(folder_.path() / scale, 560, 420);
    XDisplay display;
    auto arguments = arguments_for(folder, "material");
    arguments.insert(arguments.end(), {"--text-scale", scale});
    WatchedSession session(display, folder, kPaperPlan, arguments);
    const std::int64_t id = session.wait_for_session(Experiment::kMaterial);
    session.wait_for_page("scale-" + scale + "-instructions");
    ASSERT_FALSE(HasFatalFailure());
    display.type_key("space");
    session.wait_for_trial(session.load_trials(id)[0], "scale-" + scale + "-trial");
    ASSERT_FALSE(HasFatalFailure());
    rows.push_back(count_written_rows(display.take_screenshot(), kPaperPlan));
    display.press_key("Escape");
    session.wait_for_page("scale-" + scale + "-pause");
    ASSERT_FALSE(HasFatalFailure());
    display.release_key("Escape");
  }
  EXPECT_LT(rows[0], rows[1]) << testing::PrintToString(rows);
  EXPECT_LT(rows[1], rows[2]) << testing::PrintToString(rows);
  EXPECT_LE(rows[2], rows[3]) << testing::PrintToString(rows);
  EXPECT_LE(rows[3], kPaperPlan.question_bottom - kPaperPlan.question_top);
}

// Where nothing is asked the session begins with the window, whose opening is no disturbance.
TEST_F(ScreenAppTest, TheFocusThatComesWithTheWindowIsNotNoted) {
  const StudyFolder folder = make_study(kSmallPlan);
  XDisplay display;
  WatchedSession session(display, folder, kSmallPlan, arguments_for(folder, "artifact"));
  const std::int64_t id = session.wait_for_session(Experiment::kArtifact);
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display.type_key("space");
  session.wait_for_trial(session.load_trials(id)[0]);
  ASSERT_FALSE(HasFatalFailure());
  for (const EventRow& event : TrialLog::load_snapshot(folder.responses()).load_events(id))
    EXPECT_THAT(event.kind, testing::AnyOf("showing", "slow_frame"));
}

// Black pixels of columns in which no line ends that is broken where it should be.
int count_cut_off(const LdrImage& screen, int from_x, int end_x) {
  int count = 0;
  for (int y = 0; y < screen.height * 8 / 10; ++y) {  // above the line that says there is more
    for (int x = from_x; x < end_x; ++x) {
      const auto* pixel =
          screen.values.data() + 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(screen.width) +
                                      static_cast<std::size_t>(x));
      count += pixel[0] < 40 ? 1 : 0;
    }
  }
  return count;
}

// The longest of the answers to this question fills more than a line.
TEST_F(ScreenAppTest, AnswersInLargeLettersAreBrokenAndNotCutOff) {
  const StudyFolder folder = make_study(kSmallPlan);
  save_text(folder.session(),
            R"({"schema": "equilux-session", "schema_version": 1, "questions": {"acuity": "required"}})");
  XDisplay display;
  auto arguments = arguments_for(folder, "artifact");
  arguments.insert(arguments.end(), {"--text-scale", "3"});
  WatchedSession session(display, folder, kSmallPlan, arguments);
  session.wait_for_page("large-questions");
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_EQ(count_cut_off(display.take_screenshot(), 1236, 1256), 0);
  for (const char* key : {"Down", "space", "Return"}) display.type_key(key);
  session.wait_for_session(Experiment::kArtifact);
  EXPECT_EQ(TrialLog(folder.responses()).load_sessions().back().fields.at("acuity"), "corrected");
}

}  // namespace
}  // namespace equilux
