// What is known of each cell: proportion, intervals, chance, false discoveries, and whether it is over the
// cut.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "analysis/probability.h"

namespace equilux {

/// Whether a cell's numbers say what they seem to say. The numbers are finite in every case.
enum class CellStatus {
  kUntested,  ///< n = 0: there are no numbers
  kSingle,    ///< n = 1: the intervals exclude next to nothing
  kAllWrong,  ///< k = 0: the lower ends are 0, one-sided
  kAllRight,  ///< k = n: the upper ends are 1, one-sided
  kInner      ///< 0 < k < n
};

/// A tested cell. units: proportions and probabilities, 0 to 1.
struct CellEstimate {
  double proportion = 0;
  Interval clopper_pearson;
  Interval jeffreys;
  double p_guess = 1;  ///< of k or more of n at one half, exact
  double q_guess = 1;  ///< the same after Benjamini and Hochberg, over the tested cells of the experiment
  double posterior_over = 0;  ///< that the true proportion is at the cut or above
};

struct CellStatistics {
  CellStatus status = CellStatus::kUntested;
  std::optional<CellEstimate> estimate;  ///< empty iff untested
};

/// Statistics of every cell of a tally.
std::map<Cell, CellStatistics> find_cell_statistics(const Tally& tally);

/// The most that P(over the cut) of a tested cell would rise by, were Jeffreys' prior cut off below one half.
double find_most_by_truncation(const Tally& tally);

CellStatus find_cell_status(const Count& count);
std::string format_cell_status(CellStatus status);

}  // namespace equilux
