// Path tracing with next-event estimation: the light that one point reflects to one side.
#pragma once

#include <array>

#include "base/random.h"
#include "renderer/world.h"

namespace equilux {

/// The measures against noise; each may be left out to measure what it gains. None changes an expectation.
struct PathMeasures {
  bool low_discrepancy = true;  ///< else independent draws
  bool emitter_mis = true;  ///< else lights that have an area, and the environment, by light sampling alone
  bool roulette = true;     ///< else paths end at kLargestSurvival a bounce, whatever their weight
};

/// A source of numbers in [0, 1): the first of a path from a lattice with a random shift, the rest from a
/// stream. Paths of one batch share the shift, so each batch is one randomisation of a quasi-Monte Carlo
/// rule.
class PathSampler {
 public:
  explicit PathSampler(const RandomStream& stream, bool low_discrepancy = true);
  /// Begins the next path of the batch.
  void next_path();
  float next();

 private:
  static constexpr std::size_t kDimensions = 9;
  RandomStream stream_;
  std::array<double, kDimensions> point_{};
  std::size_t dimension_ = 0;
  bool low_discrepancy_;
};

/// Radiance reflected at `point` towards v after being emitted directly at it: all lights, no further bounce.
Vec3 estimate_direct(const World& world, const Materials& materials, const SurfacePoint& point, Vec3 v,
                     PathSampler& sampler, const PathMeasures& measures = {});

/// Radiance reflected at `point` towards v; without `with_direct` only what comes by way of other surfaces.
Vec3 estimate_reflected(const World& world, const Materials& materials, const SurfacePoint& point, Vec3 v,
                        bool with_direct, PathSampler& sampler, const PathMeasures& measures = {});

}  // namespace equilux
