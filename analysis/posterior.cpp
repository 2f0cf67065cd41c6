// Counts to draws of proportions, draws to shares of verdicts.
#include "analysis/posterior.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <string>
#include <utility>
#include <vector>

#include "analysis/beta.h"
#include "analysis/resampled.h"
#include "base/random_run.h"

namespace equilux {
namespace {

// A drawn proportion as k of n of this order: products of the sums of two pools of a column stay below 2^63.
constexpr std::int64_t kDrawScale = std::int64_t{1} << 28;

Beta make_beta(const Count& count) {
  return Beta(static_cast<double>(count.k) + 0.5, static_cast<double>(count.n - count.k) + 0.5);
}

std::int64_t find_largest_n(const ColumnCounts& counts) {
  std::int64_t largest = 1;
  for (const LevelCount& level : counts) largest = std::max(largest, level.count.n);
  return largest;
}

Count count_of(double proportion, std::int64_t n) {
  return {std::llround(proportion * static_cast<double>(n)), n};
}

// Draws of one cell's proportion from its posterior, as counts in which n keeps its weight among the others.
std::vector<Count> draw_cell(const Count& count, std::int64_t largest_n, const std::string& stream,
                             const PosteriorParams& params) {
  RandomBits bits(RandomRun(params.seed, stream, 0));
  Beta posterior = make_beta(count);
  const std::int64_t n = count.n * (kDrawScale / largest_n);
  std::vector<Count> draws(static_cast<std::size_t>(params.draws));
  for (Count& draw : draws) draw = count_of(posterior(bits), n);
  return draws;
}

// From the part of x^(a - 1) (1 - x)^(b - 1) above one half where that is far in its upper tail: below an
// exponential that touches the density at one half, of which most is kept. The first factor bends the other
// way for a < 1, where it falls: there the second alone sets the slope.
double draw_tail(const Beta& posterior, RandomBits& bits) {
  const double a = posterior.a() - 1, b = posterior.b() - 1, slope = 2 * (b - std::max(a, 0.0));
  for (;;) {
    const double beyond = -std::log1p(-bits.next_double()) / slope, x = 0.5 + beyond;
    const double accept = bits.next_double();
    if (x < 1 && std::log(accept) <= a * std::log(2 * x) + b * std::log(2 - 2 * x) + slope * beyond) return x;
  }
}

// One of the posterior cut off below one half. Further than a standard deviation from its mean the tail is
// drawn by itself, so that no cell takes long.
double draw_above_half(Beta& posterior, RandomBits& bits) {
  const double a = posterior.a(), b = posterior.b();
  if (b - a > std::sqrt(a + b)) return draw_tail(posterior, bits);
  double x = 0;
  while (x < 0.5) x = posterior(bits);
  return x;
}

std::vector<Count> lift_above_half(std::vector<Count> draws, const Count& count, const std::string& stream,
                                   std::uint64_t seed) {
  RandomBits bits(RandomRun(seed, stream, 0));
  Beta posterior = make_beta(count);
  for (Count& draw : draws) {
    if (2 * draw.k < draw.n) draw = count_of(draw_above_half(posterior, bits), draw.n);
  }
  return draws;
}

// shape: one vector of draws for each tested level, its place in the counts beside it.
using Draws = std::vector<std::pair<std::size_t, std::vector<Count>>>;

std::string name_stream(const char* draws, Experiment experiment, const Column& column, int level) {
  return fmt::format("analysis/{}/{}/{}-{}", draws, format_experiment(experiment), format_key(column),
                     format_clamp(level));
}

Draws draw_column(const ColumnCounts& counts, Experiment experiment, const Column& column,
                  const PosteriorParams& params) {
  Draws draws;
  const std::int64_t largest_n = find_largest_n(counts);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i].count.n == 0) continue;
    const std::string stream = name_stream("posterior", experiment, column, counts[i].level);
    draws.emplace_back(i, draw_cell(counts[i].count, largest_n, stream, params));
  }
  return draws;
}

Draws lift_column(Draws draws, const ColumnCounts& counts, Experiment experiment, const Column& column,
                  std::uint64_t seed) {
  for (auto& [place, values] : draws) {
    const std::string stream = name_stream("posterior-above-half", experiment, column, counts[place].level);
    values = lift_above_half(std::move(values), counts[place].count, stream, seed);
  }
  return draws;
}

// A column's counts with those of one draw after another. Untested levels stay so.
class DrawnColumn {
 public:
  DrawnColumn(std::size_t levels, const Draws& draws) : counts_(levels), draws_(draws) {}

  CountSpan take(std::size_t number) {
    for (const auto& [place, values] : draws_) counts_[place] = values[number];
    return counts_;
  }

 private:
  std::vector<Count> counts_;
  const Draws& draws_;
};

RuleShares get_shares(const std::array<Share, 2>& shares) { return {shares[0].get(), shares[1].get()}; }

RuleShares judge_draws(std::size_t levels, const Draws& seen, const Draws& changed, int draws) {
  std::array<Share, 2> shares;
  DrawnColumn artifact(levels, seen), material(levels, changed);
  for (std::size_t draw = 0; draw < static_cast<std::size_t>(draws); ++draw) {
    const auto artifact_cuts = place_cuts(artifact.take(draw), Experiment::kArtifact),
               material_cuts = place_cuts(material.take(draw), Experiment::kMaterial);
    for (std::size_t r = 0; r < shares.size(); ++r)
      shares[r].add(judge_resample(artifact_cuts[r], material_cuts[r]));
  }
  return get_shares(shares);
}

}  // namespace

EquivalencePosterior find_posterior(const ColumnFinding& column, const PosteriorParams& params) {
  const auto draw = [&](const ColumnCounts& counts, Experiment experiment) {
    return draw_column(counts, experiment, column.column, params);
  };
  const auto lift = [&](const Draws& draws, const ColumnCounts& counts, Experiment experiment) {
    return lift_column(draws, counts, experiment, column.column, params.seed);
  };
  const Draws artifact = draw(column.artifact, Experiment::kArtifact),
              material = draw(column.material, Experiment::kMaterial);
  const std::size_t levels = column.artifact.size();
  return {judge_draws(levels, artifact, material, params.draws),
          judge_draws(levels, lift(artifact, column.artifact, Experiment::kArtifact),
                      lift(material, column.material, Experiment::kMaterial), params.draws)};
}

RuleShares find_free_posterior(const ColumnFinding& column, const PosteriorParams& params) {
  const Draws draws = draw_column(column.artifact, Experiment::kArtifact, column.column, params);
  DrawnColumn artifact(column.artifact.size(), draws);
  std::array<Share, 2> shares;
  for (std::size_t draw = 0; draw < static_cast<std::size_t>(params.draws); ++draw) {
    const auto cuts = place_cuts(artifact.take(draw), Experiment::kArtifact);
    for (std::size_t r = 0; r < shares.size(); ++r) shares[r].add(judge_free(cuts[r]));
  }
  return get_shares(shares);
}

}  // namespace equilux
