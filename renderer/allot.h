// How many paths each pixel of a reference takes, from a pilot that is then thrown away.
#pragma once

#include "renderer/family.h"
#include "renderer/tone.h"

namespace equilux {

/// No pixel takes more than this, whatever the target asks. units: paths of one layer
inline constexpr int kMostPathsAPixel = 1 << 20;

/// The fewest paths that are foreseen to meet the target in display steps. The mean of S / sqrt(N), S being a
/// pixel's standard error for one path a batch as displayed, is least for a given sum of N where N grows as
/// S^(2/3); the 99th percentile sets a lower bound that grows as S^2; a pixel's layers share N in
/// proportion to their own errors. Since the pilot is independent of the paths that follow, these are
/// unbiased however wrong it is. The pilot's variances are smoothed over neighbours. The tone curve is the
/// pilot's own. A target out of reach stops at kMostPathsAPixel.
PathMaps allot_paths(const TracedLayers& pilot, const PathMaps& pilot_maps, const HdrImage& coverage,
                     int positions, Exposure exposure, double tone_key, const NoiseTarget& target);

}  // namespace equilux
