// A computer's clock that is behind what its log has recorded.
#pragma once

#include <optional>
#include <string>

#include "experiment/trial_log.h"

namespace equilux {

/// The clock was set back since, or was ahead then: no age can be told by it.
struct ClockLag {
  std::string now_utc;
  std::string latest_utc;  ///< that the log knows of
  double hours = 0;
};

/// Empty where the clock is not behind the log by more than a minute. `now_utc` is the system clock's where
/// empty.
std::optional<ClockLag> find_clock_lag(const TrialLog& log, const std::string& now_utc = "");

/// For the experimenter, with what to do.
std::string describe_clock_lag(const ClockLag& lag);

}  // namespace equilux
