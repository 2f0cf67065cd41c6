// Posterior probability of equivalence: each cell's proportion drawn from its posterior, the column judged.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "analysis/equivalence.h"

namespace equilux {

struct PosteriorParams {
  std::uint64_t seed = 1;
  int draws = 2000;  ///< Monte Carlo error of a share: at most 0.011
};

/// Shares of draws under each rule; empty where no draw has a verdict. shape: in order of kRules
using RuleShares = std::array<std::optional<double>, 2>;

/// Of EE.
struct EquivalencePosterior {
  RuleShares jeffreys;    ///< from Jeffreys' prior, Beta(1/2, 1/2) on [0, 1]
  RuleShares above_half;  ///< the same prior cut off below 1/2, where no two-alternative proportion can lie
};

/// Of a column with answers in both experiments. Draws below one half are drawn anew from the posterior that
/// is cut off there, from streams of their own; those above are the same for both priors.
EquivalencePosterior find_posterior(const ColumnFinding& column, const PosteriorParams& params);

/// That some level is free of artifacts, by the artifact answers alone and Jeffreys' prior.
RuleShares find_free_posterior(const ColumnFinding& column, const PosteriorParams& params);

}  // namespace equilux
