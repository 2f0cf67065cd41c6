// From the counts of a column to its cut, by a named rule.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/placed_cut.h"

namespace equilux {

/// What an experiment says of a clamp level.
enum class LevelState {
  kSame,       ///< free of artifacts, or unchanged material
  kDifferent,  ///< artifacts, or changed material
  kUnknown     ///< not tested, and nothing follows from the tested levels
};

struct Threshold {
  /// Artifact: the least clamped level from which on the column is artifact-free. Material: the most clamped
  /// level up to which it is unchanged.
  std::optional<int> cut;
  /// The level that a material threshold lies below, where it is censored low: there is no cut then.
  std::optional<int> below;
  CutStatus status = CutStatus::kUntested;
  bool monotone = true;            ///< the proportions of tested levels, as counted
  bool flags_monotone = true;      ///< their flags: where false the rule decides
  std::vector<LevelState> states;  ///< shape: one for each level of the column
};

/// True iff a censored threshold is at an end of the scale, so that there is no level where it could lie
/// beyond: artifacts at no level from the least clamped one on, or no change up to the most clamped one.
bool is_at_scale_end(const Threshold& threshold, Experiment experiment, const ColumnCounts& counts);

std::string format_status(CutStatus status);

/// The same for a reader: "end of the scale" where a censored threshold is at one.
std::string describe_status(const Threshold& threshold, Experiment experiment, const ColumnCounts& counts);

/// "C4"; "< C7" of a material threshold that lies below all tested levels; "-" where there is none.
std::string format_cut(const Threshold& threshold);

/// Proportions made monotone: each tested level gets the summed counts of its block. Artifacts fall with
/// clamp, material changes rise. Untested levels stay untested. source: Barlow et al. 1972, algorithm PAVA.
ColumnCounts pool_adjacent_violators(const ColumnCounts& counts, Experiment experiment);

/// `percent` correct is where a cell, or under `isotonic` a block, is flagged.
Threshold find_threshold(const ColumnCounts& counts, Experiment experiment, Rule rule,
                         int percent = kFlagPercent);

/// The same without looking whether the column is monotone, which draws and resamples need not know.
Threshold find_cut(const ColumnCounts& counts, Experiment experiment, Rule rule, int percent = kFlagPercent);

}  // namespace equilux
