// equilux-session on a display of its own, watched through the X server and the log.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiment/trial_log.h"
#include "stimuli/study_folder.h"
#include "tests/e2e/child_process.h"
#include "tests/e2e/x_display.h"

namespace equilux {

/// Where a picture must stand. units: pixels of the screen
struct ScreenPlace {
  int x = 0;
  int y = 0;
};

/// Places for one size of picture, worked out by hand for the test's screen.
struct ScreenPlan {
  int picture_width = 0;
  int picture_height = 0;
  ScreenPlace left, right, upper;
  int question_top = 0;  ///< the text may be anywhere between these rows
  int question_bottom = 0;
  ScreenPlace border;  ///< black pixels on each side of a window that does not fill the screen
};

/// What differs from what a trial must look like, or nothing.
std::optional<std::string> find_difference(const LdrImage& screen, const StudyFolder& folder,
                                           const TrialRow& trial, const ScreenPlan& plan);

class WatchedSession {
 public:
  /// Starts `equilux-session run` with these arguments, and this added to its environment.
  WatchedSession(XDisplay& display, const StudyFolder& folder, const ScreenPlan& plan,
                 const std::vector<std::string>& arguments,
                 const std::map<std::string, std::string>& environment = {});

  ChildProcess& program() { return program_; }

  /// Each waits until its screen is there, with a test failure if it does not come; then a picture of it is
  /// kept as NAME.png if EQUILUX_SCREENSHOTS names a folder. A page is waited for until it takes presses.
  void wait_for_page(const std::string& name);
  /// A page with the panel of an error.
  void wait_for_error(const std::string& name);
  void wait_for_trial(const TrialRow& trial, const std::string& name = "");
  /// Waits until the log has a session of this experiment, and gives its id.
  std::int64_t wait_for_session(Experiment experiment);

  /// The consent text takes no press for longer than other pages.
  void wait_for_consent(const std::string& name);

  /// The screen as NAME.png, if EQUILUX_SCREENSHOTS names a folder.
  void keep(const std::string& name) const;

  bool is_showing(const TrialRow& trial) const;
  /// Lets the program do what it should not, for a while; true if the trial is still shown then.
  bool stays(const TrialRow& trial) const;
  /// Likewise; true if the screen is another page or looks otherwise then.
  bool has_changed() const;
  /// Likewise; true if it is not shown then.
  bool stays_away(const TrialRow& trial) const;

  void answer_by_key(Side side);
  void answer_by_click(Side side);

  std::vector<TrialRow> load_trials(std::int64_t session) const;
  int count_answers(std::int64_t session) const;

 private:
  void wait_for(const std::string& name, const std::function<bool(const LdrImage&)>& is_wanted);
  /// Whether the log has a showing of this trial by this program: presses before it do not count.
  bool is_logged_as_shown(const TrialRow& trial) const;

  XDisplay* display_;
  StudyFolder folder_;
  ScreenPlan plan_;
  std::string last_event_before_;  ///< id
  std::optional<LdrImage> last_screen_;
  ChildProcess program_;
};

}  // namespace equilux
