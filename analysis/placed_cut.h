// From the counts of a column to the place of its cut: what draws and resamples judge millions of times.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "analysis/tally.h"
#include "protocols/experiment.h"

namespace equilux {

/// What to do when a column is not monotone. paper: the artifact cut is at the most clamped flagged level,
/// the material region opens at the first changed one. isotonic: proportions are first made monotone by
/// pooling adjacent violators, weighted by n; then the same. Both agree where the flags are monotone.
enum class Rule { kPaper, kIsotonic };

inline constexpr Rule kRules[] = {Rule::kPaper, Rule::kIsotonic};

std::string format_rule(Rule rule);
Rule parse_rule(std::string_view text, std::string_view source, std::string_view place = "");

enum class CutStatus : std::uint8_t {
  kCut,          ///< found between two tested levels
  kCensoredLow,  ///< no tested level has artifacts: the threshold is at the first of them or less clamped; or
                 ///< all have changed: it is less clamped than the first of them
  kCensoredHigh,  ///< artifacts still at the most clamped tested level: it lies beyond; or no change
                  ///< there: it is there or more clamped
  kNone,          ///< artifacts at the study's most clamped level, or a change at its least clamped one
  kUntested       ///< no answers
};

/// Levels from `begin` to before `end`, by their place in the column.
struct Places {
  std::uint8_t begin = 0;
  std::uint8_t end = 0;
  bool is_empty() const { return begin >= end; }
  bool operator==(const Places&) const = default;
};

/// A column under a rule. What is in neither range is unknown.
struct PlacedCut {
  CutStatus status = CutStatus::kUntested;
  Places same;       ///< free of artifacts, or unchanged material
  Places different;  ///< artifacts, or changed material
  bool operator==(const PlacedCut&) const = default;
};

/// shape: one for each clamp level of the study, from least to most clamped, at most 32; n = 0 where
/// untested.
using CountSpan = std::span<const Count>;

/// True iff the proportions of tested levels fall with clamp (artifact), or rise (material).
bool are_proportions_monotone(CountSpan counts, Experiment experiment);

/// The same of the flags: both rules cut alike then, since pooling neighbours of one flag gives that flag.
bool are_flags_monotone(CountSpan counts, Experiment experiment, int percent);

/// Gives each tested level the summed counts of its block. source: Barlow et al. 1972, algorithm PAVA.
void pool_violators(std::span<Count> counts, Experiment experiment);

PlacedCut place_cut(CountSpan counts, Experiment experiment, Rule rule, int percent = kFlagPercent);

/// Under both rules, in order of kRules.
std::array<PlacedCut, 2> place_cuts(CountSpan counts, Experiment experiment, int percent = kFlagPercent);

}  // namespace equilux
