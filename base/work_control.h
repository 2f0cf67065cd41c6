// Whoever started long work in another thread holds it, lets it go on or ends it, and hears how far it is.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>

namespace equilux {

/// Ends work that was cancelled; no failure, so no Error.
class WorkCancelled : public std::exception {
 public:
  const char* what() const noexcept override { return "cancelled"; }
};

/// Shared by the threads that work and the one that watches. Thread-safe.
class WorkControl {
 public:
  void pause();
  void resume();
  /// For good; ends a pause.
  void cancel();

  /// Between two pieces of work: returns at once, or when a pause is over. errors: WorkCancelled
  void check();

  /// How long it was paused so far. units: s
  double paused_seconds() const;

  void tell(std::string line);
  /// What was told last.
  std::string line() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool is_paused_ = false, is_cancelled_ = false;
  std::atomic<bool> is_held_ = false;                     ///< either: what check looks at first
  std::chrono::steady_clock::time_point paused_at_ = {};  ///< while paused
  std::chrono::steady_clock::duration paused_for_ = {};   ///< in earlier pauses
  std::string line_;
};

/// While it lives, what this thread does is under a control: parallel loops ask it piece by piece on all
/// their threads, progress goes to it, and check_control() asks it.
class ControlledWork {
 public:
  explicit ControlledWork(WorkControl& control);
  ~ControlledWork();
  ControlledWork(const ControlledWork&) = delete;
  ControlledWork& operator=(const ControlledWork&) = delete;

 private:
  WorkControl* before_;
};

/// Of this thread; null where nobody watches it.
WorkControl* current_control();

/// errors: WorkCancelled
void check_control();

}  // namespace equilux
