// Layers from estimates: pixels, subpixel positions, batches.
#include "renderer/family.h"

#include <cmath>

#include "base/error.h"
#include "renderer/lights.h"
#include "renderer/parallel.h"

namespace equilux {
namespace {

struct ObjectJob {
  const FamilyScene& scene;
  BatchJob direct, indirect;
  bool exact_direct;  // no light has an area: nothing is sampled
};

bool may_be_lit(const World& world, const PrimaryHit& hit) {
  return world.may_be_lit(static_cast<std::size_t>(hit.point.object));
}

// Direct light without sampling, the same in every batch.
void add_exact_direct(const ObjectJob& job, const PrimaryHit& hit, BatchSums& direct) {
  PathSampler unused(RandomStream(job.direct.key, 0), false);
  const Vec3 light =
      estimate_direct(job.scene.world, job.scene.materials, hit.point, hit.v, unused, job.direct.measures);
  for (LightSum& batch : direct) add_light(light, batch);
}

// What the camera sees without a bounce: a lamp, or the environment.
void add_seen_light(const World& world, const PrimaryHit& hit, BatchSums& background) {
  const Vec3 radiance =
      hit.kind == PrimaryKind::kNothing
          ? world.environment()
          : world.rectangles()[static_cast<std::size_t>(hit.point.emitter)].radiance_w_per_m2_sr;
  for (LightSum& batch : background) add_light(radiance, batch);
}

void trace_object_pixel(const ObjectJob& job, std::size_t pixel, TracedLayers& layers) {
  const World& world = job.scene.world;
  const Materials& materials = job.scene.materials;
  const Primary& primary = job.scene.primary;
  BatchSums direct{}, indirect{};
  for (int position = 0; position < primary.positions; ++position) {
    const PrimaryHit& hit = primary.at(pixel, position);
    if (hit.kind != PrimaryKind::kObject) continue;
    const std::uint64_t place =
        pixel * static_cast<std::uint64_t>(primary.positions) + static_cast<std::uint64_t>(position);
    const auto add = [&](BatchSums& layer, const BatchJob& how, const auto& estimate) {
      add_batches(std::span(&layer, 1), how, pixel, place, [&](PathSampler& sampler, auto& sums) {
        add_light(estimate(sampler, how.measures), sums.front());
      });
    };
    const bool wanted = job.direct.map[pixel] > 0 && may_be_lit(world, hit);
    if (wanted && job.exact_direct) {
      add_exact_direct(job, hit, direct);
    } else if (wanted) {
      add(direct, job.direct, [&](PathSampler& sampler, const PathMeasures& measures) {
        return estimate_direct(world, materials, hit.point, hit.v, sampler, measures);
      });
    }
    add(indirect, job.indirect, [&](PathSampler& sampler, const PathMeasures& measures) {
      return estimate_reflected(world, materials, hit.point, hit.v, false, sampler, measures);
    });
  }
  store(direct, primary.positions, layers.direct, pixel);
  store(indirect, primary.positions, layers.indirect, pixel);
}

struct BackgroundJob {
  const World& world;
  std::span<const Materials> materials;
  const Primary& primary;
  const BatchJob& batches;
};

// Gives the paths traced, each once for all materials. A pixel of no paths stays black.
double trace_background_pixel(const BackgroundJob& job, std::size_t pixel, std::vector<TracedLayer>& layers) {
  if (job.batches.map[pixel] == 0) return 0;
  const auto positions = static_cast<std::uint64_t>(job.primary.positions);
  std::vector<BatchSums> sums(layers.size());
  std::vector<Vec3> light(layers.size());
  double traced = 0;
  for (std::uint64_t position = 0; position < positions; ++position) {
    const PrimaryHit& hit = job.primary.at(pixel, static_cast<int>(position));
    if (hit.kind == PrimaryKind::kHidden || hit.kind == PrimaryKind::kObject) continue;
    if (hit.kind == PrimaryKind::kNothing || hit.point.emitter >= 0) {
      for (BatchSums& sum : sums) add_seen_light(job.world, hit, sum);
      continue;
    }
    add_batches(sums, job.batches, pixel, pixel * positions + position,
                [&](PathSampler& sampler, auto& batch) {
                  estimate_reflected_by_material(job.world, job.materials, hit.point, hit.v, sampler,
                                                 job.batches.measures, light);
                  for (std::size_t i = 0; i < light.size(); ++i) add_light(light[i], batch[i]);
                });
    traced += double{kBatches} * job.batches.map[pixel];
  }
  for (std::size_t i = 0; i < layers.size(); ++i) store(sums[i], job.primary.positions, layers[i], pixel);
  return traced;
}

// Light that the room sends on straight from the lights.
void trace_room_direct_pixel(const World& world, const Materials& materials, const Primary& primary,
                             const BatchJob& job, std::size_t pixel, TracedLayer& layer) {
  const auto positions = static_cast<std::uint64_t>(primary.positions);
  const bool is_exact = !has_extended_lights(world);
  BatchSums sums{};
  for (std::uint64_t position = 0; position < positions; ++position) {
    const PrimaryHit& hit = primary.at(pixel, static_cast<int>(position));
    if (hit.kind == PrimaryKind::kHidden || hit.kind == PrimaryKind::kObject) continue;
    if (!hit.is_room_surface()) {
      add_seen_light(world, hit, sums);
    } else if (is_exact) {
      PathSampler unused(RandomStream(job.key, 0), false);
      const Vec3 light = estimate_direct(world, materials, hit.point, hit.v, unused, job.measures);
      for (LightSum& batch : sums) add_light(light, batch);
    } else {
      add_batches(std::span(&sums, 1), job, pixel, pixel * positions + position,
                  [&](PathSampler& sampler, auto& batch) {
                    add_light(estimate_direct(world, materials, hit.point, hit.v, sampler, job.measures),
                              batch.front());
                  });
    }
  }
  store(sums, primary.positions, layer, pixel);
}

// A strip is small enough to share work out evenly and large enough to keep the report of progress cheap.
void for_each_strip(std::size_t pixels, const std::function<void(std::size_t, std::size_t)>& body) {
  constexpr std::size_t kStrip = 64;
  for_each_parallel((pixels + kStrip - 1) / kStrip,
                    [&](std::size_t strip) { body(strip * kStrip, std::min(pixels, (strip + 1) * kStrip)); });
}

// Paths of the direct and the indirect layer at an object's position, or of the background at the room's.
double count_paths_of_pixels(const Primary& primary, const PathMaps& maps, std::size_t first,
                             std::size_t last) {
  double sum = 0;
  for (std::size_t pixel = first; pixel < last; ++pixel) {
    for (int position = 0; position < primary.positions; ++position) {
      const PrimaryKind kind = primary.at(pixel, position).kind;
      if (kind == PrimaryKind::kObject) sum += maps.direct[pixel] + maps.indirect[pixel];
      if (kind == PrimaryKind::kRoom) sum += maps.background[pixel];
    }
  }
  return sum * kBatches;
}

}  // namespace

std::vector<Materials> take_materials(std::span<const Materials> materials,
                                      const std::vector<std::size_t>& which) {
  std::vector<Materials> taken;
  for (const std::size_t i : which) taken.push_back(materials[i]);
  return taken;
}

StreamKey make_background_key(std::uint64_t seed, const std::string& stream_name) {
  return make_stream_key(seed, stream_name + ".background");
}

std::vector<TracedLayer> trace_backgrounds(const World& world, std::span<const Materials> materials,
                                           const Primary& primary, const BatchJob& job,
                                           const std::string& stream_name,
                                           const std::function<void(double)>& progress) {
  const HdrImage empty(primary.width, primary.height);
  std::vector<TracedLayer> layers(materials.size(), {empty, empty});
  const BackgroundJob background{world, materials, primary, job};
  for_each_strip(empty.pixel_count(), [&](std::size_t first, std::size_t last) {
    double traced = 0;
    for (std::size_t pixel = first; pixel < last; ++pixel)
      traced += trace_background_pixel(background, pixel, layers);
    progress(traced);
  });
  std::vector<const TracedLayer*> all;
  for (const TracedLayer& layer : layers) all.push_back(&layer);
  check_finite(all, stream_name + ".background");
  return layers;
}

TracedLayer trace_room_direct(const World& world, const Primary& primary, const BatchJob& job,
                              const std::string& stream_name, const std::function<void(double)>& progress) {
  const HdrImage empty(primary.width, primary.height);
  TracedLayer layer{empty, empty};
  const Materials materials = make_grey_materials(world);
  for_each_strip(empty.pixel_count(), [&](std::size_t first, std::size_t last) {
    double traced = 0;
    for (std::size_t pixel = first; pixel < last; ++pixel) {
      if (job.map[pixel] == 0) continue;
      trace_room_direct_pixel(world, materials, primary, job, pixel, layer);
      for (int position = 0; position < primary.positions; ++position)
        traced += primary.at(pixel, position).is_room_surface() ? double{kBatches} * job.map[pixel] : 0;
    }
    progress(traced);
  });
  check_finite({&layer}, stream_name + ".room-direct");
  return layer;
}

void check_finite(const std::vector<const TracedLayer*>& layers, const std::string& name) {
  std::size_t bad = 0;
  for (const TracedLayer* layer : layers) {
    for (float value : layer->mean.values) bad += !std::isfinite(value);
    for (float value : layer->standard_error.values) bad += !std::isfinite(value);
  }
  if (bad > 0) {
    throw InputError(name, "", "finite radiance in every pixel", fmt::format("{} values that are not", bad));
  }
}

int round_paths(int paths, int positions) {
  const int unit = kBatches * positions;
  return (paths + unit - 1) / unit * unit;
}

PathMaps make_fixed_maps(const Primary& primary, const PathCounts& paths) {
  const std::size_t pixels =
      static_cast<std::size_t>(primary.width) * static_cast<std::size_t>(primary.height);
  const auto map = [&](int count) {
    const int unit = kBatches * primary.positions;
    return PathMap(pixels, static_cast<std::uint32_t>(round_paths(count, primary.positions) / unit));
  };
  return {map(paths.background), map(paths.object_direct), map(paths.object_indirect)};
}

double count_paths(const Primary& primary, const PathMaps& maps) {
  return count_paths_of_pixels(primary, maps, 0, maps.background.size());
}

double count_room_paths(const Primary& primary, const PathMap& map) {
  const PathMap none(map.size(), 0);
  return count_paths(primary, {map, none, none});
}

TracedLayers trace_layers(const FamilyScene& scene, const PathMaps& maps, std::uint64_t seed,
                          const std::string& stream_name, const PathMeasures& measures,
                          const std::function<void(double)>& progress) {
  const Primary& primary = scene.primary;
  const auto make_job = [&](const char* layer, const PathMap& map) {
    return BatchJob{make_stream_key(seed, stream_name + "." + layer), map, measures};
  };
  const ObjectJob job{scene, make_job("direct", maps.direct), make_job("indirect", maps.indirect),
                      !has_extended_lights(scene.world)};
  const PathMaps of_object{PathMap(maps.background.size(), 0), maps.direct, maps.indirect};
  const HdrImage empty(primary.width, primary.height);
  TracedLayers layers{{}, {empty, empty}, {empty, empty}};
  layers.background = std::move(trace_backgrounds(
      scene.world, {&scene.materials, 1}, primary,
      {make_background_key(seed, stream_name), maps.background, measures}, stream_name, progress)[0]);
  for_each_strip(empty.pixel_count(), [&](std::size_t first, std::size_t last) {
    for (std::size_t pixel = first; pixel < last; ++pixel) trace_object_pixel(job, pixel, layers);
    progress(count_paths_of_pixels(primary, of_object, first, last));
  });
  check_finite({&layers.direct, &layers.indirect}, stream_name);
  return layers;
}

void add_independent(TracedLayer& sum, const TracedLayer& more) {
  for (std::size_t i = 0; i < sum.mean.values.size(); ++i) {
    sum.mean.values[i] += more.mean.values[i];
    sum.standard_error.values[i] = std::hypot(sum.standard_error.values[i], more.standard_error.values[i]);
  }
}

HdrImage combine_standard_errors(const TracedLayers& layers) {
  HdrImage combined = layers.background.standard_error;
  for (std::size_t i = 0; i < combined.values.size(); ++i) {
    combined.values[i] =
        std::hypot(layers.background.standard_error.values[i], layers.direct.standard_error.values[i],
                   layers.indirect.standard_error.values[i]);
  }
  return combined;
}

}  // namespace equilux
