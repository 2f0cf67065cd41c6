// Path tracing with next-event estimation: the light that one point reflects to one side.
#pragma once

#include "renderer/sampler.h"
#include "renderer/world.h"

namespace equilux {

/// The measures against noise; each may be left out to measure what it gains. None changes an expectation.
struct PathMeasures {
  bool low_discrepancy = true;  ///< else independent draws
  bool emitter_mis = true;  ///< else lights that have an area, and the environment, by light sampling alone
  bool roulette = true;     ///< else paths end at kLargestSurvival a bounce, whatever their weight
};

/// Radiance reflected at `point` towards v after being emitted directly at it: all lights, no further bounce.
Vec3 estimate_direct(const World& world, const Materials& materials, const SurfacePoint& point, Vec3 v,
                     PathSampler& sampler, const PathMeasures& measures = {});

/// Radiance reflected at `point` towards v; without `with_direct` only what comes by way of other surfaces.
Vec3 estimate_reflected(const World& world, const Materials& materials, const SurfacePoint& point, Vec3 v,
                        bool with_direct, PathSampler& sampler, const PathMeasures& measures = {});

}  // namespace equilux
