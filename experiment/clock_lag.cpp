// Times of the system's clock are for people, and for the age of an interrupted session; here they are
// doubted.
#include "experiment/clock_lag.h"

#include <algorithm>
#include <fmt/format.h>

#include "base/program.h"

namespace equilux {
namespace {

constexpr double kToleranceHours = 1.0 / 60;  // what a time server sets right

std::string format_lag(double hours) {
  return hours < 1 ? fmt::format("{:.0f} minutes", 60 * hours) : fmt::format("{:.1f} hours", hours);
}

// At which a session was begun or something of one recorded. Such texts are in the order of their times.
std::string find_latest_utc(const TrialLog& log) {
  std::string latest;
  for (const SessionRow& row : log.load_sessions()) {
    latest = std::max(latest, row.started_utc);
    for (const EventRow& event : log.load_events(row.id)) latest = std::max(latest, event.recorded_utc);
  }
  return latest;
}

}  // namespace

std::optional<ClockLag> find_clock_lag(const TrialLog& log, const std::string& now_utc) {
  const std::string latest = find_latest_utc(log);
  if (latest.empty()) return std::nullopt;
  ClockLag lag{now_utc.empty() ? format_utc_now() : now_utc, latest, 0};
  lag.hours = count_hours(lag.now_utc, lag.latest_utc);
  return lag.hours > kToleranceHours ? std::optional(lag) : std::nullopt;
}

std::string describe_clock_lag(const ClockLag& lag) {
  return fmt::format(
      "This computer's clock says {}, but the log has something of {}, {} later: the clock was set back, or "
      "was ahead then. Set it right; how long ago a session was interrupted, and which one was the last, "
      "cannot be told by it.",
      lag.now_utc, lag.latest_utc, format_lag(lag.hours));
}

}  // namespace equilux
