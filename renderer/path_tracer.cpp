// The path tracer.
#include "renderer/path_tracer.h"

#include <atomic>
#include <cmath>

#include "base/error.h"
#include "base/random.h"
#include "renderer/lights.h"
#include "renderer/parallel.h"

namespace equilux {
namespace {

// Additive recurrence with the powers of the root of x^(d+1) = x + 1. source: Roberts, "The unreasonable
// effectiveness of quasirandom sequences", 2018.
template <std::size_t kCount>
std::array<double, kCount> make_lattice_steps() {
  double root = 1.5;
  for (int i = 0; i < 60; ++i) root = std::pow(1 + root, 1.0 / (kCount + 1));
  std::array<double, kCount> steps{};
  double power = 1;
  for (double& step : steps) step = power /= root;
  return steps;
}

// Largest float under 1: rounding up from double must not leave [0, 1).
constexpr float kBelowOne = 0x1.fffffep-1f;

float power_heuristic(float a, float b) { return a * a / (a * a + b * b); }

// A surface seen from v, in its shading frame.
struct Shading {
  const Material& material;
  Frame frame;
  Vec3 v;
  Shading(const Materials& materials, const SurfacePoint& point, Vec3 view)
      : material(materials[point.material]), frame(point.ns), v(frame.to_local(view)) {}
};

// f cl of light from direction l (unit, world), gated by both normals.
Vec3 eval_scatter(const Shading& shading, const SurfacePoint& point, Vec3 l) {
  if (!(dot(point.ng, l) > 0)) return {};
  const Vec3 local = shading.frame.to_local(l);
  return eval_brdf(shading.material, shading.v, local) * std::max(0.0f, local.z);
}

Vec3 estimate_spot(const World& world, const Shading& shading, const SurfacePoint& point,
                   const SpotLight& spot) {
  const Vec3 d = spot.position - point.p;
  const float r2 = dot(d, d);
  const float along = -dot(spot.direction, d);
  if (!(r2 > 0) || along * std::abs(along) <= spot.cos_outer * std::abs(spot.cos_outer) * r2) return {};
  const Vec3 l = d / std::sqrt(r2);
  const Vec3 intensity = eval_spot(spot, -l);
  if (intensity == Vec3{}) return {};
  const Vec3 scatter = eval_scatter(shading, point, l);
  if (scatter == Vec3{} || world.is_occluded(point.origin(), spot.position)) return {};
  return scatter * intensity / r2;
}

Vec3 estimate_rectangle(const World& world, const Shading& shading, const SurfacePoint& point,
                        const RectangleLight& light, float u1, float u2) {
  const Vec3 p = light.corner + light.u * u1 + light.v * u2;
  const float pdf = pdf_rectangle(light, point.p, p);
  if (!(pdf > 0)) return {};
  const Vec3 l = normalize(p - point.p);
  const Vec3 scatter = eval_scatter(shading, point, l);
  // The end is drawn back as far as the start is put forward, so that the light's own surface does not stand
  // in the way.
  const Vec3 end = p + rectangle_normal(light) * (point.epsilon + 1e-6f * length(p - point.p));
  if (scatter == Vec3{} || world.is_occluded(point.origin(), end)) return {};
  const float weight = power_heuristic(pdf, pdf_brdf(shading.material, shading.v, shading.frame.to_local(l)));
  return scatter * light.radiance_w_per_m2_sr * (weight / pdf);
}

Vec3 estimate_lights(const World& world, const Shading& shading, const SurfacePoint& point,
                     PathSampler& sampler) {
  Vec3 sum;
  for (const SpotLight& spot : world.spots()) sum += estimate_spot(world, shading, point, spot);
  for (const RectangleLight& light : world.rectangles()) {
    const float u1 = sampler.next(), u2 = sampler.next();
    sum += estimate_rectangle(world, shading, point, light, u1, u2);
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

// Light of an emitter that the BRDF's own sampling met, weighted against the sampling of the light.
Vec3 weigh_emitter(const World& world, const SurfacePoint& from, const SurfacePoint& hit, float pdf) {
  const RectangleLight& light = world.rectangles()[static_cast<std::size_t>(hit.emitter)];
  return light.radiance_w_per_m2_sr * power_heuristic(pdf, pdf_rectangle(light, from.p, hit.p));
}

// Sums of one layer at one pixel, batch by batch.
struct BatchSums {
  std::array<std::array<double, 3>, kBatches> sums{};
  void add(int batch, Vec3 value) {
    auto& sum = sums[static_cast<std::size_t>(batch)];
    sum[0] += value.x;
    sum[1] += value.y;
    sum[2] += value.z;
  }
  void scale(double factor) {
    for (auto& sum : sums) {
      for (double& value : sum) value *= factor;
    }
  }
};

void store_mean(const BatchSums& batches, float* pixel) {
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0;
    for (const auto& batch : batches.sums) sum += batch[c];
    pixel[c] = static_cast<float>(sum / kBatches);
  }
}

void store_standard_error(const std::array<const BatchSums*, 3>& layers, float* pixel) {
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0, squares = 0;
    for (std::size_t b = 0; b < kBatches; ++b) {
      double total = 0;
      for (const BatchSums* layer : layers) total += layer->sums[b][c];
      sum += total;
      squares += total * total;
    }
    const double variance = std::max(0.0, squares - sum * sum / kBatches) / (kBatches - 1);
    pixel[c] = static_cast<float>(std::sqrt(variance / kBatches));
  }
}

// What one layer needs to be estimated at one subpixel position.
struct LayerJob {
  StreamKey key;
  int paths_per_batch;
};

template <typename Estimate>
void add_batches(BatchSums& sums, const LayerJob& job, std::uint64_t place, const Estimate& estimate) {
  for (int batch = 0; batch < kBatches; ++batch) {
    PathSampler sampler(RandomStream(job.key, place * kBatches + static_cast<std::uint64_t>(batch)));
    Vec3 sum;
    for (int path = 0; path < job.paths_per_batch; ++path) {
      sampler.next_path();
      sum += estimate(sampler);
    }
    sums.add(batch, sum / static_cast<float>(job.paths_per_batch));
  }
}

struct FamilyJob {
  const World& world;
  const Materials& materials;
  const Primary& primary;
  LayerJob background, direct, indirect;
};

// Direct light is exact where no light has an area: then one path a batch is enough.
int needed_direct_paths(const World& world, int paths) { return world.rectangles().empty() ? 1 : paths; }

void trace_pixel(const FamilyJob& job, std::size_t pixel, FamilyLayers& layers) {
  BatchSums background, direct, indirect;
  for (int position = 0; position < job.primary.positions; ++position) {
    const PrimaryHit& hit = job.primary.at(pixel, position);
    const std::uint64_t place =
        pixel * static_cast<std::uint64_t>(job.primary.positions) + static_cast<std::uint64_t>(position);
    if (hit.kind == PrimaryKind::kObject) {
      add_batches(direct, job.direct, place, [&](PathSampler& sampler) {
        return estimate_direct(job.world, job.materials, hit.point, hit.v, sampler);
      });
      add_batches(indirect, job.indirect, place, [&](PathSampler& sampler) {
        return estimate_reflected(job.world, job.materials, hit.point, hit.v, false, sampler);
      });
    } else if (hit.kind == PrimaryKind::kRoom && hit.point.emitter >= 0) {
      const Vec3 radiance =
          job.world.rectangles()[static_cast<std::size_t>(hit.point.emitter)].radiance_w_per_m2_sr;
      for (int batch = 0; batch < kBatches; ++batch) background.add(batch, radiance);
    } else if (hit.kind == PrimaryKind::kRoom) {
      add_batches(background, job.background, place, [&](PathSampler& sampler) {
        return estimate_reflected(job.world, job.materials, hit.point, hit.v, true, sampler);
      });
    }
  }
  for (BatchSums* sums : {&background, &direct, &indirect}) sums->scale(1.0 / job.primary.positions);
  store_mean(background, layers.background.pixel(pixel));
  store_mean(direct, layers.direct.pixel(pixel));
  store_mean(indirect, layers.indirect.pixel(pixel));
  store_standard_error({&background, &direct, &indirect}, layers.standard_error.pixel(pixel));
}

// A picture with a value that is not finite fails as a whole: none is ever set to zero.
void check_finite(const FamilyLayers& layers, const std::string& name) {
  std::size_t bad = 0;
  for (const HdrImage* layer :
       {&layers.background, &layers.direct, &layers.indirect, &layers.standard_error}) {
    for (float value : layer->values) bad += !std::isfinite(value);
  }
  if (bad > 0) {
    throw InputError(name, "", "finite radiance in every pixel", fmt::format("{} values that are not", bad));
  }
}

double paths_in(const Primary& primary, const PathCounts& paths, std::size_t first, std::size_t last) {
  const int object = round_paths(paths.object_indirect, primary.positions) / primary.positions;
  const int background = round_paths(paths.background, primary.positions) / primary.positions;
  double sum = 0;
  for (std::size_t i = first; i < last; ++i) {
    const PrimaryKind kind = primary.hits[i].kind;
    sum += kind == PrimaryKind::kObject ? object : kind == PrimaryKind::kRoom ? background : 0;
  }
  return sum;
}

}  // namespace

PathSampler::PathSampler(const RandomStream& stream) : stream_(stream) {
  for (double& coordinate : point_) coordinate = stream_.next_double();
}

void PathSampler::next_path() {
  static const auto steps = make_lattice_steps<kDimensions>();
  for (std::size_t i = 0; i < kDimensions; ++i) {
    point_[i] += steps[i];
    if (point_[i] >= 1) point_[i] -= 1;
  }
  dimension_ = 0;
}

float PathSampler::next() {
  if (dimension_ == kDimensions) return stream_.next_float();
  return std::min(static_cast<float>(point_[dimension_++]), kBelowOne);
}

Vec3 estimate_direct(const World& world, const Materials& materials, const SurfacePoint& point, Vec3 v,
                     PathSampler& sampler) {
  const Shading shading(materials, point, v);
  Vec3 sum = estimate_lights(world, shading, point, sampler);
  if (world.rectangles().empty()) return sum;
  const auto step = sample_step(shading, point, sampler);
  if (!step) return sum;
  const auto hit = world.intersect(point.origin(), step->direction);
  if (hit && hit->emitter >= 0) sum += step->weight * weigh_emitter(world, point, *hit, step->pdf);
  return sum;
}

Vec3 estimate_reflected(const World& world, const Materials& materials, const SurfacePoint& first,
                        Vec3 first_v, bool with_direct, PathSampler& sampler) {
  Vec3 sum, throughput{1, 1, 1};
  SurfacePoint point = first;
  Vec3 v = first_v;
  for (int depth = 0;; ++depth) {
    const bool counts = with_direct || depth > 0;
    const Shading shading(materials, point, v);
    if (counts) sum += throughput * estimate_lights(world, shading, point, sampler);
    const auto step = sample_step(shading, point, sampler);
    if (!step) return sum;
    throughput *= step->weight;
    const float survival = depth == 0 ? 1 : std::min(kLargestSurvival, max_component(step->weight));
    if (!(survival > 0) || sampler.next() >= survival) return sum;
    throughput = throughput / survival;
    const auto hit = world.intersect(point.origin(), step->direction);
    if (!hit) return sum;
    if (hit->emitter >= 0)
      return counts ? sum + throughput * weigh_emitter(world, point, *hit, step->pdf) : sum;
    v = -step->direction;
    point = *hit;
  }
}

int round_paths(int paths, int positions) {
  const int unit = kBatches * positions;
  return (paths + unit - 1) / unit * unit;
}

double count_family_paths(const Primary& primary, const PathCounts& paths) {
  return paths_in(primary, paths, 0, primary.hits.size());
}

FamilyLayers trace_family(const World& world, const Materials& materials, const Primary& primary,
                          const PathCounts& paths, std::uint64_t seed, const std::string& stream_name,
                          const std::function<void(double)>& progress) {
  const auto layer_job = [&](const char* layer, int count) {
    return LayerJob{make_stream_key(seed, stream_name + "." + layer),
                    round_paths(count, primary.positions) / primary.positions / kBatches};
  };
  const FamilyJob job{world,
                      materials,
                      primary,
                      layer_job("background", paths.background),
                      layer_job("direct", needed_direct_paths(world, paths.object_direct)),
                      layer_job("indirect", paths.object_indirect)};
  const HdrImage empty(primary.width, primary.height);
  FamilyLayers layers{empty, empty, empty, empty};
  // A strip is small enough to share work out evenly and large enough to keep the report of progress cheap.
  constexpr std::size_t kStrip = 64;
  const std::size_t pixels = empty.pixel_count();
  for_each_parallel((pixels + kStrip - 1) / kStrip, [&](std::size_t strip) {
    const std::size_t first = strip * kStrip, last = std::min(pixels, first + kStrip);
    for (std::size_t pixel = first; pixel < last; ++pixel) trace_pixel(job, pixel, layers);
    const auto positions = static_cast<std::size_t>(primary.positions);
    progress(paths_in(primary, paths, first * positions, last * positions));
  });
  check_finite(layers, stream_name);
  return layers;
}

}  // namespace equilux
