// Light of VPLs at points of the object: the plain sum, all clamp levels and materials in one pass.
// shade_lightcut has the same inputs and outputs.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "renderer/primary.h"
#include "renderer/vpl.h"

namespace equilux {

/// A point that the camera sees.
struct ShadingPoint {
  std::uint32_t pixel = 0;
  SurfacePoint surface;
  Vec3 v;
};

/// Points of an object in the order of a Morton curve over pixels, so that neighbours are near in space.
std::vector<ShadingPoint> find_shading_points(const Primary& primary, std::int32_t object = 0);

/// Points of the room in pixels that no object covers any of, in the same order: a list for each material.
std::vector<std::vector<ShadingPoint>> find_room_points(const Primary& primary, const HdrImage& coverage);

/// Radiance towards v. shape: material x level x point, point fastest.
struct ShadedPoints {
  std::size_t levels = 0;
  std::size_t points = 0;
  std::vector<Vec3> radiance;
  std::uint64_t coincident = 0;  ///< pairs left out because the VPL lies on the point, where r is 0
  std::uint64_t rays = 0;        ///< shadow rays of the plain sum

  std::size_t index(std::size_t material, std::size_t level, std::size_t point) const {
    return (material * levels + level) * points + point;
  }
};

/// Shadow rays for a part of the pairs only. Sixteen points and a VPL whose radiance, unclamped and
/// unshadowed, is under each material's threshold at all of them take their rays with a probability in
/// proportion to the nearest miss, and count for as much more: every expectation stays. A threshold of 0:
/// all that bring light. Empty: all rays.
struct ShadowRoulette {
  std::vector<double> thresholds;  ///< of each material, for the largest channel. units: W/(m^2 sr)
  std::uint64_t seed = 0;
};

/// L(x) = sum_k min{c, M_k / r_k^2} cos_k I_k V_k, M = f cl at x, for every clamp c in `clamps_per_m2` and
/// every material of the object. One shadow ray serves them all. With colour the clamp acts on M's largest
/// channel and scales all three alike. I_k is the emission towards x: the diffuse part's, and the glossy
/// part's where the VPL has one. `progress` is told point-VPL pairs done, from any thread. errors: InputError
/// if radiance leaves the range of float. source: Krivanek, Ferwerda, Bala 2010, section 3.
ShadedPoints shade_all_vpls(const World& world, const std::vector<ShadingPoint>& points, const VplList& vpls,
                            const std::vector<Material>& materials, const std::vector<double>& clamps_per_m2,
                            const std::function<void(double)>& progress, const ShadowRoulette& roulette = {});

/// An image's radiance at the points' pixels, as that of one material and level.
ShadedPoints look_up(const HdrImage& image, const std::vector<ShadingPoint>& points);

/// errors: InputError that counts the points whose radiance is not finite, if any: none is ever set to zero.
void check_finite(const ShadedPoints& shaded);

/// Adds the points of one material and level to a layer: each counts as its subpixel position's share.
void add_to_layer(const ShadedPoints& shaded, std::size_t material, std::size_t level,
                  const std::vector<ShadingPoint>& points, int positions, HdrImage& layer);

}  // namespace equilux
