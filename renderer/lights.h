// Light that leaves the lights.
#pragma once

#include <optional>

#include "base/random.h"
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

/// A particle as it leaves a light. units of weight: W
struct Emission {
  Vec3 origin;
  Vec3 direction;
  Vec3 weight;
};

/// Chooses a light in proportion to a bound on its power, then a direction: even in the cone of a spot, by
/// cosine on a rectangle. Empty where nothing leaves.
std::optional<Emission> sample_emission(const World& world, RandomStream& random);

}  // namespace equilux
