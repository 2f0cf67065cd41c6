// How many paths each pixel of a reference takes, from a pilot that is then thrown away.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "renderer/family.h"
#include "renderer/tone.h"

namespace equilux {

/// No pixel takes more than this, whatever the target asks. units: paths of one layer
inline constexpr int kMostPathsAPixel = 1 << 20;

class PixelKinds;

/// A family as its pilot shows it through its own tone curve: means smoothed over near pixels of a kind, the
/// object, its silhouettes, the room.
class DisplayPilot {
 public:
  /// `layers` add up. `coverage` must outlive it.
  DisplayPilot(const std::vector<const HdrImage*>& layers, const HdrImage& coverage, const ToneMapping& tone);

  const ToneCurve& tone() const { return tone_; }
  const HdrImage& coverage() const { return coverage_; }

  /// Displayed standard error of a layer for one path a batch and position, from smoothed variances. shape:
  /// height x width. units: steps of 255
  std::vector<double> find_errors(const TracedLayer& layer, const PathMap& map) const;

  /// Displayed size of a small change of a pixel, the largest channel, as if the curve were straight. units:
  /// steps of 255
  double find_size(std::size_t pixel, const std::array<double, 3>& change) const;

  /// Means over near pixels of a kind. shape: channel x height x width
  std::array<std::vector<double>, 3> smooth(const HdrImage& layer) const;

 private:
  const HdrImage& coverage_;
  std::shared_ptr<const PixelKinds> kinds_;
  ToneCurve tone_;
  std::array<std::vector<double>, 3> mean_;  // of each channel
};

/// Of a layer whose pilot saw some pixels of the object alone: the others become what near ones of their kind
/// are on average, within so many pixels, or further away where there are none.
void fill_between(TracedLayer& layer, const PathMap& seen, const HdrImage& coverage, int radius);

/// The same of the room's pixels.
void fill_room_between(TracedLayer& layer, const PathMap& seen, const HdrImage& coverage, int radius);

/// A displayed error for one path a batch and position, beside one that no path lowers.
struct PixelError {
  double of_paths = 0, given = 0;
};

/// What the worst pixels are foreseen to err by, over the 99th percentile that is asked for: the spread that
/// 16 batches show errs by a sixth, which lifts the percentile of what is measured above that of what is
/// meant. Beside VPL sets, whose error varies little, less is needed.
inline constexpr double kPercentileOfPaths = 0.4, kPercentileBesideSets = 0.6;

/// Paths in each batch and at each position for errors of the object's pixels, see allot_paths.
std::vector<double> foresee_paths(const std::vector<PixelError>& errors, int positions,
                                  const NoiseTarget& target, double percentile = kPercentileOfPaths);

/// Displayed errors of a family's layers for one path a batch and position, and of what takes no paths, which
/// may be empty. shape: height x width. units: steps of 255
struct LayerErrors {
  std::vector<double> background, direct, indirect, given = {};
};

/// The fewest paths that are foreseen to meet the target in display steps. The mean of S / sqrt(N), S being a
/// pixel's standard error for one path a batch as displayed, is least for a given sum of N where N grows as
/// S^(2/3); the 99th percentile sets a lower bound that grows as S^2; a pixel's layers share N in
/// proportion to their own errors. A given error is met in quadrature, and N then rounded up and down on the
/// object, else up. A target out of reach stops at kMostPathsAPixel.
PathMaps allot_paths(const LayerErrors& errors, const HdrImage& coverage, int positions,
                     const NoiseTarget& target);

/// The same from a pilot: since it is independent of the paths that follow, these are unbiased however wrong
/// it is.
PathMaps allot_paths(const TracedLayers& pilot, const PathMaps& pilot_maps, const HdrImage& coverage,
                     int positions, const ToneMapping& tone, const NoiseTarget& target);

}  // namespace equilux
