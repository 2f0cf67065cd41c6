// One mutex, which a check takes only while the work is held.
#include "base/work_control.h"

#include <utility>

namespace equilux {
namespace {

thread_local WorkControl* control_of_thread = nullptr;

}  // namespace

void WorkControl::pause() {
  const std::lock_guard lock(mutex_);
  if (!is_paused_) paused_at_ = std::chrono::steady_clock::now();
  is_held_ = is_paused_ = true;
}

void WorkControl::resume() {
  const std::lock_guard lock(mutex_);
  if (is_paused_) paused_for_ += std::chrono::steady_clock::now() - paused_at_;
  is_paused_ = false;
  is_held_ = is_cancelled_;
  changed_.notify_all();
}

void WorkControl::cancel() {
  const std::lock_guard lock(mutex_);
  is_held_ = is_cancelled_ = true;
  changed_.notify_all();
}

void WorkControl::check() {
  if (!is_held_) return;
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return is_cancelled_ || !is_paused_; });
  if (is_cancelled_) throw WorkCancelled();
}

double WorkControl::paused_seconds() const {
  const std::lock_guard lock(mutex_);
  auto all = paused_for_;
  if (is_paused_) all += std::chrono::steady_clock::now() - paused_at_;
  return std::chrono::duration<double>(all).count();
}

void WorkControl::tell(std::string line) {
  const std::lock_guard lock(mutex_);
  line_ = std::move(line);
}

std::string WorkControl::line() const {
  const std::lock_guard lock(mutex_);
  return line_;
}

ControlledWork::ControlledWork(WorkControl& control) : before_(std::exchange(control_of_thread, &control)) {}

ControlledWork::~ControlledWork() { control_of_thread = before_; }

WorkControl* current_control() { return control_of_thread; }

void check_control() {
  if (control_of_thread) control_of_thread->check();
}

}  // namespace equilux
