// Where a rendering is visually equivalent to the reference: artifact-free and of unchanged material.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "analysis/thresholds.h"
#include "stimuli/selection.h"

namespace equilux {

/// What a graph shows of a clamp level.
enum class Region {
  kArtifact,    ///< artifacts seen, or less clamped than a level where they were (pink)
  kChanged,     ///< the material looked different, or more clamped than a level where it did (red)
  kBoth,        ///< artifacts and a changed material
  kEquivalent,  ///< artifact-free and unchanged (green)
  kUntested     ///< not shown to be either
};

/// Whether equivalence exists (EE) at a VPL count.
enum class Verdict { kExists, kNone, kUntested };

/// What one rule makes of a column.
struct RuleFinding {
  Threshold artifact;
  Threshold material;
  std::vector<Region> regions;  ///< shape: one for each clamp level of the study
  std::vector<int> green;       ///< equivalent levels
  std::vector<int> supported;   ///< green levels at which both experiments were below the cut at 95 %
  std::vector<int> untested;    ///< levels that this rule keeps for the material experiment, without answers
  Verdict verdict = Verdict::kUntested;
};

struct ColumnFinding {
  Column column;
  ColumnCounts artifact;
  ColumnCounts material;
  bool dropped = false;                ///< the selection keeps no level of it
  std::array<RuleFinding, 2> by_rule;  ///< shape: in order of kRules

  const RuleFinding& under(Rule rule) const { return by_rule[static_cast<std::size_t>(rule)]; }
};

/// Findings in the order of the study's columns. `selection` says which columns were dropped; null before
/// pruning. `percent` correct is where a cell is flagged.
std::vector<ColumnFinding> find_equivalence(const Study& study, const Tally& artifact, const Tally& material,
                                            const Selection* selection, int percent = kFlagPercent);

/// Whether every experiment of which a region speaks was asked at place i of the column; where not, the rule
/// infers the region from other levels.
bool is_observed(const ColumnFinding& column, Region region, std::size_t i);

std::string format_region(Region region);

}  // namespace equilux
