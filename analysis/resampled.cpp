// Two thresholds of a draw to its verdict.
#include "analysis/resampled.h"

namespace equilux {

bool is_any_equivalent(const Threshold& artifact, const Threshold& material) {
  for (std::size_t i = 0; i < artifact.states.size(); ++i) {
    if (artifact.states[i] == LevelState::kSame && material.states[i] == LevelState::kSame) return true;
  }
  return false;
}

Resampled judge_free(const Threshold& artifact) {
  if (artifact.status == CutStatus::kUntested) return Resampled::kUntested;
  return artifact.status == CutStatus::kNone ? Resampled::kNone : Resampled::kExists;
}

Resampled judge_resample(const Threshold& artifact, const Threshold& material) {
  const Resampled free = judge_free(artifact);
  if (free != Resampled::kExists) return free;
  if (material.status == CutStatus::kUntested) return Resampled::kUntested;
  return is_any_equivalent(artifact, material) ? Resampled::kExists : Resampled::kNone;
}

}  // namespace equilux
