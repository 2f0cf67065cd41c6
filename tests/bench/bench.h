// What the benchmarks share.
#pragma once

#include <chrono>
#include <vector>

#include "protocols/condition.h"

namespace equilux::bench {

double time_s(const auto& body) {
  const auto start = std::chrono::steady_clock::now();
  body();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// C0 to C10. units: 1/m^2
inline const std::vector<double>& all_levels() {
  static const std::vector<double> clamps = [] {
    std::vector<double> made;
    for (int level = 0; level < kClampLevelCount; ++level) made.push_back(clamp_per_m2(level));
    return made;
  }();
  return clamps;
}

}  // namespace equilux::bench
