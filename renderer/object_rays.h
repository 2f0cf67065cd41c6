// Rays from points of the object: what light reaches them, what they see of the object itself.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/primary.h"

namespace equilux {

struct AreaPoint {
  Vec3 p;
  Vec3 ng;            ///< outwards, unit
  float epsilon = 0;  ///< as of a SurfacePoint. units: m
};

/// Points even by area, one in each of `count` shares of it. A mesh that is inside out, holes closed as for
/// Bumpiness, counts as turned back.
std::vector<AreaPoint> sample_area(const TriangleMesh& mesh, int count, std::uint64_t seed);

/// How many of the points each light reaches that is on. The lights stand in this order: spots, rectangles,
/// environment.
struct DirectLight {
  std::int64_t points = 0;
  std::vector<std::int64_t> lit;  ///< points, for each light
  std::int64_t pair_count() const { return points * static_cast<std::int64_t>(lit.size()); }
  std::int64_t lit_count() const;
  std::size_t brightest() const;  ///< index of the light that reaches most points; lit must not be empty
};

/// Proves by shadow rays which lights reach the object: a spot by the ray to its place, a rectangle by rays
/// to kRaysPerPoint points of it, the environment by as many even directions; one that arrives will do. A
/// point is looked at from whichever side the light is on: a sheet has two, a closed mesh blocks its inside
/// itself.
inline constexpr int kRaysPerPoint = 16;
DirectLight find_direct_light(const World& world, const std::vector<AreaPoint>& points, std::uint64_t seed);

struct Share {
  std::int64_t count = 0, total = 0;
};

/// Share of rays, spread by cosine about the points' normals, that meet the object first: kRaysPerPoint each.
Share find_self_occlusion(const World& world, const std::vector<AreaPoint>& points, std::uint64_t seed);

/// The mirror direction of a position at which the camera sees the object, about its shading normal.
struct MirrorRay {
  float cosine = 0;     ///< of v and of the mirror direction with ns
  float length_m = -1;  ///< to what it meets, infinity if nothing; below 0 if it goes into the surface by ng
  bool meets_object = false;
};

std::vector<MirrorRay> trace_mirror_rays(const World& world, const Primary& primary);

/// Share of those that meet the object; what goes into the surface does not.
Share find_self_mirroring(const std::vector<MirrorRay>& rays);

}  // namespace equilux
