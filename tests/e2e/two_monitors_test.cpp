// Sessions where there are two monitors: on the one that was chosen, by name or on the set-up screen,
// whatever happens to the other.
#include "tests/e2e/two_monitors.h"

#include <filesystem>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <optional>
#include <sstream>

#include "tests/e2e/app_fixture.h"
#include "tests/experiment/raw_database.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// In the middle of 1024 x 768.
constexpr ScreenPlan kFirstPlan{280, 210, {224, 429}, {520, 429}, {372, 129}, 339, 429, {}};

class TwoMonitorsTest : public AppTest {
 protected:
  TwoMonitorsTest() { display_.connect(); }

  static std::vector<std::string> with(std::vector<std::string> arguments,
                                       const std::vector<std::string>& more) {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  // Kinds and details of what happened to the screen, in order.
  static std::vector<std::string> load_changes(const StudyFolder& folder) {
    std::vector<std::string> changes;
    for (const auto& row :
         RawDatabase(folder.responses())
             .query("SELECT kind || ' ' || detail FROM event WHERE kind IN ('resized', 'pause', 'continue', "
                    "'monitor_disconnected', 'monitor_connected', 'interrupt') ORDER BY time_ns, id")) {
      changes.push_back(row[0]);
    }
    return changes;
  }
  static void wait_for_change(const StudyFolder& folder, const std::string& change) {
    ASSERT_TRUE(wait_until([&] {
      const auto changes = load_changes(folder);
      return std::find(changes.begin(), changes.end(), change) != changes.end();
    })) << testing::PrintToString(load_changes(folder));
  }
  // From the instructions, which are on the screen, to this pair.
  std::vector<TrialRow> go_to_trial(WatchedSession& session, int number) {
    const std::int64_t id = session.wait_for_session(Experiment::kArtifact);
    session.wait_for_page("two-instructions");
    if (HasFatalFailure()) return {};
    const auto trials = session.load_trials(id);
    display_.type_key("space");
    answer_all(session, trials, 0, number);
    if (HasFatalFailure()) return {};
    session.wait_for_trial(trials[static_cast<std::size_t>(number)], "two-trial");
    return trials;
  }
  // An artifact session of P01, on the monitor that is looked at.
  WatchedSession& start(const StudyFolder& folder, const ScreenPlan& plan,
                        const std::vector<std::string>& more) {
    session_.reset();
    return session_.emplace(display_, folder, plan, with(arguments_for(folder, "artifact"), more));
  }
  WatchedSession& start_on_second(const StudyFolder& folder, const ScreenPlan& plan = kSmallPlan,
                                  const std::vector<std::string>& more = {}) {
    display_.look_at_monitor(kSecondMonitor);
    return start(folder, plan, with({"--monitor", "DUMMY1"}, more));
  }
  static ScreenRecord load_screen(const StudyFolder& folder) {
    return TrialLog(folder.responses()).load_sessions().back().screen;
  }

  TwoMonitors display_{folder_.path()};
  std::optional<WatchedSession> session_;
};

TEST_F(TwoMonitorsTest, ASessionFillsTheMonitorOfThatName) {
  const StudyFolder folder = make_study(kSmallPlan);
  const LdrImage first = display_.take_screenshot();
  WatchedSession& session = start_on_second(folder);
  go_to_trial(session, 1);
  ASSERT_FALSE(HasFatalFailure());
  const ScreenRecord screen = load_screen(folder);
  EXPECT_EQ(screen.monitor, "DUMMY1");
  EXPECT_EQ(screen.framebuffer_width, 1280);
  EXPECT_EQ(screen.framebuffer_height, 1024);
  display_.look_at_monitor(kFirstMonitor);
  EXPECT_TRUE(display_.take_screenshot() == first) << "the other monitor shows what it did";
}

TEST_F(TwoMonitorsTest, ANameThatNoMonitorHasIsRefusedWithThoseThereAre) {
  const StudyFolder folder = make_study(kSmallPlan);
  WatchedSession& session = start(folder, kSmallPlan, {"--monitor", "DUMMY7"});
  EXPECT_EQ(session.program().wait(), 1);
  EXPECT_THAT(session.program().read_output(), AllOf(HasSubstr("DUMMY0, DUMMY1"), HasSubstr("DUMMY7")));
}

// What was measured on the first monitor is not believed of the second.
TEST_F(TwoMonitorsTest, TheSetUpScreenMovesEverythingToTheNextMonitor) {
  const StudyFolder folder = make_study(kSmallPlan);
  WatchedSession& session = start(folder, kSmallPlan, {"--setup", "--diagonal", "13"});
  session.wait_for_page("two-setup-first");
  ASSERT_FALSE(HasFatalFailure());
  display_.look_at_monitor(kSecondMonitor);
  display_.type_key("F5");
  display_.type_key("Return");  // for the page as it was
  session.wait_for_error("two-setup-second");
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_FALSE(session.has_changed());
  EXPECT_FALSE(std::filesystem::exists(folder.responses()));
  display_.type_key("Return");
  go_to_trial(session, 1);
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_EQ(load_screen(folder).monitor, "DUMMY1");
  EXPECT_EQ(load_screen(folder).framebuffer_width, 1280);
  const auto fields = RawDatabase(folder.responses())
                          .query(
                              "SELECT name || ' ' || value FROM field WHERE name IN "
                              "('pixel_pitch_source', 'video_mode') ORDER BY name");
  ASSERT_EQ(fields.size(), 2u);
  EXPECT_NE(fields[0][0], "pixel_pitch_source diagonal");
  EXPECT_EQ(fields[1][0], "video_mode 1280x1024");
  EXPECT_THAT(load_changes(folder), IsEmpty());
}

TEST_F(TwoMonitorsTest, AMonitorThatIsTooSmallIsNotMovedTo) {
  const StudyFolder folder = make_study(kPaperPlan);
  WatchedSession& session = start_on_second(folder, kPaperPlan, {"--setup"});
  session.wait_for_error("");
  ASSERT_FALSE(HasFatalFailure());
  display_.type_key("F5");
  session.wait_for_error("two-setup-too-small");
  ASSERT_FALSE(HasFatalFailure());
  display_.type_key("F5");  // round to the one that is used
  display_.type_key("Return");
  go_to_trial(session, 1);
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_EQ(load_screen(folder).monitor, "DUMMY1");
}

// As by a calibration or a night mode, on this monitor alone.
TEST_F(TwoMonitorsTest, AChangedGammaRampIsToldAndKeptWithItsCurve) {
  const StudyFolder folder = make_study(kSmallPlan);
  display_.set_gamma(kSecondMonitor, "1:1:0.5");
  WatchedSession& session = start_on_second(folder);
  go_to_trial(session, 1);
  ASSERT_FALSE(HasFatalFailure());
  const auto fields =
      RawDatabase(folder.responses())
          .query("SELECT value FROM field WHERE name IN ('gamma_curve', 'gamma_ramp') ORDER BY name");
  ASSERT_EQ(fields.size(), 2u);
  EXPECT_EQ(fields[1][0], "changed");
  std::vector<std::string> middles;
  std::istringstream curve(fields[0][0]);
  for (std::string channel; std::getline(curve, channel, ';');) {
    std::istringstream values(channel);
    for (int i = 0; i < 4; ++i) values >> channel;
    middles.push_back((values >> channel, channel));
  }
  EXPECT_THAT(middles, ElementsAre("0.502", "0.502", "0.252"));
}

// The experimenter's own, say: the subject's goes on, and where the desktop puts it elsewhere the pairs
// follow.
TEST_F(TwoMonitorsTest, TheOtherMonitorMayGoAndComeDuringASession) {
  const StudyFolder folder = make_study(kSmallPlan);
  WatchedSession& session = start_on_second(folder);
  const auto trials = go_to_trial(session, 1);
  ASSERT_FALSE(HasFatalFailure());
  display_.unplug(kFirstMonitor);
  wait_for_change(folder, "monitor_disconnected DUMMY0");
  ASSERT_FALSE(HasFatalFailure());
  PlacedMonitor alone = kSecondMonitor;
  alone.x = 0;
  display_.look_at_monitor(alone);
  session.wait_for_trial(trials[1], "two-alone");
  ASSERT_FALSE(HasFatalFailure());
  session.answer_by_click(choose_side(1));
  session.wait_for_trial(trials[2]);
  ASSERT_FALSE(HasFatalFailure());

  display_.plug_in(kFirstMonitor, kSecondMonitor);
  display_.look_at_monitor(kSecondMonitor);
  wait_for_change(folder, "monitor_connected DUMMY0");
  ASSERT_FALSE(HasFatalFailure());
  session.wait_for_trial(trials[2], "two-again");
  ASSERT_FALSE(HasFatalFailure());
  session.answer_by_click(choose_side(2));
  session.wait_for_trial(trials[3]);
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_THAT(load_changes(folder), ElementsAre("monitor_disconnected DUMMY0", "monitor_connected DUMMY0"));
}

TEST_F(TwoMonitorsTest, TheMonitorOfASessionMayGoAndComeBack) {
  const StudyFolder folder = make_study(kSmallPlan);
  WatchedSession& session = start_on_second(folder);
  const auto trials = go_to_trial(session, 2);
  ASSERT_FALSE(HasFatalFailure());
  display_.unplug(kSecondMonitor);
  wait_for_change(folder, "pause ");
  ASSERT_FALSE(HasFatalFailure());
  session.answer_by_key(Side::kLeft);
  display_.plug_in(kFirstMonitor, kSecondMonitor);
  wait_for_change(folder, "monitor_connected DUMMY1");
  ASSERT_FALSE(HasFatalFailure());
  session.wait_for_page("two-back");
  ASSERT_FALSE(HasFatalFailure());
  display_.type_key("F1");
  session.wait_for_trial(trials[2]);
  ASSERT_FALSE(HasFatalFailure());
  EXPECT_EQ(session.count_answers(1), 2);
}

// Laid out on the smaller one, where it is the only one that is left.
TEST_F(TwoMonitorsTest, ASessionMayGoOnWithTheOtherMonitorInASittingOfItsOwn) {
  const StudyFolder folder = make_study(kSmallPlan);
  WatchedSession& first = start_on_second(folder);
  go_to_trial(first, 1);
  ASSERT_FALSE(HasFatalFailure());
  display_.unplug(kSecondMonitor);
  wait_for_change(folder, "pause ");
  ASSERT_FALSE(HasFatalFailure());
  display_.close_windows();
  EXPECT_EQ(first.program().wait(), 0);
  display_.look_at_monitor(kFirstMonitor);
  WatchedSession& session = start(folder, kFirstPlan, {});
  session.wait_for_page("");
  ASSERT_FALSE(HasFatalFailure());
  display_.type_key("space");
  session.wait_for_trial(session.load_trials(1)[1]);
}

}  // namespace
}  // namespace equilux
