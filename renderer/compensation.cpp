// Compensation after Kollig and Keller.
#include "renderer/compensation.h"

#include <algorithm>
#include <cmath>
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

// What is counted of each layer, for as long as a strip of pixels takes.
struct Strip {
  double traced = 0;
  std::vector<std::uint64_t> walks;
  explicit Strip(std::size_t layers) : walks(layers) {}
};

// Of VPLs that shine alike each square is its light times what one of them brings: of order c^2 / peak, so
// nothing where the peak leaves the range of float.
Vec3 find_square(const ReturnedLight& light, double clamp_per_m2) {
  if (!std::isfinite(light.peak_per_m2)) return {};
  const double share = std::min(1.0, clamp_per_m2 / double{light.peak_per_m2});
  return light.clamped * light.response * static_cast<float>(share * share);
}

class CompensationTracer {
 public:
  CompensationTracer(const CompensationJob& job, CompensationRecord* record)
      : job_(job), record_(record), clamps_(job.params.clamps_per_m2) {
    const HdrImage empty(job.scene.primary.width, job.scene.primary.height);
    layers_.assign(job.scene.materials.size() * clamps_.size(), {empty, empty});
    if (record_) *record_ = {std::vector<double>(layers_.size()), {layers_.size(), empty}};
  }

  std::vector<TracedLayer> trace(const std::function<void(double)>& progress) {
    constexpr std::size_t kStrip = 64;
    const std::size_t pixels = job_.batches.map.size();
    std::mutex mutex;
    Strip all(layers_.size());
    for_each_parallel((pixels + kStrip - 1) / kStrip, [&](std::size_t number) {
      Strip strip(layers_.size());
      for (std::size_t pixel = number * kStrip; pixel < std::min(pixels, (number + 1) * kStrip); ++pixel)
        trace_pixel(pixel, strip);
      progress(strip.traced);
      const std::lock_guard lock(mutex);
      all.traced += strip.traced;  // whole numbers, in any order
      for (std::size_t i = 0; i < strip.walks.size(); ++i) all.walks[i] += strip.walks[i];
    });
    for (std::size_t i = 0; record_ && all.traced > 0 && i < layers_.size(); ++i)
      record_->walked[i] = static_cast<double>(all.walks[i]) / all.traced;
    return std::move(layers_);
  }

 private:
  void trace_pixel(std::size_t pixel, Strip& strip) {
    if (job_.batches.map[pixel] == 0) return;
    const Primary& primary = job_.scene.primary;
    std::vector<BatchSums> batches(layers_.size());
    std::vector<LightSum> squares(record_ ? layers_.size() : 0);
    std::vector<ReturnedLight> lights(job_.scene.materials.size());
    for (int position = 0; position < primary.positions; ++position) {
      const PrimaryHit& hit = primary.at(pixel, position);
      if (!is_wanted(hit, job_.kind)) continue;
      const std::uint64_t place =
          pixel * static_cast<std::uint64_t>(primary.positions) + static_cast<std::uint64_t>(position);
      add_batches(batches, job_.batches, pixel, place, [&](PathSampler& sampler, auto& sums) {
        estimate_returned_by_material(job_.scene.world, job_.scene.materials, hit.point, hit.v, job_.returned,
                                      sampler, job_.params.measures, lights);
        for (std::size_t material = 0; material < lights.size(); ++material) {
          ReturnedLight& light = lights[material];
          if (light.peak_per_m2 == 0) continue;
          if (job_.params.clamped_alone) light.missing = {};
          for (std::size_t level = 0; level < clamps_.size(); ++level) {
            const std::size_t layer = material * clamps_.size() + level;
            add_light(light.at(clamps_[level]), sums[layer]);
            if (!record_) continue;
            strip.walks[layer] += light.goes_on(clamps_[level]) ? 1 : 0;
            if (job_.returned.is_clamped(light.peak_per_m2))
              add_light(find_square(light, clamps_[level]), squares[layer]);
          }
        }
      });
      strip.traced += double{kBatches} * job_.batches.map[pixel];
    }
    for (std::size_t i = 0; i < layers_.size(); ++i) store(batches[i], primary.positions, layers_[i], pixel);
    const double paths = double{kBatches} * job_.batches.map[pixel] * primary.positions;
    for (std::size_t i = 0; i < squares.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c)
        record_->variances[i].pixel(pixel)[c] = static_cast<float>(squares[i][c] / paths);
    }
  }

  const CompensationJob& job_;
  CompensationRecord* record_;
  const std::vector<double>& clamps_;
  std::vector<TracedLayer> layers_;
};

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
  std::vector<TracedLayer> layers = CompensationTracer(job, record).trace(progress);
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
