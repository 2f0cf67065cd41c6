// The one file of the tests that knows Xlib.
#include "tests/e2e/x_display.h"

#include <X11/XKBlib.h>
#include <X11/Xlib.h>
#include <X11/Xutil.h>
#include <X11/extensions/XTest.h>
#include <X11/keysym.h>
#include <chrono>
#include <dlfcn.h>
#include <fmt/format.h>
#include <stdexcept>
#include <thread>
#include <vector>

namespace equilux {

struct XDisplay::Connection {
  explicit Connection(const std::string& name) : display(XOpenDisplay(name.c_str())) {
    if (!display) throw std::runtime_error("cannot open the display " + name);
  }
  ~Connection() { XCloseDisplay(display); }

  KeyCode code_of(KeySym symbol) const {
    const KeyCode code = XKeysymToKeycode(display, symbol);
    if (code == 0) throw std::runtime_error(fmt::format("no key for {:#x}", symbol));
    return code;
  }
  // GLFW takes a second press of a key in one and the same millisecond for an input method's copy of the
  // first.
  void send_key(KeyCode code, bool is_down) const {
    constexpr std::chrono::milliseconds kFastestPress{3};
    if (is_down) std::this_thread::sleep_for(kFastestPress);
    XTestFakeKeyEvent(display, code, is_down ? True : False, CurrentTime);
    XSync(display, False);
  }

  // Those at the top, of all programs.
  std::vector<::Window> list_windows() const {
    ::Window root = 0;
    ::Window parent = 0;
    ::Window* children = nullptr;
    unsigned count = 0;
    XQueryTree(display, DefaultRootWindow(display), &root, &parent, &children, &count);
    std::vector<::Window> windows;
    if (children) windows.assign(children, children + count);
    if (children) XFree(children);
    return windows;
  }

  ::Display* display;
};

// RandR's library, which GLFW loads at run time; without the package of its headers. A monitor is out of the
// desktop while its controller has no mode.
class XDisplay::MonitorSwitch {
 public:
  explicit MonitorSwitch(::Display* display)
      : display_(display), library_(::dlopen("libXrandr.so.2", RTLD_NOW)) {
    if (!library_) throw std::runtime_error("libXrandr.so.2 is missing");
    resources_ = load<Resources* (*)(::Display*, ::Window)>("XRRGetScreenResourcesCurrent")(
        display_, DefaultRootWindow(display_));
    if (!resources_ || resources_->controller_count != 1 || resources_->output_count != 1)
      throw std::runtime_error("a display with one monitor is expected");
    mode_ = load<Controller* (*)(::Display*, Resources*, XID)>("XRRGetCrtcInfo")(display_, resources_,
                                                                                 *resources_->controllers)
                ->mode;
  }

  void set(bool is_there) const {
    using Set = int (*)(::Display*, Resources*, XID, Time, int, int, XID, unsigned short, XID*, int);
    constexpr unsigned short kUpright = 1;
    const int status = load<Set>("XRRSetCrtcConfig")(
        display_, resources_, *resources_->controllers, CurrentTime, 0, 0, is_there ? mode_ : None, kUpright,
        is_there ? resources_->outputs : nullptr, is_there ? 1 : 0);
    if (status != 0) throw std::runtime_error(fmt::format("the monitor cannot be switched: {}", status));
    XSync(display_, False);
  }

 private:
  // As XRRScreenResources and XRRCrtcInfo begin. source: X11/extensions/Xrandr.h
  struct Resources {
    Time changed, configured;
    int controller_count;
    XID* controllers;
    int output_count;
    XID* outputs;
  };
  struct Controller {
    Time changed;
    int x, y;
    unsigned width, height;
    XID mode;
  };

  template <typename Function>
  Function load(const char* name) const {
    void* symbol = ::dlsym(library_, name);
    if (!symbol) throw std::runtime_error(fmt::format("libXrandr.so.2 has no {}", name));
    return reinterpret_cast<Function>(symbol);
  }

  ::Display* display_;
  void* library_;
  Resources* resources_ = nullptr;
  XID mode_ = None;
};

XDisplay::XDisplay(int width, int height)
    : XDisplay({"Xvfb", "-displayfd", "3", "-screen", "0", fmt::format("{}x{}x24", width, height), "-dpi",
                "96", "-nolisten", "tcp", "-noreset"},
               width, height) {}

XDisplay::XDisplay(const std::vector<std::string>& server, int width, int height)
    : width_(width), height_(height) {
  std::string number;
  server_ = std::make_unique<ChildProcess>(server, std::map<std::string, std::string>{}, &number);
  if (number.empty())
    throw std::runtime_error(fmt::format("{} did not start: {}", server.front(), server_->read_output()));
  name_ = ":" + number;
  connection_ = std::make_unique<Connection>(name_);
  move_pointer(2, 2);
}

XDisplay::~XDisplay() = default;

void XDisplay::press_key(const std::string& key) {
  connection_->send_key(connection_->code_of(XStringToKeysym(key.c_str())), true);
}

void XDisplay::release_key(const std::string& key) {
  connection_->send_key(connection_->code_of(XStringToKeysym(key.c_str())), false);
}

void XDisplay::type_key(const std::string& key) {
  press_key(key);
  release_key(key);
}

void XDisplay::type_text(const std::string& text) {
  for (const char character : text) {
    const auto symbol = static_cast<KeySym>(static_cast<unsigned char>(character));
    const KeyCode code = connection_->code_of(symbol);
    const bool is_shifted = XkbKeycodeToKeysym(connection_->display, code, 0, 0) != symbol;
    if (is_shifted) press_key("Shift_L");
    connection_->send_key(code, true);
    connection_->send_key(code, false);
    if (is_shifted) release_key("Shift_L");
  }
}

void XDisplay::look_at(int x, int y, int width, int height) {
  x_ = x;
  y_ = y;
  width_ = width;
  height_ = height;
}

void XDisplay::move_pointer(int x, int y) {
  XTestFakeMotionEvent(connection_->display, 0, x_ + x, y_ + y, CurrentTime);
  XSync(connection_->display, False);
}

void XDisplay::press_button(int button) {
  XTestFakeButtonEvent(connection_->display, static_cast<unsigned>(button), True, CurrentTime);
  XSync(connection_->display, False);
}

void XDisplay::release_button(int button) {
  XTestFakeButtonEvent(connection_->display, static_cast<unsigned>(button), False, CurrentTime);
  XSync(connection_->display, False);
}

void XDisplay::click(int x, int y) {
  move_pointer(x, y);
  press_button();
  release_button();
}

void XDisplay::close_windows() {
  ::Display* display = connection_->display;
  const Atom close = XInternAtom(display, "WM_DELETE_WINDOW", False);
  for (const ::Window window : connection_->list_windows()) {
    XEvent event{};
    event.xclient.type = ClientMessage;
    event.xclient.window = window;
    event.xclient.message_type = XInternAtom(display, "WM_PROTOCOLS", False);
    event.xclient.format = 32;
    event.xclient.data.l[0] = static_cast<long>(close);
    XSendEvent(display, window, False, NoEventMask, &event);
  }
  XSync(display, False);
}

void XDisplay::resize_windows(int width, int height) {
  ::Display* display = connection_->display;
  for (const ::Window window : connection_->list_windows()) {
    XWindowAttributes attributes{};
    XGetWindowAttributes(display, window, &attributes);
    if (attributes.map_state != IsViewable) continue;
    XResizeWindow(display, window, static_cast<unsigned>(width), static_cast<unsigned>(height));
  }
  XSync(display, False);
}

void XDisplay::take_focus() {
  int revert = 0;
  XGetInputFocus(connection_->display, &focused_, &revert);
  XSetInputFocus(connection_->display, DefaultRootWindow(connection_->display), RevertToNone, CurrentTime);
  XSync(connection_->display, False);
}

void XDisplay::give_focus_back() {
  XSetInputFocus(connection_->display, focused_, RevertToNone, CurrentTime);
  XSync(connection_->display, False);
}

void XDisplay::unplug_monitor() {
  if (!monitor_) monitor_ = std::make_unique<MonitorSwitch>(connection_->display);
  monitor_->set(false);
}

void XDisplay::plug_in_monitor() { monitor_->set(true); }

LdrImage XDisplay::take_screenshot() const {
  ::Display* display = connection_->display;
  XImage* picture = XGetImage(display, DefaultRootWindow(display), x_, y_, static_cast<unsigned>(width_),
                              static_cast<unsigned>(height_), AllPlanes, ZPixmap);
  if (!picture || picture->bits_per_pixel != 32 || picture->byte_order != LSBFirst ||
      picture->red_mask != 0xFF0000 || picture->blue_mask != 0xFF) {
    throw std::runtime_error("a screen of 24 bits is expected");
  }
  LdrImage image(width_, height_);
  std::uint8_t* target = image.values.data();
  for (int y = 0; y < height_; ++y) {
    const auto* source = reinterpret_cast<const std::uint8_t*>(picture->data) + y * picture->bytes_per_line;
    for (int x = 0; x < width_; ++x, source += 4, target += 3) {
      target[0] = source[2];
      target[1] = source[1];
      target[2] = source[0];
    }
  }
  XDestroyImage(picture);
  return image;
}

}  // namespace equilux
