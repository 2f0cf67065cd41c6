// GLFW, GL and, for the colour profile, a property of the X root window.
#include "experiment/app/screen_facts.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <X11/Xatom.h>
#include <X11/Xlib.h>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <string>

#include "experiment/app/gl.h"
#include "experiment/app/monitor_names.h"

namespace equilux {
namespace {

constexpr int kFrames = 40, kFirstFrames = 8;  // the first ones wait for the window to settle
constexpr const char* kNotKnown = "not known";

std::string read_gl_string(GLenum name) {
  const auto* text = reinterpret_cast<const char*>(glGetString(name));
  return text ? text : kNotKnown;
}

std::string describe_gamma_ramp(const GLFWgammaramp* ramp) {
  if (!ramp || ramp->size < 2) return kNotKnown;
  if (ramp->red[ramp->size - 1] == 0) return kNotKnown;  // a screen without one
  for (unsigned i = 0; i < ramp->size; ++i) {
    const double identity = 65535.0 * i / (ramp->size - 1);
    for (const unsigned short* channel : {ramp->red, ramp->green, ramp->blue}) {
      if (std::abs(channel[i] - identity) > 256) return "changed";  // one step of 8 bits
    }
  }
  return "identity";
}

// With its curve where it is not the identity.
void read_gamma_ramp(GLFWmonitor* monitor, ScreenFacts& facts) {
  const GLFWgammaramp* ramp = glfwGetGammaRamp(monitor);
  facts.gamma_ramp = describe_gamma_ramp(ramp);
  if (facts.gamma_ramp != "changed") return;
  std::vector<std::vector<std::uint16_t>> channels;
  for (const unsigned short* channel : {ramp->red, ramp->green, ramp->blue})
    channels.emplace_back(channel, channel + ramp->size);
  facts.gamma_curve = find_gamma_curve(channels);
}

std::string read_icc_profile(::Display* x) {
  const Atom atom = XInternAtom(x, "_ICC_PROFILE", True);
  if (atom == None) return "";
  Atom type = None;
  int format = 0;
  unsigned long count = 0, left = 0;
  unsigned char* bytes = nullptr;
  constexpr long kMostWords = 1 << 20;
  const int code = XGetWindowProperty(x, DefaultRootWindow(x), atom, 0, kMostWords, False, AnyPropertyType,
                                      &type, &format, &count, &left, &bytes);
  if (code != Success || !bytes) return "";
  const std::string profile(reinterpret_cast<const char*>(bytes), format == 8 ? count : 0);
  XFree(bytes);
  return profile;
}

// The window system keeps the first monitor's under this name; which one is meant is certain with one alone.
std::string describe_icc_profile() {
  int monitors = 0;
  glfwGetMonitors(&monitors);
  if (monitors != 1) return kNotKnown;
  ::Display* x = XOpenDisplay(nullptr);
  if (!x) return kNotKnown;
  const std::string profile = read_icc_profile(x);
  XCloseDisplay(x);
  if (profile.empty()) return kNotKnown;
  return fmt::format("{} ({} bytes)", find_profile_name(profile), profile.size());
}

std::optional<double> measure_refresh_hz(AppWindow& window) {
  std::vector<std::int64_t> shown;
  for (int frame = 0; frame < kFirstFrames + kFrames; ++frame) {
    window.clear();
    window.swap();
    if (frame >= kFirstFrames) shown.push_back(read_clock_ns());
  }
  return find_refresh_hz(shown);
}

}  // namespace

ScreenFacts read_screen_facts(const Display& display, AppWindow& window) {
  ScreenFacts facts;
  facts.monitor = display.monitor_name();
  facts.mode = display.size();
  facts.mode_hz = glfwGetVideoMode(display.monitor())->refreshRate;
  facts.reported_mm = display.reported_mm();
  facts.framebuffer = window.framebuffer();
  float scale_x = 1, scale_y = 1;
  glfwGetWindowContentScale(window.handle(), &scale_x, &scale_y);
  facts.content_scale = std::max(scale_x, scale_y);
  facts.gl_renderer = read_gl_string(GL_RENDERER);
  facts.gl_version = read_gl_string(GL_VERSION);
  read_gamma_ramp(display.monitor(), facts);
  facts.icc_profile = describe_icc_profile();
  facts.measured_hz = measure_refresh_hz(window);
  return facts;
}

}  // namespace equilux
