// One mutex: a check stands between pieces of work that last milliseconds.
#include "base/job_control.h"

#include <utility>

namespace equilux {

void JobControl::pause() {
  const std::lock_guard lock(mutex_);
  is_paused_ = true;
}

void JobControl::resume() {
  const std::lock_guard lock(mutex_);
  is_paused_ = false;
  changed_.notify_all();
}

void JobControl::cancel() {
  const std::lock_guard lock(mutex_);
  is_cancelled_ = true;
  changed_.notify_all();
}

void JobControl::check() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return is_cancelled_ || !is_paused_; });
  if (is_cancelled_) throw JobCancelled();
}

void JobControl::tell(std::string line) {
  const std::lock_guard lock(mutex_);
  line_ = std::move(line);
}

std::string JobControl::line() const {
  const std::lock_guard lock(mutex_);
  return line_;
}

}  // namespace equilux
