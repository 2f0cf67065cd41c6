// Counts of many resamples of subjects at once: what the bootstrap spends its time on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "analysis/response_matrix.h"

namespace equilux {

/// Resamples that are counted together, so that a processor adds several of them in one step.
inline constexpr std::size_t kLanes = 16;

/// A number for each of them, as GCC and Clang keep them in registers that add eight at once: an array, or
/// one vector of sixteen, GCC 12 takes apart.
struct Lanes {
  using Eight = std::uint32_t __attribute__((vector_size(32)));
  Eight first{}, second{};

  void add(std::size_t lane, std::uint32_t more) { (lane < 8 ? first : second)[lane % 8] += more; }
  std::uint32_t operator[](std::size_t lane) const { return (lane < 8 ? first : second)[lane % 8]; }
  Lanes operator-(const Lanes& other) const { return {first - other.first, second - other.second}; }
};

/// Of one cell. shape: one for each resample
struct LaneCounts {
  Lanes k, n;

  Count of(std::size_t lane) const { return {k[lane], n[lane]}; }
};

/// A response matrix by cells, each a list of the subjects who add to it.
class WeightedCounts {
 public:
  explicit WeightedCounts(const ResponseMatrix& matrix);

  /// `weights`: how often each subject counts in each resample. shape: one for each cell. errors: EQ_CHECK of
  /// the shape.
  std::vector<LaneCounts> count(const std::vector<Lanes>& weights) const;

 private:
  // Rows of the matrix, one for each time that they add one to the cell.
  struct CellRows {
    std::vector<std::uint32_t> correct;
    std::vector<std::uint32_t> asked;
    bool are_wrong = false;    // then `correct` has what is not correct of what was asked
    bool are_unasked = false;  // then `asked` has those who were not asked, and the others were once
  };

  // `all`: the sums of the weights.
  std::vector<LaneCounts> add_cells(const auto& weights, const Lanes& all) const;

  std::size_t subjects_;
  std::uint16_t most_times_ = 0;  // that a subject was asked in one cell
  std::vector<CellRows> cells_;
};

}  // namespace equilux
