// Emission of spots and rectangles.
#include "renderer/lights.h"

#include <limits>

#include "base/error.h"

namespace equilux {
namespace {

float spot_power_bound(const SpotLight& spot) {
  return luminance(spot.intensity_w_per_sr) * 2 * kPi * (1 - spot.cos_outer);
}

float rectangle_power(const RectangleLight& light) {
  return luminance(light.radiance_w_per_m2_sr) * kPi * rectangle_area(light);
}

Emission sample_spot(const SpotLight& spot, RandomStream& random) {
  const float cos_t = 1 - random.next_float() * (1 - spot.cos_outer);
  const float sin_t = std::sqrt(std::max(0.0f, 1 - cos_t * cos_t)), phi = 2 * kPi * random.next_float();
  const Vec3 direction =
      Frame(spot.direction).to_world({sin_t * std::cos(phi), sin_t * std::sin(phi), cos_t});
  return {spot.position, direction, eval_spot(spot, direction) * (2 * kPi * (1 - spot.cos_outer))};
}

Emission sample_rectangle(const RectangleLight& light, RandomStream& random) {
  const float a = random.next_float(), b = random.next_float();
  const Vec3 p = light.corner + light.u * a + light.v * b;
  const Vec3 normal = rectangle_normal(light);
  const float u1 = random.next_float(), u2 = random.next_float();
  const Vec3 direction = Frame(normal).to_world(sample_cosine(u1, u2));
  const float largest =
      std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) + length(light.u) + length(light.v);
  return {p + normal * (16 * std::numeric_limits<float>::epsilon() * largest), direction,
          light.radiance_w_per_m2_sr * (kPi * rectangle_area(light))};
}

}  // namespace

Vec3 eval_spot(const SpotLight& spot, Vec3 direction) {
  const float cosine = dot(spot.direction, direction);
  if (cosine <= spot.cos_outer) return {};
  if (cosine >= spot.cos_inner) return spot.intensity_w_per_sr;
  const float t = (cosine - spot.cos_outer) / (spot.cos_inner - spot.cos_outer);
  return spot.intensity_w_per_sr * (t * t * (3 - 2 * t));
}

float rectangle_area(const RectangleLight& light) { return length(cross(light.u, light.v)); }

Vec3 rectangle_normal(const RectangleLight& light) { return normalize(cross(light.u, light.v)); }

float pdf_rectangle(const RectangleLight& light, Vec3 x, Vec3 p) {
  const Vec3 d = x - p;
  const float r2 = dot(d, d);
  const float cosine = dot(rectangle_normal(light), d) / std::sqrt(r2);
  return cosine > 0 ? r2 / (cosine * rectangle_area(light)) : 0;
}

std::optional<Emission> sample_emission(const World& world, RandomStream& random) {
  float total = 0;
  for (const auto& spot : world.spots()) total += spot_power_bound(spot);
  for (const auto& light : world.rectangles()) total += rectangle_power(light);
  if (!(total > 0)) return std::nullopt;
  float left = random.next_float() * total;
  const auto weighted = [&](Emission emission, float power) {
    emission.weight = emission.weight * (total / power);
    return emission;
  };
  for (const auto& spot : world.spots()) {
    const float power = spot_power_bound(spot);
    if (power > 0 && left < power) return weighted(sample_spot(spot, random), power);
    left -= power;
  }
  for (const auto& light : world.rectangles()) {
    const float power = rectangle_power(light);
    if (power > 0 && left < power) return weighted(sample_rectangle(light, random), power);
    left -= power;
  }
  return std::nullopt;  // rounding at the very end of the range
}

}  // namespace equilux
