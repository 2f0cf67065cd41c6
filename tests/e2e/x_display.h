// An X server of a test's own, with hands and eyes: input by XTEST, pictures from the server.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "stimuli/image.h"
#include "tests/e2e/child_process.h"

namespace equilux {

/// Xvfb on a free display, without a window manager.
class XDisplay {
 public:
  explicit XDisplay(int width = 1280, int height = 1024);
  /// Another server, which tells its display through descriptor 3.
  XDisplay(const std::vector<std::string>& server, int width, int height);
  ~XDisplay();

  /// As for DISPLAY.
  std::string name() const { return name_; }
  int width() const { return width_; }
  int height() const { return height_; }

  /// Keys by their X names: Left, space, Return, Escape.
  void press_key(const std::string& key);
  void release_key(const std::string& key);
  void type_key(const std::string& key);
  /// ASCII, on the keyboard that Xvfb has.
  void type_text(const std::string& text);

  /// What pictures are taken of from now on, and where points count from: a part of the desktop.
  void look_at(int x, int y, int width, int height);

  void move_pointer(int x, int y);
  void press_button(int button = 1);
  void release_button(int button = 1);
  void click(int x, int y);

  /// Asks every window to close, as the button of a window manager does.
  void close_windows();

  /// Makes every window that can be seen another size, as a window manager does.
  void resize_windows(int width, int height);

  /// The keyboard goes to no window, as while another program's is in front, and back to the one that had it.
  void take_focus();
  void give_focus_back();

  /// Takes the only monitor out of the desktop, as if it were unplugged, and puts it back; what is on the
  /// screen stays there.
  void unplug_monitor();
  void plug_in_monitor();

  LdrImage take_screenshot() const;

 private:
  struct Connection;
  class MonitorSwitch;
  int x_ = 0;
  int y_ = 0;
  int width_;
  int height_;
  std::string name_;
  std::unique_ptr<ChildProcess> server_;
  std::unique_ptr<Connection> connection_;
  std::unique_ptr<MonitorSwitch> monitor_;
  unsigned long focused_ = 0;  ///< the window whose focus was taken
};

}  // namespace equilux
