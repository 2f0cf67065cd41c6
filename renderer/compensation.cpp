// Compensation after Kollig and Keller.
#include "renderer/compensation.h"

#include <algorithm>
#include <mutex>

#include "base/error.h"
#include "renderer/parallel.h"

namespace equilux {
namespace {

struct CompensationJob {
  const RoomScene& scene;
  PrimaryKind kind;  // what is seen of it
  const CompensationParams& params;
  BatchJob batches;
  ReturnParams returned;
};

bool is_wanted(const PrimaryHit& hit, PrimaryKind kind) {
  return hit.kind == kind && (kind != PrimaryKind::kRoom || hit.is_room_surface());
}

// Gives the paths traced, and counts those that went on. shape of `layers` and `walks`: material x clamp
double trace_pixel(const CompensationJob& job, std::size_t pixel, std::vector<TracedLayer>& layers,
                   std::vector<std::uint64_t>& walks) {
  if (job.batches.map[pixel] == 0) return 0;
  const Primary& primary = job.scene.primary;
  const std::vector<double>& clamps = job.params.clamps_per_m2;
  double traced = 0;
  std::vector<BatchSums> batches(layers.size());
  std::vector<ReturnedLight> lights(job.scene.materials.size());
  for (int position = 0; position < primary.positions; ++position) {
    const PrimaryHit& hit = primary.at(pixel, position);
    if (!is_wanted(hit, job.kind)) continue;
    const std::uint64_t place =
        pixel * static_cast<std::uint64_t>(primary.positions) + static_cast<std::uint64_t>(position);
    add_batches(batches, job.batches, pixel, place, [&](PathSampler& sampler, auto& sums) {
      estimate_returned_by_material(job.scene.world, job.scene.materials, hit.point, hit.v, job.returned,
                                    sampler, job.params.measures, lights);
      for (std::size_t material = 0; material < lights.size(); ++material) {
        ReturnedLight& light = lights[material];
        if (light.peak_per_m2 == 0) continue;
        if (job.params.clamped_alone) light.missing = {};
        for (std::size_t level = 0; level < clamps.size(); ++level) {
          const std::size_t layer = material * clamps.size() + level;
          add_light(light.at(clamps[level]), sums[layer]);
          walks[layer] += light.goes_on(clamps[level]) ? 1 : 0;
        }
      }
    });
    traced += double{kBatches} * job.batches.map[pixel];
  }
  for (std::size_t i = 0; i < layers.size(); ++i) store(batches[i], primary.positions, layers[i], pixel);
  return traced;
}

std::vector<TracedLayer> trace_returned(const RoomScene& scene, PrimaryKind kind, const PathMap& map,
                                        const CompensationParams& params,
                                        const std::function<void(double)>& progress,
                                        CompensationRecord* record) {
  EQ_CHECK(!params.clamps_per_m2.empty(), params.clamps_per_m2.size());
  const double least = *std::min_element(params.clamps_per_m2.begin(), params.clamps_per_m2.end());
  const bool with_missing =
      std::any_of(scene.materials.begin(), scene.materials.end(),
                  [&](const Materials& of) { return lacks_gloss(params.emission, of); });
  const StreamKey key = make_stream_key(params.seed, params.stream_name + ".compensation");
  const CompensationJob job{scene, kind, params, {key, map, params.measures}, {least, with_missing}};
  const HdrImage empty(scene.primary.width, scene.primary.height);
  std::vector<TracedLayer> layers(scene.materials.size() * params.clamps_per_m2.size(), {empty, empty});
  constexpr std::size_t kStrip = 64;
  const std::size_t pixels = empty.pixel_count();
  std::mutex mutex;
  double all_traced = 0;  // whole numbers, in any order
  std::vector<std::uint64_t> all_walks(layers.size());
  for_each_parallel((pixels + kStrip - 1) / kStrip, [&](std::size_t strip) {
    double traced = 0;
    std::vector<std::uint64_t> walks(layers.size());
    for (std::size_t pixel = strip * kStrip; pixel < std::min(pixels, (strip + 1) * kStrip); ++pixel)
      traced += trace_pixel(job, pixel, layers, walks);
    progress(traced);
    const std::lock_guard lock(mutex);
    all_traced += traced;
    for (std::size_t i = 0; i < walks.size(); ++i) all_walks[i] += walks[i];
  });
  if (record) {
    record->walked.clear();
    for (const std::uint64_t walks : all_walks)
      record->walked.push_back(all_traced > 0 ? static_cast<double>(walks) / all_traced : 0);
  }
  std::vector<const TracedLayer*> all;
  for (const TracedLayer& layer : layers) all.push_back(&layer);
  check_finite(all, params.stream_name + ".compensation");
  return layers;
}

}  // namespace

bool lacks_gloss(Emission emission, const Materials& materials) {
  return emission == Emission::kLambertian && has_gloss(materials);
}

std::vector<TracedLayer> trace_compensation(const FamilyScene& scene, const PathMap& map,
                                            const CompensationParams& params,
                                            const std::function<void(double)>& progress,
                                            CompensationRecord* record) {
  return trace_returned({scene.world, {&scene.materials, 1}, scene.primary}, PrimaryKind::kObject, map,
                        params, progress, record);
}

std::vector<TracedLayer> trace_room_compensation(const RoomScene& scene, const PathMap& map,
                                                 const CompensationParams& params,
                                                 const std::function<void(double)>& progress,
                                                 CompensationRecord* record) {
  return trace_returned(scene, PrimaryKind::kRoom, map, params, progress, record);
}

}  // namespace equilux
