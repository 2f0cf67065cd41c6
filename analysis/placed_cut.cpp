// The rules of the study to the letter. C0 is the least clamped level, C10 the most.
#include "analysis/placed_cut.h"

#include <algorithm>
#include <bit>
#include <boost/container/small_vector.hpp>

#include "base/error.h"

namespace equilux {
namespace {

constexpr std::size_t kMostLevels = 32;

// What is as long as the scale takes no memory of the heap.
template <typename T>
using Levels = boost::container::small_vector<T, kClampLevelCount>;

Count add(const Count& a, const Count& b) { return {a.k + b.k, a.n + b.n}; }

// k_a / n_a > k_b / n_b, in integers.
bool is_above(const Count& a, const Count& b) { return a.k * b.n > b.k * a.n; }

// Whether the later, more clamped count breaks the order that the experiment expects.
bool is_violation(const Count& earlier, const Count& later, Experiment experiment) {
  return experiment == Experiment::kArtifact ? is_above(later, earlier) : is_above(earlier, later);
}

// A bit for each level, the least clamped one lowest.
struct Flags {
  std::uint32_t tested = 0, flagged = 0;

  std::uint32_t unflagged() const { return tested & ~flagged; }
};

std::uint8_t lowest(std::uint32_t bits) { return static_cast<std::uint8_t>(std::countr_zero(bits)); }
std::uint8_t beyond_highest(std::uint32_t bits) {
  return static_cast<std::uint8_t>(kMostLevels - static_cast<std::size_t>(std::countl_zero(bits)));
}

Flags find_flags(CountSpan counts, int percent) {
  EQ_CHECK(counts.size() <= kMostLevels, counts.size());
  Flags flags;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    flags.tested |= std::uint32_t{counts[i].n > 0} << i;
    flags.flagged |= std::uint32_t{is_flagged(counts[i], percent)} << i;
  }
  return flags;
}

bool are_monotone(const Flags& flags, Experiment experiment) {
  const bool is_artifact = experiment == Experiment::kArtifact;
  const std::uint32_t first = is_artifact ? flags.flagged : flags.unflagged(),
                      then = is_artifact ? flags.unflagged() : flags.flagged;
  return first == 0 || then == 0 || beyond_highest(first) <= lowest(then);
}

// Untested levels less clamped than the cut count as artifacts, more clamped ones as free.
PlacedCut cut_artifacts(const Flags& flags, std::uint8_t size) {
  if (flags.tested == 0) return {};
  const std::uint8_t first = lowest(flags.tested);
  const std::uint8_t free = flags.flagged ? beyond_highest(flags.flagged) : first;
  const CutStatus status = free == size                           ? CutStatus::kNone
                           : free == first                        ? CutStatus::kCensoredLow
                           : free == beyond_highest(flags.tested) ? CutStatus::kCensoredHigh
                                                                  : CutStatus::kCut;
  return {status, {free, size}, {0, free}};
}

// Unchanged from the first tested level to the last tested one before the first changed; changed from there
// on. An untested level is unchanged only between two unchanged tested ones. Where the first tested level has
// changed, nothing is known of those below it.
PlacedCut cut_material(const Flags& flags, std::uint8_t size) {
  if (flags.tested == 0) return {};
  const std::uint8_t first = lowest(flags.tested);
  if (flags.flagged == 0)
    return {CutStatus::kCensoredHigh, {first, beyond_highest(flags.tested)}, {size, size}};
  const std::uint8_t changed = lowest(flags.flagged);
  if (changed == first) return {first == 0 ? CutStatus::kNone : CutStatus::kCensoredLow, {}, {changed, size}};
  const std::uint32_t before = flags.tested & ((std::uint32_t{1} << changed) - 1);
  return {CutStatus::kCut, {first, beyond_highest(before)}, {changed, size}};
}

PlacedCut cut_flags(const Flags& flags, Experiment experiment, std::size_t size) {
  const auto levels = static_cast<std::uint8_t>(size);
  return experiment == Experiment::kArtifact ? cut_artifacts(flags, levels) : cut_material(flags, levels);
}

PlacedCut cut_pooled(CountSpan counts, Experiment experiment, int percent) {
  Levels<Count> pooled(counts.begin(), counts.end());
  const std::span<Count> all(pooled.data(), pooled.size());
  pool_violators(all, experiment);
  return cut_flags(find_flags(all, percent), experiment, counts.size());
}

}  // namespace

std::string format_rule(Rule rule) { return rule == Rule::kPaper ? "paper" : "isotonic"; }

Rule parse_rule(std::string_view text, std::string_view source, std::string_view place) {
  for (const Rule rule : kRules) {
    if (text == format_rule(rule)) return rule;
  }
  throw InputError(source, place, "paper or isotonic", fmt::format("\"{}\"", text.substr(0, 80)));
}

bool are_proportions_monotone(CountSpan counts, Experiment experiment) {
  const Count* earlier = nullptr;
  for (const Count& count : counts) {
    if (count.n == 0) continue;
    if (earlier && is_violation(*earlier, count, experiment)) return false;
    earlier = &count;
  }
  return true;
}

bool are_flags_monotone(CountSpan counts, Experiment experiment, int percent) {
  return are_monotone(find_flags(counts, percent), experiment);
}

void pool_violators(std::span<Count> counts, Experiment experiment) {
  struct Pool {
    Count sum;
    std::size_t members;  // neighbours among the tested levels
  };
  Levels<Pool> pools;
  for (const Count& count : counts) {
    if (count.n == 0) continue;
    pools.push_back({count, 1});
    while (pools.size() > 1 && is_violation(pools[pools.size() - 2].sum, pools.back().sum, experiment)) {
      const Pool merged = pools.back();
      pools.pop_back();
      pools.back().sum = add(pools.back().sum, merged.sum);
      pools.back().members += merged.members;
    }
  }
  auto pool = pools.begin();
  for (Count& count : counts) {
    if (count.n == 0) continue;
    count = pool->sum;
    if (--pool->members == 0) ++pool;
  }
}

PlacedCut place_cut(CountSpan counts, Experiment experiment, Rule rule, int percent) {
  const Flags flags = find_flags(counts, percent);
  return rule == Rule::kIsotonic && !are_monotone(flags, experiment)
             ? cut_pooled(counts, experiment, percent)
             : cut_flags(flags, experiment, counts.size());
}

std::array<PlacedCut, 2> place_cuts(CountSpan counts, Experiment experiment, int percent) {
  const Flags flags = find_flags(counts, percent);
  const PlacedCut paper = cut_flags(flags, experiment, counts.size());
  return {paper, are_monotone(flags, experiment) ? paper : cut_pooled(counts, experiment, percent)};
}

}  // namespace equilux
