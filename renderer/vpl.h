// Virtual point lights by particle tracing.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/world.h"

namespace equilux {

/// A virtual point light with Lambertian emission: radiance towards x is intensity cos / r^2.
struct Vpl {
  Vec3 p;
  float epsilon = 0;  ///< as SurfacePoint::epsilon
  Vec3 ng;            ///< unit, on the side from which the particle came
  Vec3 intensity;     ///< W/sr along ng
  bool operator==(const Vpl&) const = default;
};

/// The VPLs of one scene, geometry, illumination and count for one material of the object. Paths that have
/// not met the object are the same for every material: those VPLs are `shared`.
struct VplSet {
  std::vector<Vpl> shared;
  std::vector<Vpl> own;
  std::int64_t paths = 0;

  std::int64_t count() const { return static_cast<std::int64_t>(shared.size() + own.size()); }
};

/// Number of paths that gives about `target` VPLs: target / (VPLs per path of a pilot of 1e5 paths with
/// another stream and a grey Lambertian object), rounded, at least 1. One number for all materials. errors:
/// InputError if no path leaves a VPL.
std::int64_t find_path_count(const World& world, std::int64_t target, std::uint64_t seed);

/// Traces `paths` particles from the lights; at every surface that they meet they leave a VPL. All are kept.
VplSet trace_vpls(const World& world, const Materials& materials, std::int64_t paths, std::uint64_t seed,
                  const std::string& stream_name);

}  // namespace equilux
