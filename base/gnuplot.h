// gnuplot, fed through a pipe.
#pragma once

#include <string>

namespace equilux {

inline constexpr int kNoGnuplot = 127;  ///< the status where there is no program of that name

/// Runs gnuplot on these commands; gives its exit status, or -1 where it ended by a signal or could not be
/// started.
int run_gnuplot(const std::string& commands);

}  // namespace equilux
