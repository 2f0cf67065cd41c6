// Two cuts of a draw to its verdict.
#include "analysis/resampled.h"

#include <algorithm>

namespace equilux {

bool is_any_equivalent(const PlacedCut& artifact, const PlacedCut& material) {
  const Places &free = artifact.same, &unchanged = material.same;
  return std::max(free.begin, unchanged.begin) < std::min(free.end, unchanged.end);
}

Resampled judge_free(const PlacedCut& artifact) {
  if (artifact.status == CutStatus::kUntested) return Resampled::kUntested;
  return artifact.status == CutStatus::kNone ? Resampled::kNone : Resampled::kExists;
}

Resampled judge_resample(const PlacedCut& artifact, const PlacedCut& material) {
  const Resampled free = judge_free(artifact);
  if (free != Resampled::kExists) return free;
  if (material.status == CutStatus::kUntested) return Resampled::kUntested;
  return is_any_equivalent(artifact, material) ? Resampled::kExists : Resampled::kNone;
}

}  // namespace equilux
