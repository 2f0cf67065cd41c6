// What chance alone would do: exact tails of the binomial distribution.
#pragma once

#include <optional>

#include "analysis/tally.h"

namespace equilux {

/// Probability of k or more of n at one half, the p_guess of cells.csv; empty where n = 0. Summed in integers
/// up to n = 62 and so the double nearest to the rational number; by the incomplete beta function beyond.
std::optional<double> eval_p_guess(const Count& count);

inline constexpr double kFlagProportion = 0.75;  ///< proportion correct at which a cell is flagged
inline constexpr double kSupportLevel = 0.05;    ///< one-sided error of a supported cell

/// True iff a true proportion of kFlagProportion would give k or fewer with probability of at most
/// kSupportLevel: then the cell is shown to be below the cut (k <= 5 of 12, k <= 7 of 14), not only not shown
/// to be above it.
bool is_supported(const Count& count);

}  // namespace equilux
