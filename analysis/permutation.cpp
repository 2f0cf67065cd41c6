// Orders of levels to sums, sums of clusters to one distribution.
#include "analysis/permutation.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace equilux {
namespace {

using Verdicts = std::vector<std::optional<bool>>;
using Distribution = std::map<std::int64_t, double>;  // probability of each sum

// Levels with the same verdicts are interchangeable.
struct Kind {
  Verdicts verdicts;
  int count = 0;
};

std::vector<Kind> find_kinds(const Cluster& cluster) {
  std::map<Verdicts, int> counts;
  for (const Verdicts& level : cluster.levels) ++counts[level];
  std::vector<Kind> kinds;
  for (const auto& [verdicts, count] : counts) kinds.push_back({verdicts, count});
  return kinds;
}

// The later less the earlier verdict, over the strata that have both.
std::int64_t gain(const Verdicts& earlier, const Verdicts& later) {
  std::int64_t sum = 0;
  for (std::size_t i = 0; i < earlier.size(); ++i) {
    if (earlier[i] && later[i]) sum += (*later[i] ? 1 : 0) - (*earlier[i] ? 1 : 0);
  }
  return sum;
}

// shape: [earlier][later]
std::vector<std::vector<std::int64_t>> find_gains(const std::vector<Kind>& kinds) {
  std::vector<std::vector<std::int64_t>> gains;
  for (const Kind& earlier : kinds) {
    gains.emplace_back();
    for (const Kind& later : kinds) gains.back().push_back(gain(earlier.verdicts, later.verdicts));
  }
  return gains;
}

// How many of each kind stand already, and the sums that their orders have given.
using Placed = std::map<std::vector<int>, Distribution>;

void place_next(Placed& next, const std::vector<int>& standing, const Distribution& sums,
                const std::vector<Kind>& kinds, const std::vector<std::vector<std::int64_t>>& gains,
                std::size_t left) {
  for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
    const int free = kinds[kind].count - standing[kind];
    if (free == 0) continue;
    std::int64_t added = 0;
    for (std::size_t before = 0; before < kinds.size(); ++before)
      added += standing[before] * gains[before][kind];
    std::vector<int> with = standing;
    ++with[kind];
    Distribution& to = next[with];
    for (const auto& [sum, p] : sums) to[sum + added] += p * free / static_cast<double>(left);
  }
}

// Level by level: which kind comes next is a draw from those that are left.
Distribution distribute(const Cluster& cluster) {
  const std::vector<Kind> kinds = find_kinds(cluster);
  const auto gains = find_gains(kinds);
  Placed placed{{std::vector<int>(kinds.size(), 0), {{0, 1.0}}}};
  for (std::size_t left = cluster.levels.size(); left > 0; --left) {
    Placed next;
    for (const auto& [standing, sums] : placed) place_next(next, standing, sums, kinds, gains, left);
    placed = std::move(next);
  }
  return placed.begin()->second;
}

Distribution convolve(const Distribution& a, const Distribution& b) {
  Distribution sum;
  for (const auto& [x, p] : a) {
    for (const auto& [y, q] : b) sum[x + y] += p * q;
  }
  return sum;
}

std::size_t count_strata(const Cluster& cluster) {
  return cluster.levels.empty() ? 0 : cluster.levels.front().size();
}

std::size_t count_verdicts(const Cluster& cluster, std::size_t stratum) {
  return static_cast<std::size_t>(
      std::count_if(cluster.levels.begin(), cluster.levels.end(),
                    [&](const Verdicts& level) { return level[stratum].has_value(); }));
}

// Without the strata that have no pairs, and without the levels that are in none then.
Cluster keep_pairs(const Cluster& cluster) {
  Cluster kept;
  for (const Verdicts& level : cluster.levels) {
    Verdicts verdicts;
    for (std::size_t i = 0; i < level.size(); ++i) {
      if (count_verdicts(cluster, i) > 1) verdicts.push_back(level[i]);
    }
    if (std::any_of(verdicts.begin(), verdicts.end(), [](const auto& v) { return v.has_value(); }))
      kept.levels.push_back(std::move(verdicts));
  }
  return kept;
}

bool is_complete(const Cluster& cluster) {
  for (std::size_t i = 0; i < count_strata(cluster); ++i) {
    if (count_verdicts(cluster, i) < cluster.levels.size()) return false;
  }
  return true;
}

double eval_factorial(std::size_t n) { return std::tgamma(static_cast<double>(n) + 1); }

// The most orders that S can tell apart. In a complete cluster it depends on how many strata of a level have
// EE, 0 to all: spread as evenly as can be, the levels have the most orders, and one of them the largest S.
double count_orders(const Cluster& cluster) {
  const Cluster kept = keep_pairs(cluster);
  const std::size_t levels = kept.levels.size();
  double orders = eval_factorial(levels);
  if (!is_complete(kept)) return orders;
  const std::size_t values = count_strata(kept) + 1;
  for (std::size_t value = 0; value < values; ++value)
    orders /= eval_factorial(levels / values + (value < levels % values ? 1 : 0));
  return orders;
}

}  // namespace

bool has_pairs(const Cluster& cluster) { return !keep_pairs(cluster).levels.empty(); }

double eval_permutation_p(const std::vector<Cluster>& clusters, std::int64_t statistic) {
  Distribution sum{{0, 1.0}};
  for (const Cluster& cluster : clusters) sum = convolve(sum, distribute(cluster));
  double far = 0;
  for (const auto& [value, p] : sum) far += std::abs(value) >= std::abs(statistic) ? p : 0;
  return std::min(far, 1.0);
}

double find_least_p(const std::vector<Cluster>& clusters) {
  double orders = 1;
  for (const Cluster& cluster : clusters) orders *= count_orders(cluster);
  return std::min(2 / orders, 1.0);
}

}  // namespace equilux
