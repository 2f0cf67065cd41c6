// Places of cuts to levels, states and words.
#include "analysis/thresholds.h"

#include <algorithm>

#include "base/error.h"

namespace equilux {
namespace {

std::vector<Count> take_counts(const ColumnCounts& column) {
  std::vector<Count> counts;
  for (const LevelCount& level : column) counts.push_back(level.count);
  return counts;
}

void fill_states(std::vector<LevelState>& states, const Places& places, LevelState state) {
  for (std::size_t i = places.begin; i < places.end; ++i) states[i] = state;
}

// An artifact threshold is the first level that is the same, a material threshold the last.
Threshold describe(const PlacedCut& cut, Experiment experiment, const ColumnCounts& counts) {
  Threshold threshold;
  threshold.status = cut.status;
  threshold.states.assign(counts.size(), LevelState::kUnknown);
  fill_states(threshold.states, cut.same, LevelState::kSame);
  fill_states(threshold.states, cut.different, LevelState::kDifferent);
  const bool is_artifact = experiment == Experiment::kArtifact;
  if (!cut.same.is_empty())
    threshold.cut = counts[is_artifact ? cut.same.begin : cut.same.end - std::size_t{1}].level;
  if (!is_artifact && cut.same.is_empty() && cut.status == CutStatus::kCensoredLow)
    threshold.below = counts[cut.different.begin].level;
  return threshold;
}

}  // namespace

bool is_at_scale_end(const Threshold& threshold, Experiment experiment, const ColumnCounts& counts) {
  if (experiment == Experiment::kArtifact)
    return threshold.status == CutStatus::kCensoredLow && threshold.cut == counts.front().level;
  return threshold.status == CutStatus::kCensoredHigh && threshold.cut == counts.back().level;
}

std::string format_status(CutStatus status) {
  switch (status) {
    case CutStatus::kCut:
      return "cut";
    case CutStatus::kCensoredLow:
      return "censored_low";
    case CutStatus::kCensoredHigh:
      return "censored_high";
    case CutStatus::kNone:
      return "none";
    case CutStatus::kUntested:
      break;
  }
  return "untested";
}

std::string describe_status(const Threshold& threshold, Experiment experiment, const ColumnCounts& counts) {
  return is_at_scale_end(threshold, experiment, counts) ? "end of the scale"
                                                        : format_status(threshold.status);
}

std::string format_cut(const Threshold& threshold) {
  if (threshold.cut) return format_clamp(*threshold.cut);
  return threshold.below ? "< " + format_clamp(*threshold.below) : "-";
}

ColumnCounts pool_adjacent_violators(const ColumnCounts& counts, Experiment experiment) {
  std::vector<Count> pooled = take_counts(counts);
  pool_violators(pooled, experiment);
  ColumnCounts column = counts;
  for (std::size_t i = 0; i < column.size(); ++i) column[i].count = pooled[i];
  return column;
}

Threshold find_cut(const ColumnCounts& counts, Experiment experiment, Rule rule, int percent) {
  return describe(place_cut(take_counts(counts), experiment, rule, percent), experiment, counts);
}

Threshold find_threshold(const ColumnCounts& counts, Experiment experiment, Rule rule, int percent) {
  EQ_CHECK(std::is_sorted(counts.begin(), counts.end(),
                          [](const auto& a, const auto& b) { return a.level < b.level; }));
  Threshold threshold = find_cut(counts, experiment, rule, percent);
  const std::vector<Count> bare = take_counts(counts);
  threshold.monotone = are_proportions_monotone(bare, experiment);
  threshold.flags_monotone = are_flags_monotone(bare, experiment, percent);
  return threshold;
}

}  // namespace equilux
