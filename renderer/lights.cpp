// Emission of spots, rectangles and the environment.
#include "renderer/lights.h"

#include "base/error.h"

namespace equilux {
namespace {

float spot_power_bound(const SpotLight& spot) {
  return luminance(spot.intensity_w_per_sr) * 2 * kPi * (1 - spot.cos_outer);
}

float rectangle_power(const RectangleLight& light) {
  return luminance(light.radiance_w_per_m2_sr) * kPi * rectangle_area(light);
}

LightParticle sample_spot(const SpotLight& spot, PathSampler& sampler) {
  const float cos_t = 1 - sampler.next() * (1 - spot.cos_outer);
  const float sin_t = std::sqrt(std::max(0.0f, 1 - cos_t * cos_t)), phi = 2 * kPi * sampler.next();
  const Vec3 direction =
      Frame(spot.direction).to_world({sin_t * std::cos(phi), sin_t * std::sin(phi), cos_t});
  return {spot.position, direction, eval_spot(spot, direction) * (2 * kPi * (1 - spot.cos_outer))};
}

LightParticle sample_rectangle(const RectangleLight& light, PathSampler& sampler) {
  const float a = sampler.next(), b = sampler.next();
  const Vec3 p = light.corner + light.u * a + light.v * b;
  const Vec3 normal = rectangle_normal(light);
  const float u1 = sampler.next(), u2 = sampler.next();
  const Vec3 direction = Frame(normal).to_world(sample_cosine(u1, u2));
  return {p + normal * rectangle_epsilon(light), direction,
          light.radiance_w_per_m2_sr * (kPi * rectangle_area(light))};
}

// Light from all directions that enters the world's sphere: radiance x 4 pi x the area of its disk.
float environment_power(const World& world) {
  return luminance(world.environment()) * 4 * kPi * kPi * world.radius() * world.radius();
}

LightParticle sample_environment(const World& world, PathSampler& sampler) {
  const float z = 1 - 2 * sampler.next(), phi = 2 * kPi * sampler.next();
  const float r = std::sqrt(std::max(0.0f, 1 - z * z));
  const Vec3 direction{r * std::cos(phi), r * std::sin(phi), z};
  const float across = world.radius() * std::sqrt(sampler.next()), turn = 2 * kPi * sampler.next();
  const Vec3 offset =
      Frame(direction).to_world({across * std::cos(turn), across * std::sin(turn), -world.radius()});
  return {world.center() + offset, direction,
          world.environment() * (4 * kPi * kPi * world.radius() * world.radius())};
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

float rectangle_epsilon(const RectangleLight& light) {
  const Vec3 c = light.corner;
  return rounding_bound(std::max({std::abs(c.x), std::abs(c.y), std::abs(c.z)}) + length(light.u) +
                        length(light.v));
}

Vec3 rectangle_normal(const RectangleLight& light) { return normalize(cross(light.u, light.v)); }

float pdf_rectangle(const RectangleLight& light, Vec3 x, Vec3 p) {
  const Vec3 d = x - p;
  const float r2 = dot(d, d);
  const float cosine = dot(rectangle_normal(light), d) / std::sqrt(r2);
  return cosine > 0 ? r2 / (cosine * rectangle_area(light)) : 0;
}

std::optional<LightParticle> sample_emission(const World& world, PathSampler& sampler) {
  float total = environment_power(world);
  for (const auto& spot : world.spots()) total += spot_power_bound(spot);
  for (const auto& light : world.rectangles()) total += rectangle_power(light);
  if (!(total > 0)) return std::nullopt;
  float left = sampler.next() * total;
  std::optional<LightParticle> emission;
  // Takes this light if the draw falls on it.
  const auto offer = [&](float power, const auto& sample) {
    if (!emission && power > 0 && left < power) {
      emission = sample();
      emission->weight = emission->weight * (total / power);
    }
    left -= power;
  };
  for (const auto& spot : world.spots())
    offer(spot_power_bound(spot), [&] { return sample_spot(spot, sampler); });
  for (const auto& light : world.rectangles())
    offer(rectangle_power(light), [&] { return sample_rectangle(light, sampler); });
  offer(environment_power(world), [&] { return sample_environment(world, sampler); });
  return emission;  // empty by rounding at the very end of the range
}

}  // namespace equilux
