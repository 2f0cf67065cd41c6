// Counts to estimates; those of equal counts are computed once.
#include "analysis/cell_statistics.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "base/error.h"

namespace equilux {
namespace {

using EstimatesByCount = std::map<std::pair<std::int64_t, std::int64_t>, CellEstimate>;

CellEstimate make_estimate(const Count& count) {
  CellEstimate estimate;
  estimate.proportion = static_cast<double>(count.k) / static_cast<double>(count.n);
  estimate.clopper_pearson = *find_clopper_pearson(count);
  estimate.jeffreys = *find_jeffreys(count);
  estimate.p_guess = *eval_p_guess(count);
  estimate.posterior_over = *eval_posterior_over(count);
  return estimate;
}

const CellEstimate& find_estimate(EstimatesByCount& known, const Count& count) {
  const auto [entry, is_new] = known.try_emplace({count.k, count.n});
  if (is_new) entry->second = make_estimate(count);
  return entry->second;
}

void fill_false_discovery(std::map<Cell, CellStatistics>& statistics) {
  std::vector<CellEstimate*> tested;
  std::vector<double> p_values;
  for (auto& [cell, row] : statistics) {
    if (!row.estimate) continue;
    tested.push_back(&*row.estimate);
    p_values.push_back(row.estimate->p_guess);
  }
  const std::vector<double> q_values = adjust_false_discovery(p_values);
  for (std::size_t i = 0; i < tested.size(); ++i) tested[i]->q_guess = q_values[i];
}

}  // namespace

std::map<Cell, CellStatistics> find_cell_statistics(const Tally& tally) {
  EstimatesByCount known;
  std::map<Cell, CellStatistics> statistics;
  for (const auto& [cell, count] : tally) {
    CellStatistics& row = statistics[cell];
    row.status = find_cell_status(count);
    if (count.n > 0) row.estimate = find_estimate(known, count);
  }
  fill_false_discovery(statistics);
  return statistics;
}

// Cut off there, the posterior is divided by what of it lies above.
double find_most_by_truncation(const Tally& tally) {
  double most = 0;
  for (const auto& [cell, count] : tally) {
    if (count.n == 0) continue;
    const double over = *eval_posterior_over(count), above_chance = *eval_posterior_over(count, 0.5);
    if (above_chance > 0) most = std::max(most, over / above_chance - over);
  }
  return most;
}

CellStatus find_cell_status(const Count& count) {
  if (count.n == 0) return CellStatus::kUntested;
  if (count.n == 1) return CellStatus::kSingle;
  if (count.k == 0) return CellStatus::kAllWrong;
  return count.k == count.n ? CellStatus::kAllRight : CellStatus::kInner;
}

std::string format_cell_status(CellStatus status) {
  switch (status) {
    case CellStatus::kSingle:
      return "single";
    case CellStatus::kAllWrong:
      return "all_wrong";
    case CellStatus::kAllRight:
      return "all_right";
    case CellStatus::kInner:
      return "inner";
    case CellStatus::kUntested:
      break;
  }
  return "untested";
}

}  // namespace equilux
