// Polling the screen and the log until they are as they should be.
#include "tests/e2e/watched_session.h"

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <thread>
#include <utility>

#include "base/error.h"
#include "stimuli/png_file.h"
#include "tests/e2e/small_study.h"
#include "tests/experiment/raw_database.h"

namespace equilux {
namespace {

constexpr std::uint8_t kGrey = 128;
constexpr std::uint8_t kPanelGrey = 232;
// A page takes no press for .3 s, the consent text for 1 s.
constexpr std::chrono::milliseconds kPageGuard{550}, kConsentGuard{1300};
constexpr std::chrono::milliseconds kLongHold{900};  ///< longer than the key repeat of the X server, 660 ms

std::vector<std::string> command_line(const std::vector<std::string>& arguments) {
  std::vector<std::string> line{std::string(EQUILUX_BIN_DIR) + "/equilux-session", "run"};
  line.insert(line.end(), arguments.begin(), arguments.end());
  return line;
}

std::map<std::string, std::string> show_on(const XDisplay& display,
                                           std::map<std::string, std::string> environment) {
  environment["DISPLAY"] = display.name();
  environment["LIBGL_ALWAYS_SOFTWARE"] = "1";
  return environment;
}

const std::uint8_t* pixel_of(const LdrImage& image, int x, int y) {
  return image.values.data() +
         (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x)) *
             3;
}

std::uint8_t* pixel_of(LdrImage& image, int x, int y) {
  return const_cast<std::uint8_t*>(pixel_of(std::as_const(image), x, y));
}

std::string describe_pixel(const std::uint8_t* pixel) {
  return fmt::format("({}, {}, {})", pixel[0], pixel[1], pixel[2]);
}

bool is_grey(const std::uint8_t* pixel) {
  return pixel[0] == kGrey && pixel[1] == kGrey && pixel[2] == kGrey;
}

// What a trial must look like, but for the question.
LdrImage paint_trial(const LdrImage& screen, const StudyFolder& folder, const TrialRow& trial,
                     const ScreenPlan& plan) {
  LdrImage wanted(screen.width, screen.height);
  for (int y = plan.border.y; y < screen.height - plan.border.y; ++y) {
    std::fill_n(pixel_of(wanted, plan.border.x, y),
                static_cast<std::size_t>(screen.width - 2 * plan.border.x) * 3, kGrey);
  }
  const auto paint = [&](const std::string& key, ScreenPlace place) {
    const LdrImage picture = load_small_picture(folder, key);
    for (int y = 0; y < picture.height; ++y) {
      std::copy_n(pixel_of(picture, 0, y), static_cast<std::size_t>(picture.width) * 3,
                  pixel_of(wanted, place.x, place.y + y));
    }
  };
  const bool test_left = trial.test_side == Side::kLeft;
  paint(test_left ? trial.test_key : trial.pair_key, plan.left);
  paint(test_left ? trial.pair_key : trial.test_key, plan.right);
  if (!trial.upper_key.empty()) paint(trial.upper_key, plan.upper);
  return wanted;
}

bool has_question(const LdrImage& screen, const ScreenPlan& plan) {
  for (int y = plan.question_top; y < plan.question_bottom; ++y) {
    for (int x = plan.border.x; x < screen.width - plan.border.x; ++x) {
      if (!is_grey(pixel_of(screen, x, y))) return true;
    }
  }
  return false;
}

// Grey at its edges, with something black on it.
bool is_page(const LdrImage& screen) {
  constexpr int kEdge = 24;
  const int middle_x = screen.width / 2;
  if (!is_grey(pixel_of(screen, middle_x, kEdge)) ||
      !is_grey(pixel_of(screen, middle_x, screen.height - kEdge))) {
    return false;
  }
  return std::any_of(screen.values.begin(), screen.values.end(),
                     [](std::uint8_t value) { return value < 8; });
}

// The pale ground on which errors are written.
bool has_panel(const LdrImage& screen) {
  return is_page(screen) && std::count(screen.values.begin(), screen.values.end(), kPanelGrey) > 30000;
}

// Its id; 0 before there is a log.
std::string find_last_event(const StudyFolder& folder) {
  if (!std::filesystem::exists(folder.responses())) return "0";
  return RawDatabase(folder.responses()).value("SELECT coalesce(max(id), 0) FROM event");
}

}  // namespace

std::optional<std::string> find_difference(const LdrImage& screen, const StudyFolder& folder,
                                           const TrialRow& trial, const ScreenPlan& plan) {
  const LdrImage wanted = paint_trial(screen, folder, trial, plan);
  for (int y = 0; y < screen.height; ++y) {
    if (y >= plan.question_top && y < plan.question_bottom) continue;
    for (int x = 0; x < screen.width; ++x) {
      const std::uint8_t* got = pixel_of(screen, x, y);
      const std::uint8_t* expected = pixel_of(wanted, x, y);
      if (!std::equal(got, got + 3, expected)) {
        return fmt::format("trial {}: at ({}, {}) expected {}, got {}", trial.number, x, y,
                           describe_pixel(expected), describe_pixel(got));
      }
    }
  }
  if (!has_question(screen, plan)) return "no question";
  return std::nullopt;
}

WatchedSession::WatchedSession(XDisplay& display, const StudyFolder& folder, const ScreenPlan& plan,
                               const std::vector<std::string>& arguments,
                               const std::map<std::string, std::string>& environment)
    : display_(&display),
      folder_(folder),
      plan_(plan),
      last_event_before_(find_last_event(folder)),
      program_(command_line(arguments), show_on(display, environment)) {}

void WatchedSession::keep(const std::string& name) const {
  const char* folder = std::getenv("EQUILUX_SCREENSHOTS");
  if (!folder || name.empty()) return;
  save_png(display_->take_screenshot(), std::filesystem::path(folder) / (name + ".png"));
}

// A page is there when it is another than the last screen and has stopped changing.
void WatchedSession::wait_for(const std::string& name,
                              const std::function<bool(const LdrImage&)>& is_wanted) {
  LdrImage before;
  const bool is_there = wait_until([&] {
    LdrImage screen = display_->take_screenshot();
    const bool is_new = is_wanted(screen) && (!last_screen_ || screen != *last_screen_);
    const bool is_still = screen == before;
    before = std::move(screen);
    return (is_new && is_still) || !program_.is_running();
  });
  if (!is_there) keep("instead-of-" + name);
  ASSERT_TRUE(is_there && program_.is_running()) << name << " did not come: " << program_.read_output();
  last_screen_ = before;
  keep(name);
}

bool WatchedSession::is_logged_as_shown(const TrialRow& trial) const {
  const RawDatabase log(folder_.responses());
  return log.value(fmt::format("SELECT count(*) FROM event WHERE kind = 'showing' AND trial = {} AND id > {}",
                               trial.number, last_event_before_)) != "0";
}

void WatchedSession::wait_for_page(const std::string& name) {
  wait_for(name, is_page);
  std::this_thread::sleep_for(kPageGuard);
}

void WatchedSession::wait_for_error(const std::string& name) {
  wait_for(name, has_panel);
  std::this_thread::sleep_for(kPageGuard);
}

void WatchedSession::wait_for_consent(const std::string& name) {
  wait_for(name, is_page);
  std::this_thread::sleep_for(kConsentGuard);
  last_screen_ = display_->take_screenshot();
}

void WatchedSession::wait_for_trial(const TrialRow& trial, const std::string& name) {
  std::optional<std::string> difference;
  const bool is_there = wait_until([&] {
    last_screen_ = display_->take_screenshot();
    difference = find_difference(*last_screen_, folder_, trial, plan_);
    return (!difference && is_logged_as_shown(trial)) || !program_.is_running();
  });
  keep(name);
  ASSERT_TRUE(is_there && !difference) << difference.value_or("") << program_.read_output();
}

std::int64_t WatchedSession::wait_for_session(Experiment experiment) {
  std::int64_t id = 0;
  wait_until([&] {
    if (!program_.is_running()) return true;
    try {
      for (const SessionRow& row : TrialLog(folder_.responses()).load_sessions()) {
        if (row.experiment == experiment) id = row.id;
      }
    } catch (const InputError&) {  // not there yet
    }
    return id != 0;
  });
  if (id == 0) keep("no-session");
  EXPECT_NE(id, 0) << program_.read_output();
  return id;
}

bool WatchedSession::is_showing(const TrialRow& trial) const {
  return !find_difference(display_->take_screenshot(), folder_, trial, plan_);
}

bool WatchedSession::stays(const TrialRow& trial) const {
  std::this_thread::sleep_for(kLongHold);
  return is_showing(trial);
}

bool WatchedSession::has_changed() const {
  std::this_thread::sleep_for(kLongHold);
  return display_->take_screenshot() != last_screen_;
}

bool WatchedSession::stays_away(const TrialRow& trial) const {
  std::this_thread::sleep_for(kLongHold);
  return !is_showing(trial);
}

void WatchedSession::answer_by_key(Side side) { display_->type_key(side == Side::kLeft ? "Left" : "Right"); }

void WatchedSession::answer_by_click(Side side) {
  const ScreenPlace place = side == Side::kLeft ? plan_.left : plan_.right;
  display_->click(place.x + plan_.picture_width / 2, place.y + plan_.picture_height / 2);
}

std::vector<TrialRow> WatchedSession::load_trials(std::int64_t session) const {
  return TrialLog(folder_.responses()).load_trials(session);
}

int WatchedSession::count_answers(std::int64_t session) const {
  const auto trials = load_trials(session);
  return static_cast<int>(std::count_if(trials.begin(), trials.end(),
                                        [](const TrialRow& trial) { return trial.answer.has_value(); }));
}

}  // namespace equilux
