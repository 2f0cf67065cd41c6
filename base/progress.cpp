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

constexpr double kLongestQuiet = 300;  // s

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
      is_terminal_(::isatty(STDERR_FILENO) != 0),
      exceptions_(std::uncaught_exceptions()),
      start_(std::chrono::steady_clock::now()) {}

Progress::~Progress() {
  if (!printed_) return;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  if (is_terminal_) std::fputs("\r\033[K", stderr);
  const bool is_stopped = std::uncaught_exceptions() > exceptions_;
  fmt::print(stderr, "{}: {} {}\n", label_, is_stopped ? "stopped after" : "done in",
             format_seconds(seconds));
}

void Progress::advance(double work) {
  const std::lock_guard lock(mutex_);
  done_ += work;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  const double share = total_ > 0 ? done_ / total_ : 1;
  const double quiet = seconds - last_print_s_;
  const bool due = is_terminal_
                       ? quiet > 0.2
                       : quiet > kLongestQuiet || (quiet > 10 && (share - last_share_ > 0.1 || !printed_));
  const bool first = !printed_ && seconds > 2;
  if ((first || (printed_ && due)) && share < 1) {
    print(seconds);
    last_print_s_ = seconds;
    last_share_ = share;
  }
}

void Progress::expect_more(double work) {
  const std::lock_guard lock(mutex_);
  total_ = std::max(done_, total_ + work);
}

void Progress::tell(std::string what) {
  const std::lock_guard lock(mutex_);
  what_ = std::move(what);
}

void Progress::print(double seconds) {
  const double share = total_ > 0 ? done_ / total_ : 1;
  const std::string eta = share > 0.01 ? format_seconds(seconds * (1 - share) / share) : "?";
  const std::string line =
      fmt::format("{}: {:3.0f} %, {} left{}{}", label_, 100 * share, eta, what_.empty() ? "" : "; ", what_);
  if (is_terminal_) {
    fmt::print(stderr, "\r\033[K{}", line);
  } else {
    fmt::print(stderr, "{}\n", line);
  }
  std::fflush(stderr);
  printed_ = true;
}

}  // namespace equilux
