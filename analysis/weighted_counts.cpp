// A matrix by rows to lists by cells, and lists to sums.
#include "analysis/weighted_counts.h"

#include <algorithm>
#include <numeric>

#include "base/error.h"

namespace equilux {
namespace {

using Weights = std::vector<Lanes>;

Lanes add_rows(const Weights& weights, const std::vector<std::uint32_t>& rows) {
  Lanes::Eight first{}, second{};
  for (const std::uint32_t row : rows) {
    first += weights[row].first;
    second += weights[row].second;
  }
  return {first, second};
}

}  // namespace

WeightedCounts::WeightedCounts(const ResponseMatrix& matrix)
    : subjects_(matrix.subjects()), cells_(matrix.cells.size()) {
  const std::size_t width = cells_.size();
  for (std::size_t s = 0; s < subjects_; ++s) {
    const auto row = static_cast<std::uint32_t>(s);
    for (std::size_t c = 0; c < width; ++c) {
      const std::size_t at = s * width + c;
      cells_[c].correct.insert(cells_[c].correct.end(), matrix.correct[at], row);
      cells_[c].asked.insert(cells_[c].asked.end(), matrix.asked[at], row);
    }
  }
  for (CellRows& cell : cells_) {
    const auto& asked = cell.asked;
    cell.asks_all_once =
        asked.size() == subjects_ && std::adjacent_find(asked.begin(), asked.end()) == asked.end();
    if (cell.asks_all_once) cell.asked = {};
  }
}

std::vector<LaneCounts> WeightedCounts::count(const Weights& weights) const {
  EQ_CHECK(weights.size() == subjects_, weights.size(), subjects_);
  std::vector<std::uint32_t> everyone(subjects_);
  std::iota(everyone.begin(), everyone.end(), std::uint32_t{0});
  const Lanes all = add_rows(weights, everyone);
  std::vector<LaneCounts> counts(cells_.size());
  for (std::size_t c = 0; c < cells_.size(); ++c) {
    counts[c].k = add_rows(weights, cells_[c].correct);
    counts[c].n = cells_[c].asks_all_once ? all : add_rows(weights, cells_[c].asked);
  }
  return counts;
}

}  // namespace equilux
