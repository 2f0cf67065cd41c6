// What the three mains share: the boundary where errors become messages and exit codes.
#pragma once

#include <functional>
#include <string>

namespace equilux {

inline constexpr int kExitOk = 0;
inline constexpr int kExitError = 1;  ///< input or run error
inline constexpr int kExitUsage = 2;  ///< wrong command line

/// Runs `body`; an exception becomes one line on standard error, prefixed by the program's name, and
/// kExitError.
int run_program(const std::string& name, const std::function<int()>& body);

/// Name of this machine.
std::string find_host_name();

/// Now in UTC, ISO 8601 with milliseconds: "2026-01-31T12:00:00.000Z".
std::string format_utc_now();

/// Hours from one such time to another. errors: InputError for a text that is none
double count_hours(const std::string& from_utc, const std::string& to_utc);

}  // namespace equilux
