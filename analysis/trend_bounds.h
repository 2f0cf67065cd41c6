// What the trends of a study could show at best.
#pragma once

#include <vector>

#include "analysis/trends.h"

namespace equilux {

/// The least that p_holm of each trend could be, were every one of these as strong as it can be; 1 where
/// nothing is compared. shape: as `trends`. source: Holm 1979, over p_least
std::vector<double> find_least_holm(const std::vector<Trend>& trends);

}  // namespace equilux
