// The path tracer.
#include "renderer/path_tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "renderer/lights.h"

namespace equilux {
namespace {

// a^2 / (a^2 + b^2), in a form in which large densities do not overflow. source: Veach, 1997, section 9.2.4.
float power_heuristic(float a, float b) {
  const float ratio = b / a;
  return 1 / (1 + ratio * ratio);
}

// A surface seen from v, in its shading frame.
struct Shading {
  const Material& material;
  Frame frame;
  Vec3 v;
  Shading(const Materials& materials, const SurfacePoint& point, Vec3 view)
      : material(materials[point.material]), frame(point.ns), v(frame.to_local(view)) {}
};

// What the diffuse and the glossy part of a surface reflect.
struct Parts {
  Vec3 diffuse, glossy;
  bool operator==(const Parts&) const = default;
};
Parts operator*(const Parts& a, Vec3 b) { return {a.diffuse * b, a.glossy * b}; }
Parts operator*(const Parts& a, float b) { return {a.diffuse * b, a.glossy * b}; }
Parts operator/(const Parts& a, float b) { return {a.diffuse / b, a.glossy / b}; }
Parts& operator+=(Parts& a, const Parts& b) {
  a.diffuse += b.diffuse;
  a.glossy += b.glossy;
  return a;
}

// f cl of light from direction l (local), as a whole (Vec3) or in Parts.
template <typename Light>
Light eval_cosine_brdf(const Shading& shading, Vec3 l) {
  const float cosine = std::max(0.0f, l.z);
  if constexpr (std::is_same_v<Light, Vec3>) {
    return eval_brdf(shading.material, shading.v, l) * cosine;
  } else {
    Parts parts{shading.material.rho_d * (kInvPi * cosine), {}};
    if (shading.material.glossy_share > 0)
      parts.glossy = shading.material.rho_s * (eval_glossy(shading.material, shading.v, l) * cosine);
    return parts;
  }
}

// The same of a direction in the world, gated by both normals.
template <typename Light>
Light eval_scatter(const Shading& shading, const SurfacePoint& point, Vec3 l) {
  if (!(dot(point.ng, l) > 0)) return {};
  return eval_cosine_brdf<Light>(shading, shading.frame.to_local(l));
}

template <typename Light>
Light estimate_spot(const World& world, const Shading& shading, const SurfacePoint& point,
                    const SpotLight& spot) {
  const Vec3 d = spot.position - point.p;
  const float r2 = dot(d, d);
  const float along = -dot(spot.direction, d);
  if (!(r2 > 0) || along * std::abs(along) <= spot.cos_outer * std::abs(spot.cos_outer) * r2) return {};
  const Vec3 l = d / std::sqrt(r2);
  const Vec3 intensity = eval_spot(spot, -l);
  if (intensity == Vec3{}) return {};
  const auto scatter = eval_scatter<Light>(shading, point, l);
  if (scatter == Light{} || world.is_occluded(point.origin(), spot.position)) return {};
  return scatter * intensity / r2;
}

// Weight of a sample of a light against the BRDF's own sampling of the same direction.
float weigh_light_sample(const Shading& shading, Vec3 l, float pdf, const PathMeasures& measures) {
  if (!measures.emitter_mis) return 1;
  return power_heuristic(pdf, pdf_brdf(shading.material, shading.v, shading.frame.to_local(l)));
}

template <typename Light>
Light estimate_rectangle(const World& world, const Shading& shading, const SurfacePoint& point,
                         const RectangleLight& light, float u1, float u2, const PathMeasures& measures) {
  const Vec3 p = light.corner + light.u * u1 + light.v * u2;
  const float pdf = pdf_rectangle(light, point.p, p);
  if (!(pdf > 0)) return {};
  const Vec3 l = normalize(p - point.p);
  const auto scatter = eval_scatter<Light>(shading, point, l);
  // The end is drawn back from the light's own surface, as the start is put forward from its.
  const Vec3 end = p + rectangle_normal(light) * rectangle_epsilon(light);
  if (scatter == Light{} || world.is_occluded(point.origin(), end)) return {};
  return scatter * light.radiance_w_per_m2_sr * (weigh_light_sample(shading, l, pdf, measures) / pdf);
}

template <typename Light>
Light estimate_environment(const World& world, const Shading& shading, const SurfacePoint& point, float u1,
                           float u2, const PathMeasures& measures) {
  const Vec3 local = sample_cosine(u1, u2);
  const Vec3 l = shading.frame.to_world(local);
  const float pdf = pdf_environment(local.z);
  const auto scatter = eval_scatter<Light>(shading, point, l);
  if (!(pdf > 0) || scatter == Light{} || !world.is_open(point.origin(), l)) return {};
  return scatter * world.environment() * (weigh_light_sample(shading, l, pdf, measures) / pdf);
}

template <typename Light>
Light estimate_lights(const World& world, const Shading& shading, const SurfacePoint& point,
                      PathSampler& sampler, const PathMeasures& measures) {
  Light sum;
  for (const std::uint32_t spot : world.spots_at(point.p))
    sum += estimate_spot<Light>(world, shading, point, world.spots()[spot]);
  for (const RectangleLight& light : world.rectangles()) {
    const float u1 = sampler.next(), u2 = sampler.next();
    sum += estimate_rectangle<Light>(world, shading, point, light, u1, u2, measures);
  }
  if (world.environment() != Vec3{}) {
    const float u1 = sampler.next(), u2 = sampler.next();
    sum += estimate_environment<Light>(world, shading, point, u1, u2, measures);
  }
  return sum;
}

struct Step {
  Vec3 direction;
  Vec3 weight;
  float pdf;
};

std::optional<Step> sample_step(const Shading& shading, const SurfacePoint& point, PathSampler& sampler) {
  const float u0 = sampler.next(), u1 = sampler.next(), u2 = sampler.next();
  const auto sample = sample_brdf(shading.material, shading.v, u0, u1, u2);
  if (!sample) return std::nullopt;
  const Vec3 direction = shading.frame.to_world(sample->l);
  if (!(dot(point.ng, direction) > 0)) return std::nullopt;
  return Step{direction, sample->weight, sample->pdf};
}

// Light that the BRDF's own sampling met where its ray ended, weighted against the sampling of the light:
// a rectangle's shining side, or the environment where there is no surface.
Vec3 weigh_emitter(const World& world, const Shading& shading, const SurfacePoint& from, const Step& step,
                   const std::optional<SurfacePoint>& hit, const PathMeasures& measures) {
  if (!measures.emitter_mis) return {};
  if (!hit) {
    const float cosine = shading.frame.to_local(step.direction).z;
    return world.environment() * power_heuristic(step.pdf, pdf_environment(cosine));
  }
  const RectangleLight& light = world.rectangles()[static_cast<std::size_t>(hit->emitter)];
  return light.radiance_w_per_m2_sr * power_heuristic(step.pdf, pdf_rectangle(light, from.p, hit->p));
}

bool is_light(const std::optional<SurfacePoint>& hit) { return !hit || hit->emitter >= 0; }

// Share of paths that go on. A path's first bounce always does.
float survival_of(int depth, Vec3 weight, const PathMeasures& measures) {
  if (depth == 0) return 1;
  return measures.roulette ? std::min(kLargestSurvival, max_component(weight)) : kLargestSurvival;
}

// A path on its way.
struct PathState {
  SurfacePoint point;
  Vec3 v;
  Vec3 sum{}, throughput{1, 1, 1};
  int depth = 0;
  bool is_at_object = false;  // it has just met one, and was told to wait there
};

struct Walk {
  const World& world;
  const Materials& materials;
  bool with_direct;
  bool waits_at_object;
  const PathMeasures& measures;
};

// Adds what the path brings until it ends, or until it has to wait. Compiled once: two copies may round
// otherwise.
[[gnu::noinline, gnu::noclone]] void walk(const Walk& job, PathState& path, PathSampler& sampler) {
  path.is_at_object = false;
  for (;; ++path.depth) {
    const bool counts = job.with_direct || path.depth > 0;
    const Shading shading(job.materials, path.point, path.v);
    if (counts)
      path.sum +=
          path.throughput * estimate_lights<Vec3>(job.world, shading, path.point, sampler, job.measures);
    const auto step = sample_step(shading, path.point, sampler);
    if (!step) return;
    path.throughput *= step->weight;
    const float survival = survival_of(path.depth, step->weight, job.measures);
    if (!(survival > 0) || sampler.next() >= survival) return;
    path.throughput = path.throughput / survival;
    const auto hit = job.world.intersect(path.point.origin(), step->direction);
    if (is_light(hit)) {
      if (counts)
        path.sum += path.throughput * weigh_emitter(job.world, shading, path.point, *step, hit, job.measures);
      return;
    }
    path.v = -step->direction;
    path.point = *hit;
    if (!job.waits_at_object || !hit->is_object()) continue;
    path.is_at_object = true;
    ++path.depth;
    return;
  }
}

// All light that a surface reflects, part by part, for several materials of the objects: paths are shared
// where no object is met. Each sum is what its material has by itself.
void estimate_parts(const World& world, std::span<const Materials> materials, const SurfacePoint& point,
                    Vec3 v, PathSampler& sampler, const PathMeasures& measures, std::span<Parts> sums) {
  if (point.is_object() && materials.size() > 1) {
    for (std::size_t i = 0; i < materials.size(); ++i) {
      PathSampler own = sampler;
      estimate_parts(world, materials.subspan(i, 1), point, v, own, measures, sums.subspan(i, 1));
    }
    return;
  }
  const Shading shading(materials[0], point, v);
  const auto lights = estimate_lights<Parts>(world, shading, point, sampler, measures);
  std::fill(sums.begin(), sums.end(), lights);
  const auto step = sample_step(shading, point, sampler);
  if (!step) return;
  const float survival = survival_of(1, step->weight, measures);
  if (!(survival > 0) || sampler.next() >= survival) return;
  const Parts weight =
      eval_cosine_brdf<Parts>(shading, shading.frame.to_local(step->direction)) / (step->pdf * survival);
  const auto hit = world.intersect(point.origin(), step->direction);
  std::vector<Vec3> light(materials.size());
  if (is_light(hit)) {
    std::fill(light.begin(), light.end(), weigh_emitter(world, shading, point, *step, hit, measures));
  } else {
    estimate_reflected_by_material(world, materials, *hit, -step->direction, sampler, measures, light);
  }
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += weight * light[i];
}

}  // namespace

Vec3 estimate_direct(const World& world, const Materials& materials, const SurfacePoint& point, Vec3 v,
                     PathSampler& sampler, const PathMeasures& measures) {
  const Shading shading(materials, point, v);
  Vec3 sum = estimate_lights<Vec3>(world, shading, point, sampler, measures);
  if (!has_extended_lights(world)) return sum;
  const auto step = sample_step(shading, point, sampler);
  if (!step) return sum;
  const auto hit = world.intersect(point.origin(), step->direction);
  if (is_light(hit)) sum += step->weight * weigh_emitter(world, shading, point, *step, hit, measures);
  return sum;
}

Vec3 estimate_reflected(const World& world, const Materials& materials, const SurfacePoint& first,
                        Vec3 first_v, bool with_direct, PathSampler& sampler, const PathMeasures& measures) {
  PathState path{first, first_v};
  walk({world, materials, with_direct, false, measures}, path, sampler);
  return path.sum;
}

void estimate_reflected_by_material(const World& world, std::span<const Materials> materials,
                                    const SurfacePoint& first, Vec3 first_v, PathSampler& sampler,
                                    const PathMeasures& measures, std::span<Vec3> sums) {
  PathState common{first, first_v};
  common.is_at_object = first.is_object() && materials.size() > 1;
  if (!common.is_at_object)
    walk({world, materials[0], true, materials.size() > 1, measures}, common, sampler);
  for (std::size_t i = 0; i < materials.size(); ++i) {
    PathState path = common;
    PathSampler own = sampler;
    if (common.is_at_object) walk({world, materials[i], true, false, measures}, path, own);
    sums[i] = path.sum;
  }
}

bool has_gloss(const Materials& materials) {
  return std::any_of(materials.begin(), materials.end(),
                     [](const Material& material) { return material.glossy_share > 0; });
}

Vec3 ReturnedLight::at(double clamp_per_m2) const {
  if (double{peak_per_m2} <= clamp_per_m2) return missing;
  return clamped * static_cast<float>(1 - clamp_per_m2 / double{peak_per_m2}) + missing;
}

ReturnedLight estimate_returned(const World& world, const Materials& materials, const SurfacePoint& point,
                                Vec3 v, const ReturnParams& params, PathSampler& sampler,
                                const PathMeasures& measures) {
  ReturnedLight light;
  estimate_returned_by_material(world, {&materials, 1}, point, v, params, sampler, measures, {&light, 1});
  return light;
}

void estimate_returned_by_material(const World& world, std::span<const Materials> materials,
                                   const SurfacePoint& point, Vec3 v, const ReturnParams& params,
                                   PathSampler& sampler, const PathMeasures& measures,
                                   std::span<ReturnedLight> lights) {
  std::fill(lights.begin(), lights.end(), ReturnedLight{});
  const Shading shading(materials[0], point, v);
  const auto step = sample_step(shading, point, sampler);
  if (!step) return;
  const auto scatter = eval_scatter<Vec3>(shading, point, step->direction);
  const float most = max_component(scatter);
  // A little further than the clamp acts: what is clamped is said below, however far the ray was sent.
  constexpr double kMargin = 1 + 1e-5;
  const auto reach = params.with_missing
                         ? std::numeric_limits<float>::infinity()
                         : static_cast<float>(kMargin * std::sqrt(double{most} / params.least_clamp_per_m2));
  const auto hit = world.intersect(point.origin(), step->direction, reach);
  if (is_light(hit)) return;
  const Vec3 d = hit->p - point.p;
  const float peak = most / dot(d, d);
  const Vec3 response = scatter * (std::max(0.0f, -dot(hit->ng, step->direction)) / dot(d, d));
  const bool is_clamped = params.is_clamped(peak);
  const auto misses = [&](const Materials& of) {
    return params.with_missing && of[hit->material].glossy_share > 0;
  };
  if (!is_clamped && std::none_of(materials.begin(), materials.end(), misses)) return;
  std::vector<Parts> parts(materials.size());
  estimate_parts(world, materials, *hit, -step->direction, sampler, measures, parts);
  for (std::size_t i = 0; i < materials.size(); ++i) {
    if (!is_clamped && !misses(materials[i])) continue;
    const auto& [diffuse, glossy] = parts[i];
    if (params.with_missing) {
      lights[i] = {step->weight * diffuse, step->weight * glossy, peak, misses(materials[i]), response};
    } else {
      lights[i] = {step->weight * (diffuse + glossy), {}, peak, false, response};
    }
  }
}

}  // namespace equilux
