// Compensation after Kollig and Keller.
#include "renderer/compensation.h"

#include <algorithm>

#include "base/error.h"
#include "renderer/parallel.h"

namespace equilux {
namespace {

struct CompensationJob {
  const FamilyScene& scene;
  const CompensationParams& params;
  BatchJob batches;
  ReturnParams returned;
};

// Gives the paths traced.
double trace_pixel(const CompensationJob& job, std::size_t pixel, std::vector<TracedLayer>& layers) {
  const Primary& primary = job.scene.primary;
  double traced = 0;
  std::vector<BatchSums> batches(layers.size());
  for (int position = 0; position < primary.positions; ++position) {
    const PrimaryHit& hit = primary.at(pixel, position);
    if (hit.kind != PrimaryKind::kObject) continue;
    const std::uint64_t place =
        pixel * static_cast<std::uint64_t>(primary.positions) + static_cast<std::uint64_t>(position);
    add_batches(batches, job.batches, pixel, place, [&](PathSampler& sampler, auto& sums) {
      ReturnedLight light = estimate_returned(job.scene.world, job.scene.materials, hit.point, hit.v,
                                              job.returned, sampler, job.params.measures);
      if (light.peak_per_m2 == 0) return;
      if (job.params.clamped_alone) light.missing = {};
      for (std::size_t level = 0; level < sums.size(); ++level)
        add_light(light.at(job.params.clamps_per_m2[level]), sums[level]);
    });
    traced += double{kBatches} * job.batches.map[pixel];
  }
  for (std::size_t level = 0; level < layers.size(); ++level)
    store(batches[level], primary.positions, layers[level], pixel);
  return traced;
}

}  // namespace

std::vector<TracedLayer> trace_compensation(const FamilyScene& scene, const PathMap& map,
                                            const CompensationParams& params,
                                            const std::function<void(double)>& progress) {
  EQ_CHECK(!params.clamps_per_m2.empty(), params.clamps_per_m2.size());
  const double least = *std::min_element(params.clamps_per_m2.begin(), params.clamps_per_m2.end());
  const bool with_missing = params.emission == Emission::kLambertian && has_gloss(scene.materials);
  const StreamKey key = make_stream_key(params.seed, params.stream_name + ".compensation");
  const CompensationJob job{scene, params, {key, map, params.measures}, {least, with_missing}};
  const HdrImage empty(scene.primary.width, scene.primary.height);
  std::vector<TracedLayer> layers(params.clamps_per_m2.size(), {empty, empty});
  constexpr std::size_t kStrip = 64;
  const std::size_t pixels = empty.pixel_count();
  for_each_parallel((pixels + kStrip - 1) / kStrip, [&](std::size_t strip) {
    double traced = 0;
    for (std::size_t pixel = strip * kStrip; pixel < std::min(pixels, (strip + 1) * kStrip); ++pixel)
      traced += trace_pixel(job, pixel, layers);
    progress(traced);
  });
  std::vector<const TracedLayer*> all;
  for (const TracedLayer& layer : layers) all.push_back(&layer);
  check_finite(all, params.stream_name + ".compensation");
  return layers;
}

}  // namespace equilux
