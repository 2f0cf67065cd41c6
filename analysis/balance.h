// On which side and in which view test pictures stood: measured from the trials of counted sessions, not
// taken from the rule that made them.
#pragma once

#include <cstdint>

#include "analysis/evidence.h"

namespace equilux {

/// What counts of the four combinations of view and side may differ by, in a session and of a cell.
inline constexpr std::int64_t kBalanceAllows = 1;

/// How far counts of the combinations are apart, largest less smallest, over sessions or over cells.
struct Spread {
  std::size_t measured = 0;  ///< sessions or cells
  std::int64_t largest = 0;
  std::size_t over = 0;  ///< with more than kBalanceAllows
};

struct Balance {
  Spread sessions;  ///< finished ones of which all views are known
  Spread cells;     ///< over those sessions
  /// Most answers to one cell under one code; a session without a code is a subject of its own.
  std::int64_t most_answers = 0;
};

/// Of the finished sessions: of a session all main trials as they were shown, of a cell those that were
/// answered. errors: CheckFailure where a session has more answers than answered trials.
Balance find_balance(const ExperimentEvidence& evidence);

}  // namespace equilux
