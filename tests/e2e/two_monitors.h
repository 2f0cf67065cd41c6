// A desktop of two monitors that come and go.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/e2e/x_display.h"

namespace equilux {

/// A monitor as a desktop has it. units: pixels
struct PlacedMonitor {
  const char* name = "";
  int x = 0, y = 0, width = 0, height = 0;
};

inline constexpr PlacedMonitor kFirstMonitor{"DUMMY0", 0, 0, 1024, 768};
inline constexpr PlacedMonitor kSecondMonitor{"DUMMY1", 1024, 0, 1280, 1024};
inline constexpr int kDesktopWidth = 2304, kDesktopHeight = 1024;

/// Xorg with its driver of monitors that are none, without a window manager. Looks at the first monitor.
class TwoMonitors : public XDisplay {
 public:
  /// `folder` takes its files. errors: std::runtime_error where it does not start; it needs neither root nor
  /// a terminal of its own
  explicit TwoMonitors(const std::filesystem::path& folder);
  /// Both, for the first time.
  void connect() const;

  void look_at_monitor(const PlacedMonitor& monitor);
  /// The other one then stands at the desktop's beginning.
  void unplug(const PlacedMonitor& monitor) const;
  /// Both, each at its place.
  void plug_in(const PlacedMonitor& first, const PlacedMonitor& second) const;
  /// Of red, green and blue, as "1:1:1".
  void set_gamma(const PlacedMonitor& monitor, const std::string& gamma) const;

 private:
  void arrange(const std::vector<std::string>& arguments) const;
};

}  // namespace equilux
