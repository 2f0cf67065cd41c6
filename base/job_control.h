// Whoever started a long job from another thread holds it, lets it go on or ends it, and hears how far it is.
#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <string>

namespace equilux {

/// Ends a job that was cancelled; no failure, so no Error.
class JobCancelled : public std::exception {
 public:
  const char* what() const noexcept override { return "cancelled"; }
};

/// Shared by a job's threads and the one that watches it. Thread-safe.
class JobControl {
 public:
  void pause();
  void resume();
  /// For good; ends a pause.
  void cancel();

  /// What a job's threads call between two pieces of work: returns at once, or when a pause is over. errors:
  /// JobCancelled
  void check();

  void tell(std::string line);
  /// What the job told last.
  std::string line() const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  bool is_paused_ = false, is_cancelled_ = false;
  std::string line_;
};

}  // namespace equilux
