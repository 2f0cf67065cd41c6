// Light that leaves the lights.
#pragma once

#include <optional>

#include "renderer/sampler.h"
#include "renderer/world.h"

namespace equilux {

/// Radiant intensity of a spot in a direction (unit): smooth Hermite fall between the two cones. units: W/sr
Vec3 eval_spot(const SpotLight& spot, Vec3 direction);

struct RectangleSample {
  Vec3 p;
  float pdf_solid_angle = 0;  ///< seen from the point asked for
};

float rectangle_area(const RectangleLight& light);
Vec3 rectangle_normal(const RectangleLight& light);

/// Density over solid angle, seen from x, of an even choice of p on the rectangle. Zero from behind.
float pdf_rectangle(const RectangleLight& light, Vec3 x, Vec3 p);

/// Bound on the rounding error of points on the rectangle: rays start and end this far before it. units: m
float rectangle_epsilon(const RectangleLight& light);

/// Density over solid angle of an even choice of irradiance from the environment, at this cosine.
inline float pdf_environment(float cosine) { return cosine * kInvPi; }

/// True if a direction may meet a light: then direct light takes sampling.
inline bool has_extended_lights(const World& world) {
  return !world.rectangles().empty() || world.environment() != Vec3{};
}

/// A particle as it leaves a light. units of weight: W
struct LightParticle {
  Vec3 origin;
  Vec3 direction;
  Vec3 weight;
};

/// Chooses a light in proportion to a bound on its power, then a direction: even in the cone of a spot, by
/// cosine on a rectangle; of the environment an even direction, and an even point of the disk across the
/// world's sphere. Empty where nothing leaves.
std::optional<LightParticle> sample_emission(const World& world, PathSampler& sampler);

}  // namespace equilux
