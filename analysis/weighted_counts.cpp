// A matrix by rows to lists by cells, and lists to sums.
#include "analysis/weighted_counts.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "base/error.h"

namespace equilux {
namespace {

using Weights = std::vector<Lanes>;
using Rows = std::vector<std::uint32_t>;

Lanes add_rows(const Weights& weights, const Rows& rows) {
  Lanes::Eight first{}, second{};
  for (const std::uint32_t row : rows) {
    first += weights[row].first;
    second += weights[row].second;
  }
  return {first, second};
}

// All lanes in one register: for sums below 2^16, half as many steps over half as much memory.
using Narrow = std::uint16_t __attribute__((vector_size(32)));
using NarrowWeights = std::vector<Narrow>;
constexpr std::uint64_t kMostNarrow = std::numeric_limits<std::uint16_t>::max();

using NarrowHalf = std::uint16_t __attribute__((vector_size(16)));

Narrow narrow(const Lanes& lanes) {
  return __builtin_shufflevector(__builtin_convertvector(lanes.first, NarrowHalf),
                                 __builtin_convertvector(lanes.second, NarrowHalf), 0, 1, 2, 3, 4, 5, 6, 7, 8,
                                 9, 10, 11, 12, 13, 14, 15);
}

Lanes widen(const Narrow& lanes) {
  const NarrowHalf first = __builtin_shufflevector(lanes, lanes, 0, 1, 2, 3, 4, 5, 6, 7),
                   second = __builtin_shufflevector(lanes, lanes, 8, 9, 10, 11, 12, 13, 14, 15);
  return {__builtin_convertvector(first, Lanes::Eight), __builtin_convertvector(second, Lanes::Eight)};
}

Lanes add_rows(const NarrowWeights& weights, const Rows& rows) {
  Narrow sum{};
  for (const std::uint32_t row : rows) sum += weights[row];
  return widen(sum);
}

std::uint64_t find_largest(const Lanes& lanes) {
  std::uint64_t largest = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) largest = std::max<std::uint64_t>(largest, lanes[lane]);
  return largest;
}

}  // namespace

// The shorter list of two is kept, since each resample goes through it.
WeightedCounts::WeightedCounts(const ResponseMatrix& matrix)
    : subjects_(matrix.subjects()), cells_(matrix.cells.size()) {
  const std::size_t width = cells_.size();
  const auto add = [](Rows& rows, std::size_t times, std::size_t row) {
    rows.insert(rows.end(), times, static_cast<std::uint32_t>(row));
  };
  std::vector<CellRows> others(width);
  std::vector<char> is_asked_once(width, 1);
  for (std::size_t s = 0; s < subjects_; ++s) {
    for (std::size_t c = 0; c < width; ++c) {
      const std::uint16_t asked = matrix.asked[s * width + c], correct = matrix.correct[s * width + c];
      EQ_CHECK(correct <= asked, correct, asked);
      most_times_ = std::max(most_times_, asked);
      is_asked_once[c] = is_asked_once[c] && asked <= 1;
      add(cells_[c].correct, correct, s);
      add(others[c].correct, std::size_t{asked} - correct, s);
      add(cells_[c].asked, asked, s);
      add(others[c].asked, asked == 0 ? 1 : 0, s);
    }
  }
  for (std::size_t c = 0; c < width; ++c) {
    CellRows &cell = cells_[c], &other = others[c];
    cell.are_wrong = other.correct.size() < cell.correct.size();
    if (cell.are_wrong) cell.correct = std::move(other.correct);
    cell.are_unasked = is_asked_once[c] && other.asked.size() < cell.asked.size();
    if (cell.are_unasked) cell.asked = std::move(other.asked);
  }
}

std::vector<LaneCounts> WeightedCounts::count(const Weights& weights) const {
  EQ_CHECK(weights.size() == subjects_, weights.size(), subjects_);
  std::vector<std::uint32_t> everyone(subjects_);
  std::iota(everyone.begin(), everyone.end(), std::uint32_t{0});
  const Lanes all = add_rows(weights, everyone);
  if (find_largest(all) * most_times_ > kMostNarrow) return add_cells(weights, all);
  NarrowWeights narrow_weights(subjects_);
  std::transform(weights.begin(), weights.end(), narrow_weights.begin(), narrow);
  return add_cells(narrow_weights, all);
}

std::vector<LaneCounts> WeightedCounts::add_cells(const auto& weights, const Lanes& all) const {
  std::vector<LaneCounts> counts(cells_.size());
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    const CellRows& cell = cells_[c];
    const Lanes asked = add_rows(weights, cell.asked), correct = add_rows(weights, cell.correct);
    counts[c].n = cell.are_unasked ? all - asked : asked;
    counts[c].k = cell.are_wrong ? counts[c].n - correct : correct;
  }
  return counts;
}

}  // namespace equilux
