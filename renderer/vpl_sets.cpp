// Pilot, sets, mean.
#include "renderer/vpl_sets.h"

#include <cmath>
#include <numeric>

#include "base/error.h"
#include "renderer/lightcut.h"

namespace equilux {
namespace {

// Of the pilot: its totals are only thresholds.
constexpr double kPilotRatio = 0.0075;

// What the camera sees of one object, and the totals of its rule.
struct ObjectPoints {
  std::vector<ShadingPoint> points;
  ShadedPoints pilot;
};

// Sums over sets, and of squares. shape: height x width x 3
struct LayerSums {
  std::vector<double> sum, squares;
  explicit LayerSums(std::size_t values) : sum(values), squares(values) {}

  void add(const HdrImage& layer) {
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const double value = layer.values[i];
      sum[i] += value;
      squares[i] += value * value;
    }
  }

  TracedLayer finish(int count, const HdrImage& empty) const {
    TracedLayer layer{empty, empty};
    for (std::size_t i = 0; i < sum.size(); ++i) {
      const double mean = sum[i] / count;
      const double variance = std::max(0.0, squares[i] / count - mean * mean) * count / (count - 1);
      layer.mean.values[i] = static_cast<float>(mean);
      layer.standard_error.values[i] = static_cast<float>(std::sqrt(variance / count));
    }
    return layer;
  }
};

class SetTracer {
 public:
  SetTracer(const FamilyScene& scene, const VplSetsParams& params) : scene_(scene), params_(params) {
    for (std::size_t i = 0; i < scene.world.objects().size(); ++i)
      objects_.push_back({find_shading_points(scene.primary, static_cast<std::int32_t>(i)), {}});
  }

  void trace_pilot() {
    const LightTree tree = make_tree("pilot", 0);
    for (std::size_t i = 0; i < objects_.size(); ++i)
      objects_[i].pilot = cut(i, tree, {kPilotRatio, params_.floor});
  }

  // One set more into the sums.
  void trace_set(std::uint64_t set, std::vector<LayerSums>& sums) {
    const LightTree tree = make_tree("set", set);
    vpls_ += static_cast<double>(tree.vpls.size());
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      const ShadedPoints shaded =
          cut(i, tree, {params_.error_ratio, params_.floor, &objects_[i].pilot, false});
      HdrImage layer(scene_.primary.width, scene_.primary.height);
      add_to_layer(shaded, 0, 0, objects_[i].points, scene_.primary.positions, layer);
      sums[i].add(layer);
    }
  }

  VplSets finish(const std::vector<LayerSums>& sums) const {
    VplSets sets;
    const HdrImage empty(scene_.primary.width, scene_.primary.height);
    for (const LayerSums& sum : sums) sets.layers.push_back(sum.finish(params_.sets, empty));
    sets.mean_vpls = vpls_ / params_.sets;
    sets.mean_clusters = cuts_ > 0 ? clusters_ / cuts_ : 0;
    sets.shadow_rays = rays_;
    return sets;
  }

 private:
  // Of VPLs that no other set has: each set's stream is its own.
  LightTree make_tree(const std::string& kind, std::uint64_t set) const {
    VplSet vpls = trace_vpls(scene_.world, scene_.materials, params_.paths, params_.seed,
                             fmt::format("{}.{}-{}", params_.stream_name, kind, set), params_.emission);
    VplList list = std::move(vpls.shared);
    list.append(vpls.own);
    vpls = {};
    return make_light_tree(std::move(list), {params_.seed + set, 4});
  }

  ShadedPoints cut(std::size_t object, const LightTree& tree, const LightcutParams& rule) {
    CutRecord record;
    ShadedPoints shaded =
        shade_lightcut(scene_.world, objects_[object].points, tree, {scene_.materials[object]},
                       {params_.clamps_per_m2[object]}, rule, &record);
    rays_ += record.shadow_rays;
    if (rule.adaptive) return shaded;
    clusters_ += std::accumulate(record.sizes.begin(), record.sizes.end(), 0.0);
    cuts_ += static_cast<double>(record.sizes.size());
    return shaded;
  }

  const FamilyScene& scene_;
  const VplSetsParams& params_;
  std::vector<ObjectPoints> objects_;
  double vpls_ = 0, clusters_ = 0, cuts_ = 0;
  std::uint64_t rays_ = 0;
};

void check_finite_layers(const VplSets& sets, const std::string& name) {
  std::vector<const TracedLayer*> layers;
  for (const TracedLayer& layer : sets.layers) layers.push_back(&layer);
  check_finite(layers, name);
}

}  // namespace

VplSets trace_vpl_sets(const FamilyScene& scene, const VplSetsParams& params,
                       const std::function<void()>& progress) {
  EQ_CHECK(params.sets >= 2, params.sets);
  EQ_CHECK(params.clamps_per_m2.size() == scene.world.objects().size(), params.clamps_per_m2.size(),
           scene.world.objects().size());
  const HdrImage empty(scene.primary.width, scene.primary.height);
  std::vector<LayerSums> sums(scene.world.objects().size(), LayerSums(empty.values.size()));
  SetTracer tracer(scene, params);
  tracer.trace_pilot();
  progress();
  for (int set = 0; set < params.sets; ++set) {
    tracer.trace_set(static_cast<std::uint64_t>(set) + 1, sums);
    progress();
  }
  VplSets sets = tracer.finish(sums);
  check_finite_layers(sets, params.stream_name + ".sets");
  return sets;
}

}  // namespace equilux
