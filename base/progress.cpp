// Where a long job says how far it is.
#include "base/progress.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <fmt/format.h>
#include <unistd.h>

namespace equilux {
namespace {

constexpr double kShortestQuiet = 0.2, kLongestQuiet = 300;  // s

}  // namespace

std::string format_seconds(double seconds) {
  if (seconds < 9.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = std::llround(seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  return fmt::format("{} h {:02} min", whole / 3600, whole % 3600 / 60);
}

Progress::Progress(std::string label, double total)
    : label_(std::move(label)),
      total_(total),
      control_(current_control()),
      is_terminal_(::isatty(STDERR_FILENO) != 0),
      exceptions_(std::uncaught_exceptions()),
      start_(std::chrono::steady_clock::now()),
      paused_before_s_(control_ ? control_->paused_seconds() : 0) {}

Progress::~Progress() {
  if (!printed_ || control_) return;
  if (is_terminal_) std::fputs("\r\033[K", stderr);
  const bool is_stopped = std::uncaught_exceptions() > exceptions_;
  fmt::print(stderr, "{}: {} {}\n", label_, is_stopped ? "stopped after" : "done in",
             format_seconds(seconds_worked()));
}

double Progress::seconds_worked() const {
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  return seconds - (control_ ? control_->paused_seconds() - paused_before_s_ : 0);
}

void Progress::advance(double work) {
  if (control_) control_->check();
  const std::lock_guard lock(mutex_);
  done_ += work;
  const double seconds = seconds_worked();
  const double share = total_ > 0 ? done_ / total_ : 1;
  if (share >= 1 || !is_due(seconds, share)) return;
  control_ ? control_->tell(format_line(seconds)) : print(format_line(seconds));
  printed_ = true;
  last_print_s_ = seconds;
  last_share_ = share;
}

bool Progress::is_due(double seconds, double share) const {
  const double quiet = seconds - last_print_s_;
  if (control_) return !printed_ || quiet > kShortestQuiet;
  if (!printed_) return seconds > 2;
  if (is_terminal_) return quiet > kShortestQuiet;
  return quiet > kLongestQuiet || (quiet > 10 && share - last_share_ > 0.1);
}

void Progress::expect_more(double work) {
  const std::lock_guard lock(mutex_);
  total_ = std::max(done_, total_ + work);
}

void Progress::tell(std::string what) {
  const std::lock_guard lock(mutex_);
  what_ = std::move(what);
}

std::string Progress::format_line(double seconds) const {
  const double share = total_ > 0 ? done_ / total_ : 1;
  const std::string eta = share > 0.01 ? format_seconds(seconds * (1 - share) / share) : "?";
  return fmt::format("{}: {:3.0f} %, {} left{}{}", label_, 100 * share, eta, what_.empty() ? "" : "; ",
                     what_);
}

void Progress::print(const std::string& line) {
  if (is_terminal_) {
    fmt::print(stderr, "\r\033[K{}", line);
  } else {
    fmt::print(stderr, "{}\n", line);
  }
  std::fflush(stderr);
}

}  // namespace equilux
