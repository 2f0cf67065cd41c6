// Exact tests of an order in verdicts: what one object contributes is permuted as a whole.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace equilux {

/// Verdicts of one object along a factor: those at its several VPL counts go up and down together, so that
/// they are one observation and not several. A stratum is the object at one VPL count.
struct Cluster {
  /// Whether equivalence exists; empty: not known. shape: levels of the factor, in order, x strata
  std::vector<std::vector<std::optional<bool>>> levels;
};

/// Whether some stratum has verdicts at two levels.
bool has_pairs(const Cluster& cluster);

/// P(|S| >= |statistic|) where S adds up, over all strata of all clusters, the later less the earlier verdict
/// of each pair, and the levels of each cluster stand in every order equally often, each with all its
/// verdicts. For two levels that is a test of sign flips. source: Jonckheere's statistic; exact, by
/// convolution of the distributions of clusters.
double eval_permutation_p(const std::vector<Cluster>& clusters, std::int64_t statistic);

/// The least that eval_permutation_p can be over all verdicts in the same places. Exact where the levels of a
/// cluster have their verdicts in the same strata, or where there are two; else a bound from below, by all
/// orders of its levels.
double find_least_p(const std::vector<Cluster>& clusters);

}  // namespace equilux
