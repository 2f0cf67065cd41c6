// Progress with an ETA for whatever lasts; quiet and line-wise when the output is no terminal.
#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "base/work_control.h"

namespace equilux {

/// Reports done / total on standard error, or to the control of the thread that made it. Thread-safe. On a
/// terminal one line is rewritten five times a second; elsewhere a line appears after two seconds and then
/// when the share has grown by a tenth and ten seconds have gone, or five minutes have. The last line says
/// how long it took: the total is an estimate, which may be missed by some percent.
class Progress {
 public:
  /// `total` in any unit of work whose cost is even.
  Progress(std::string label, double total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Waits while the control holds the work. errors: WorkCancelled
  void advance(double work);
  /// There is so much more to do (or less) than was said before.
  void expect_more(double work);
  /// What is being done now: stands in the lines that follow.
  void tell(std::string what);

 private:
  double seconds_worked() const;  ///< since the start, without pauses
  bool is_due(double seconds, double share) const;
  std::string format_line(double seconds) const;
  void print(const std::string& line);

  std::string label_, what_;
  double total_;
  WorkControl* control_;
  double done_ = 0;
  bool is_terminal_;
  int exceptions_;  ///< in flight at the start
  bool printed_ = false;
  double last_print_s_ = 0;
  double last_share_ = 0;
  std::chrono::steady_clock::time_point start_;
  double paused_before_s_;
  std::mutex mutex_;
};

/// "1 h 02 min", "3 min 20 s", "4.1 s".
std::string format_seconds(double seconds);

}  // namespace equilux
