// The one file pair that knows GLFW: a monitor, a window with its GL context, and what the user did.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "experiment/app/input.h"
#include "experiment/app/monitor_watch.h"

struct GLFWmonitor;
struct GLFWwindow;

namespace equilux {

/// Now on the monotonic clock of all session times. units: ns
std::int64_t read_clock_ns();

/// The window system and the monitor chosen.
class Display {
 public:
  /// `monitor` is a name; empty: the primary one. errors: InputError without a display, or for a name that no
  /// monitor has, listing those there are.
  explicit Display(const std::string& monitor);
  ~Display();
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

  const std::string& monitor_name() const { return name_; }  ///< as it can be chosen by
  std::vector<std::string> list_monitor_names() const;       ///< of all that are connected now, the same way
  /// Another one from now on, which is looked for when something is asked of it.
  void choose(const std::string& name) { name_ = name; }

  // errors: InputError if it was unplugged
  Size size() const;         ///< of the current video mode; units: pixels
  Size reported_mm() const;  ///< as the system says; 0 where it does not know
  GLFWmonitor* monitor() const;

 private:
  std::string name_;
};

/// Something that happened to the window and is no input.
struct WindowChange {
  std::string kind;  ///< focus_lost, focus_gained, resized, monitor_connected, monitor_disconnected
  std::string detail;
  std::int64_t time_ns = 0;
};

/// A window with a GL 3.3 context, current on this thread: 8 bits a channel, no multisampling, no sRGB
/// conversion, no dithering.
class AppWindow {
 public:
  /// Fills the monitor in its current video mode. errors: InputError if the framebuffer got is another size.
  explicit AppWindow(const Display& display);
  /// A plain window of this size in the middle of the monitor, without border.
  AppWindow(const Display& display, Size size);
  ~AppWindow();
  AppWindow(const AppWindow&) = delete;
  AppWindow& operator=(const AppWindow&) = delete;

  /// Makes a plain window another size. errors: InputError if it does not become so.
  void resize(Size size);
  /// To the monitor that is chosen now: fills it, or stands in its middle in this size, as the window did
  /// before. errors: InputError if the framebuffer got is another size, or the window elsewhere.
  void move_to(const Display& display, Size plain);
  Size framebuffer() const;

  /// Ends the wait of the window that waits now. From any thread.
  static void wake();

  /// Waits for input for at most `seconds`, then collects it; 0 collects without waiting.
  void wait(double seconds);
  /// What was collected, in order; each once.
  std::vector<InputEvent> take_events();
  /// What happened to the window, in order; each once.
  std::vector<WindowChange> take_changes();
  /// True once after the window system lost part of the picture.
  bool take_damage();
  bool is_closing() const;
  /// As if the user had closed it.
  void close();

  /// The monitor on which the window was opened is gone; the window is on another one, if there is any. When
  /// it is back the window is put there again, as it was.
  bool has_lost_monitor() const { return !monitor_; }
  const std::string& monitor_name() const { return watch_.name(); }

  /// Fills the back buffer with the neutral grey, 128 of 255.
  void clear();
  /// Shows the back buffer; returns when that is done.
  void swap();

  GLFWwindow* handle() const { return window_; }

 private:
  struct Callbacks;
  void open(const Display& display, Size size, bool fills_monitor);
  void check_framebuffer(Size wanted);
  void check_place();
  bool stands_on_monitor() const;
  void leave_monitor();
  void return_to_monitor();
  void fill_monitor();
  void follow_monitor();
  InputEvent make_event(InputKind kind) const;

  GLFWwindow* window_ = nullptr;
  MonitorWatch watch_;
  GLFWmonitor* monitor_ = nullptr;   ///< null while it is gone
  GLFWmonitor* returned_ = nullptr;  ///< the same, back since the window was last looked at
  bool fills_monitor_ = false;
  bool is_displaced_ = false;          ///< its monitor has gone since the window was last looked at
  std::int64_t follows_until_ns_ = 0;  ///< a while after some monitor came or went
  HeldKeys keys_;
  std::vector<InputEvent> events_;
  std::vector<WindowChange> changes_;
  bool is_damaged_ = true;
  double pointer_x_ = 0;  ///< window coordinates
  double pointer_y_ = 0;
};

}  // namespace equilux
