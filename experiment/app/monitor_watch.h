// Whether the monitor of a window is still there, by what the window system tells of all monitors: no window
// in it.
#pragma once

#include <string>

namespace equilux {

/// Follows one monitor. A monitor is known by its address while it is connected, and by its name when it
/// comes back, since the window system then makes another of it.
class MonitorWatch {
 public:
  /// Which one; it is there.
  void follow(const void* monitor, const std::string& name);

  /// Some monitor is gone, or there. True if it is the one followed, which is lost now, or back. Of two of
  /// one name that are both gone the first to come back counts.
  bool disconnect(const void* monitor);
  bool connect(const void* monitor, const std::string& name);

  bool is_lost() const { return is_lost_; }
  const std::string& name() const { return name_; }

 private:
  const void* monitor_ = nullptr;
  std::string name_;
  bool is_lost_ = false;
};

}  // namespace equilux
