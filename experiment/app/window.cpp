// GLFW, kept from doing anything on its own: no iconifying, no mode change, no scaling.
#include "experiment/app/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <chrono>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <utility>

#include "base/error.h"
#include "experiment/app/gl.h"
#include "experiment/app/monitor_names.h"

namespace equilux {
namespace {

constexpr double kResizePatienceS = 2;
constexpr std::int64_t kFollowNs = 10'000'000'000;
constexpr float kNeutralGrey = 128 / 255.0F;

std::string describe_glfw_error() {
  const char* description = nullptr;
  glfwGetError(&description);
  return description ? description : "no reason given";
}

std::vector<GLFWmonitor*> list_monitors() {
  int count = 0;
  GLFWmonitor** monitors = glfwGetMonitors(&count);
  return {monitors, monitors + count};
}

std::vector<std::string> label(const std::vector<GLFWmonitor*>& monitors) {
  std::vector<std::string> names;
  for (GLFWmonitor* monitor : monitors) names.emplace_back(glfwGetMonitorName(monitor));
  return label_monitors(names);
}

GLFWmonitor* find_monitor(const std::string& name) {
  const auto monitors = list_monitors();
  if (monitors.empty()) throw InputError("--monitor", "", "a monitor", "none connected");
  const auto labels = label(monitors);
  const auto found = std::find(labels.begin(), labels.end(), name);
  if (found != labels.end()) return monitors[static_cast<std::size_t>(found - labels.begin())];
  throw InputError("--monitor", "", fmt::format("one of {}", fmt::join(labels, ", ")), "\"" + name + "\"");
}

void set_hints(bool is_visible) {
  glfwDefaultWindowHints();
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
  glfwWindowHint(GLFW_SAMPLES, 0);
  glfwWindowHint(GLFW_SRGB_CAPABLE, GLFW_FALSE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  glfwWindowHint(GLFW_AUTO_ICONIFY, GLFW_FALSE);
  glfwWindowHint(GLFW_RESIZABLE, GLFW_FALSE);
  glfwWindowHint(GLFW_DECORATED, GLFW_FALSE);
  glfwWindowHint(GLFW_VISIBLE, is_visible ? GLFW_TRUE : GLFW_FALSE);
}

// The mode that the monitor is in, so that opening the window does not change it.
void hint_mode(const GLFWvidmode& mode) {
  glfwWindowHint(GLFW_RED_BITS, mode.redBits);
  glfwWindowHint(GLFW_GREEN_BITS, mode.greenBits);
  glfwWindowHint(GLFW_BLUE_BITS, mode.blueBits);
  glfwWindowHint(GLFW_REFRESH_RATE, mode.refreshRate > 0 ? mode.refreshRate : GLFW_DONT_CARE);
}

void centre(GLFWwindow* window, GLFWmonitor* monitor, Size size) {
  const GLFWvidmode* mode = glfwGetVideoMode(monitor);
  int x = 0;
  int y = 0;
  glfwGetMonitorPos(monitor, &x, &y);
  glfwSetWindowPos(window, x + (mode->width - size.width) / 2, y + (mode->height - size.height) / 2);
}

void check_colour_depth() {
  for (const GLenum channel : {GL_FRAMEBUFFER_ATTACHMENT_RED_SIZE, GL_FRAMEBUFFER_ATTACHMENT_GREEN_SIZE,
                               GL_FRAMEBUFFER_ATTACHMENT_BLUE_SIZE}) {
    GLint bits = 0;
    glGetFramebufferAttachmentParameteriv(GL_FRAMEBUFFER, GL_BACK_LEFT, channel, &bits);
    if (bits < 8) throw InputError("screen", "", "at least 8 bits a channel", fmt::format("{}", bits));
  }
}

Key name_key(int code) {
  switch (code) {
    case GLFW_KEY_LEFT:
      return Key::kLeft;
    case GLFW_KEY_RIGHT:
      return Key::kRight;
    case GLFW_KEY_SPACE:
      return Key::kSpace;
    case GLFW_KEY_ENTER:
    case GLFW_KEY_KP_ENTER:
      return Key::kEnter;
    case GLFW_KEY_ESCAPE:
      return Key::kEscape;
    case GLFW_KEY_F1:
      return Key::kF1;
    case GLFW_KEY_F2:
      return Key::kF2;
    case GLFW_KEY_F3:
      return Key::kF3;
    case GLFW_KEY_F4:
      return Key::kF4;
    case GLFW_KEY_F5:
      return Key::kF5;
    case GLFW_KEY_BACKSPACE:
      return Key::kBackspace;
    case GLFW_KEY_UP:
      return Key::kUp;
    case GLFW_KEY_DOWN:
      return Key::kDown;
    case GLFW_KEY_PAGE_UP:
      return Key::kPageUp;
    case GLFW_KEY_PAGE_DOWN:
      return Key::kPageDown;
    case GLFW_KEY_HOME:
      return Key::kHome;
    case GLFW_KEY_END:
      return Key::kEnd;
    default:
      return Key::kOther;
  }
}

InputKind name_key_action(int action) {
  if (action == GLFW_PRESS) return InputKind::kKeyPress;
  return action == GLFW_RELEASE ? InputKind::kKeyRelease : InputKind::kKeyRepeat;
}

}  // namespace

std::int64_t read_clock_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

Display::Display(const std::string& monitor) {
  if (!glfwInit()) throw InputError("display", "", "a screen to show pictures on", describe_glfw_error());
  try {
    const auto monitors = list_monitors();
    name_ = monitor.empty() && !monitors.empty() ? label(monitors).front() : monitor;
    find_monitor(name_);
  } catch (...) {
    glfwTerminate();
    throw;
  }
}

Display::~Display() { glfwTerminate(); }

std::vector<std::string> Display::list_monitor_names() const { return label(list_monitors()); }

// Of one that was unplugged the window system's is freed, and another made when it is back.
GLFWmonitor* Display::monitor() const { return find_monitor(name_); }

Size Display::size() const {
  const GLFWvidmode* mode = glfwGetVideoMode(monitor());
  return {mode->width, mode->height};
}

Size Display::reported_mm() const {
  Size size;
  glfwGetMonitorPhysicalSize(monitor(), &size.width, &size.height);
  return size;
}

// GLFW's calls from inside wait(), turned into events with a time.
struct AppWindow::Callbacks {
  static AppWindow& of(GLFWwindow* window) {
    return *static_cast<AppWindow*>(glfwGetWindowUserPointer(window));
  }

  static void key(GLFWwindow* window, int code, int scancode, int action, int modifiers) {
    InputEvent event = of(window).make_event(name_key_action(action));
    event.kind = of(window).keys_.read(event.kind, code, event.time_ns);
    event.key = name_key(code);
    event.code = code;
    event.scancode = scancode;
    event.modifiers = modifiers;
    of(window).events_.push_back(event);
  }
  static void button(GLFWwindow* window, int button, int action, int modifiers) {
    InputEvent event =
        of(window).make_event(action == GLFW_PRESS ? InputKind::kMousePress : InputKind::kMouseRelease);
    event.code = button;
    event.modifiers = modifiers;
    of(window).events_.push_back(event);
  }
  static void character(GLFWwindow* window, unsigned int code) {
    InputEvent event = of(window).make_event(InputKind::kCharacter);
    event.code = static_cast<int>(code);
    of(window).events_.push_back(event);
  }
  // A click belongs where the pointer was then, not where it is when the click is read.
  static void move(GLFWwindow* window, double x, double y) {
    of(window).pointer_x_ = x;
    of(window).pointer_y_ = y;
  }
  static void scroll(GLFWwindow* window, double x, double y) {
    InputEvent event = of(window).make_event(InputKind::kScroll);
    event.x = x;
    event.y = y;
    of(window).events_.push_back(event);
  }
  static void refresh(GLFWwindow* window) { of(window).is_damaged_ = true; }
  static void resize(GLFWwindow* window, int width, int height) {
    of(window).is_damaged_ = true;
    add_change(of(window), "resized", fmt::format("{} x {}", width, height));
  }
  static void focus(GLFWwindow* window, int focused) {
    add_change(of(window), focused ? "focus_gained" : "focus_lost", "");
    if (focused) {
      of(window).keys_.gain_focus(read_clock_ns());
    } else {
      of(window).keys_.lose_focus(read_clock_ns());
    }
  }
  // GLFW tells this to no window in particular.
  static void monitor(GLFWmonitor* monitor, int event) {
    if (!watching_) return;
    const std::string name = glfwGetMonitorName(monitor);
    const bool is_there = event == GLFW_CONNECTED;
    AppWindow& window = *watching_;
    add_change(window, is_there ? "monitor_connected" : "monitor_disconnected", name);
    window.follows_until_ns_ = read_clock_ns() + kFollowNs;
    if (is_there && window.watch_.connect(monitor, name)) window.returned_ = monitor;
    if (is_there || !window.watch_.disconnect(monitor)) return;
    window.monitor_ = window.returned_ = nullptr;
    window.is_displaced_ = true;
  }
  static void add_change(AppWindow& window, std::string kind, std::string detail) {
    window.changes_.push_back({std::move(kind), std::move(detail), read_clock_ns()});
  }
  inline static AppWindow* watching_ = nullptr;

  static void install(GLFWwindow* window) {
    glfwSetKeyCallback(window, key);
    glfwSetMouseButtonCallback(window, button);
    glfwSetCursorPosCallback(window, move);
    glfwSetCharCallback(window, character);
    glfwSetScrollCallback(window, scroll);
    glfwSetWindowRefreshCallback(window, refresh);
    glfwSetFramebufferSizeCallback(window, resize);
    glfwSetWindowFocusCallback(window, focus);
    glfwSetMonitorCallback(monitor);
    watching_ = &of(window);
  }
};

AppWindow::AppWindow(const Display& display) { open(display, display.size(), true); }

AppWindow::AppWindow(const Display& display, Size size) { open(display, size, false); }

AppWindow::~AppWindow() {
  if (Callbacks::watching_ == this) Callbacks::watching_ = nullptr;
  glfwDestroyWindow(window_);
}

void AppWindow::open(const Display& display, Size size, bool fills_monitor) {
  monitor_ = display.monitor();
  fills_monitor_ = fills_monitor;
  watch_.follow(monitor_, glfwGetMonitorName(monitor_));
  set_hints(fills_monitor);
  if (fills_monitor) hint_mode(*glfwGetVideoMode(monitor_));
  window_ = glfwCreateWindow(size.width, size.height, "Equilux", fills_monitor ? monitor_ : nullptr, nullptr);
  if (!window_) throw InputError("display", "", "a window with OpenGL 3.3", describe_glfw_error());
  try {
    glfwSetWindowUserPointer(window_, this);
    Callbacks::install(window_);
    glfwGetCursorPos(window_, &pointer_x_, &pointer_y_);
    if (!fills_monitor) centre(window_, monitor_, size);
    glfwShowWindow(window_);
    glfwFocusWindow(window_);
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
    check_framebuffer(size);
    check_colour_depth();
  } catch (...) {
    glfwDestroyWindow(window_);
    throw;
  }
}

void AppWindow::check_framebuffer(Size wanted) {
  const std::int64_t start_ns = read_clock_ns();
  while (framebuffer() != wanted &&
         static_cast<double>(read_clock_ns() - start_ns) < kResizePatienceS * 1e9) {
    glfwWaitEventsTimeout(0.02);
  }
  const Size got = framebuffer();
  if (got != wanted) {
    throw InputError("screen", "",
                     fmt::format("a framebuffer of {} x {} pixels", wanted.width, wanted.height),
                     fmt::format("{} x {}", got.width, got.height));
  }
}

// Two monitors may be of one size.
void AppWindow::check_place() {
  const std::int64_t start_ns = read_clock_ns();
  while (monitor_ && !stands_on_monitor() &&
         static_cast<double>(read_clock_ns() - start_ns) < kResizePatienceS * 1e9) {
    glfwWaitEventsTimeout(0.02);
  }
  if (monitor_ && stands_on_monitor()) return;
  throw InputError("screen", "", fmt::format("a window on monitor {}", watch_.name()),
                   monitor_ ? "one that stays elsewhere" : "none, since it was unplugged");
}

bool AppWindow::stands_on_monitor() const {
  int x = 0, y = 0, monitor_x = 0, monitor_y = 0;
  glfwGetWindowPos(window_, &x, &y);
  glfwGetMonitorPos(monitor_, &monitor_x, &monitor_y);
  return x == monitor_x && y == monitor_y;
}

void AppWindow::resize(Size size) {
  glfwSetWindowSize(window_, size.width, size.height);
  if (monitor_) centre(window_, monitor_, size);
  check_framebuffer(size);
}

void AppWindow::move_to(const Display& display, Size plain) {
  monitor_ = display.monitor();
  returned_ = nullptr;
  is_displaced_ = false;
  watch_.follow(monitor_, glfwGetMonitorName(monitor_));
  if (!fills_monitor_) return resize(plain);
  fill_monitor();
  check_framebuffer(display.size());
  check_place();
}

Size AppWindow::framebuffer() const {
  Size size;
  glfwGetFramebufferSize(window_, &size.width, &size.height);
  return size;
}

void AppWindow::wait(double seconds) {
  if (seconds > 0) {
    glfwWaitEventsTimeout(seconds);
  } else {
    glfwPollEvents();
  }
  leave_monitor();
  return_to_monitor();
  follow_monitor();
}

// GLFW 3.3 moves it by a frame of unknown size, which without a window manager is anywhere.
void AppWindow::leave_monitor() {
  if (!std::exchange(is_displaced_, false) || monitor_) return;
  int x = 0;
  int y = 0;
  if (GLFWmonitor* other = glfwGetPrimaryMonitor()) glfwGetMonitorPos(other, &x, &y);
  glfwSetWindowPos(window_, x, y);
  glfwFocusWindow(window_);
  is_damaged_ = true;
}

// Not from inside the window system's call. In the mode that it came back with: whether that does is for
// others to say.
void AppWindow::return_to_monitor() {
  if (!returned_) return;
  monitor_ = std::exchange(returned_, nullptr);
  if (fills_monitor_) return fill_monitor();
  centre(window_, monitor_, framebuffer());
  glfwFocusWindow(window_);
  is_damaged_ = true;
}

void AppWindow::fill_monitor() {
  const GLFWvidmode* mode = glfwGetVideoMode(monitor_);
  glfwSetWindowMonitor(window_, monitor_, 0, 0, mode->width, mode->height, mode->refreshRate);
  glfwFocusWindow(window_);
  is_damaged_ = true;
}

// Where another monitor came or went the desktop may put this one elsewhere, now or somewhat later, and tells
// nobody.
void AppWindow::follow_monitor() {
  if (!monitor_ || !fills_monitor_ || read_clock_ns() > follows_until_ns_ || stands_on_monitor()) return;
  fill_monitor();
}

void AppWindow::wake() { glfwPostEmptyEvent(); }

std::vector<InputEvent> AppWindow::take_events() { return std::exchange(events_, {}); }

std::vector<WindowChange> AppWindow::take_changes() { return std::exchange(changes_, {}); }

bool AppWindow::take_damage() { return std::exchange(is_damaged_, false); }

bool AppWindow::is_closing() const { return glfwWindowShouldClose(window_) != 0; }

void AppWindow::close() { glfwSetWindowShouldClose(window_, GLFW_TRUE); }

InputEvent AppWindow::make_event(InputKind kind) const {
  InputEvent event;
  event.kind = kind;
  event.time_ns = read_clock_ns();
  Size window;
  glfwGetWindowSize(window_, &window.width, &window.height);
  const Size pixels = framebuffer();
  event.x = pointer_x_ * pixels.width / std::max(1, window.width);
  event.y = pointer_y_ * pixels.height / std::max(1, window.height);
  return event;
}

void AppWindow::clear() {
  const Size size = framebuffer();
  glViewport(0, 0, size.width, size.height);
  glDisable(GL_FRAMEBUFFER_SRGB);
  glDisable(GL_DITHER);
  glDisable(GL_BLEND);
  glDisable(GL_SCISSOR_TEST);
  glClearColor(kNeutralGrey, kNeutralGrey, kNeutralGrey, 1);
  glClear(GL_COLOR_BUFFER_BIT);
}

// Waiting for the end of drawing makes the time after it the time of the onset, as near as software can tell.
void AppWindow::swap() {
  glfwSwapBuffers(window_);
  glFinish();
}

}  // namespace equilux
