// p_least of each trend, corrected as p is.
#include "analysis/trend_bounds.h"

namespace equilux {

std::vector<double> find_least_holm(const std::vector<Trend>& trends) {
  std::vector<double> compared, least(trends.size(), 1);
  for (const Trend& trend : trends) {
    if (trend.status != TrendStatus::kNoPairs) compared.push_back(trend.p_least);
  }
  const std::vector<double> adjusted = adjust_holm(compared);
  for (std::size_t i = 0, next = 0; i < trends.size(); ++i) {
    if (trends[i].status != TrendStatus::kNoPairs) least[i] = adjusted[next++];
  }
  return least;
}

}  // namespace equilux
