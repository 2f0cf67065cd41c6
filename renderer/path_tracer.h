// Path tracing with next-event estimation: the light that one point reflects to one side.
#pragma once

#include <span>

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

/// All light reflected at a point for several materials of the objects at once: each sum is that of
/// estimate_reflected with that material, bit for bit. A path is walked once until it meets an object.
/// shape: sums as materials
void estimate_reflected_by_material(const World& world, std::span<const Materials> materials,
                                    const SurfacePoint& point, Vec3 v, PathSampler& sampler,
                                    const PathMeasures& measures, std::span<Vec3> sums);

/// What VPLs lack of the light that a path brings to a point.
struct ReturnedLight {
  Vec3 clamped;              ///< what they carry, of which a clamp c takes the share 1 - c / peak
  Vec3 missing;              ///< what they do not carry: with Lambertian emission what gloss sends on
  float peak_per_m2 = 0;     ///< M / r^2 of the path's first step; 0 where it ended there for every clamp
  bool meets_gloss = false;  ///< VPLs where it arrived lack what gloss sends on
  Vec3 response;             ///< to a Lambertian VPL of 1 W/sr where it arrived. units: 1/m^2

  Vec3 at(double clamp_per_m2) const;
  /// Whether the path goes on beyond its first step for that clamp alone.
  bool goes_on(double clamp_per_m2) const { return meets_gloss || double{peak_per_m2} > clamp_per_m2; }
};

struct ReturnParams {
  double least_clamp_per_m2 = 0;  ///< of those that it is asked for; infinite for none
  bool with_missing = true;       ///< VPLs emit by the diffuse part, and some surface is glossy

  /// By one of them.
  bool is_clamped(float peak_per_m2) const { return double{peak_per_m2} > least_clamp_per_m2; }
};

bool has_gloss(const Materials& materials);

/// Light that a clamp takes from VPLs at `point`, and what their emission lacks: its expectation at c is the
/// indirect light less the VPL sum clamped at c, for all c at once. Its first ray ends where nothing is
/// clamped, unless something is missing. source: Kollig and Keller, "Illumination in the presence of weak
/// singularities", MCQMC 2004, for the clamp of shade_all_vpls.
ReturnedLight estimate_returned(const World& world, const Materials& materials, const SurfacePoint& point,
                                Vec3 v, const ReturnParams& params, PathSampler& sampler,
                                const PathMeasures& measures = {});

/// The same at a point of the room, for several materials of the objects at once, each as by itself, bit for
/// bit. shape: lights as materials
void estimate_returned_by_material(const World& world, std::span<const Materials> materials,
                                   const SurfacePoint& point, Vec3 v, const ReturnParams& params,
                                   PathSampler& sampler, const PathMeasures& measures,
                                   std::span<ReturnedLight> lights);

}  // namespace equilux
