// Pilot, sets, mean.
#include "renderer/vpl_sets.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"

namespace equilux {
namespace {

// Of the pilot: its totals are only thresholds.
constexpr double kPilotRatio = 0.0075;

// What the camera sees of one object through one subpixel position, and the totals of its rule.
struct PositionPoints {
  std::vector<ShadingPoint> points;
  ShadedPoints totals;
  LayerSums sums;
};

class SetTracer {
 public:
  SetTracer(const FamilyScene& scene, const VplSetsParams& params)
      : scene_(scene),
        params_(params),
        positions_(scene.primary.positions),
        regions_(params.regions, scene.primary.positions) {
    std::vector<Primary> taken;
    for (int position = 0; position < positions_; ++position)
      taken.push_back(take_position(scene.primary, position));
    for (std::size_t i = 0; i < scene.world.objects().size(); ++i) {
      for (const Primary& primary : taken)
        parts_.push_back({find_shading_points(primary, static_cast<std::int32_t>(i)),
                          {},
                          LayerSums(make_black().values.size())});
    }
  }

  int count_sets() const { return count_vpl_sets(params_.sets, positions_); }

  void use_totals() {
    for (std::size_t object = 0; object < count_objects(); ++object) {
      for (int position = 0; position < positions_; ++position) {
        PositionPoints& part = at(object, position);
        part.totals = look_up(params_.totals[object], part.points);
      }
    }
  }

  void trace_pilot() {
    const LightTree tree = make_tree("pilot", 0);
    for (std::size_t object = 0; object < count_objects(); ++object) {
      for (int position = 0; position < positions_; ++position) {
        PositionPoints& part = at(object, position);
        part.totals = cut(object, part.points, tree, {kPilotRatio, params_.floor});
      }
    }
  }

  // One set more, seen through one position.
  void trace_set(int set) {
    const LightTree tree = make_tree("set", static_cast<std::uint64_t>(set) + 1);
    vpls_ += static_cast<double>(tree.vpls.size());
    std::vector<HdrImage> layers;
    for (std::size_t object = 0; object < count_objects(); ++object) {
      PositionPoints& part = at(object, set % positions_);
      const std::string stream = fmt::format("{}.rays-{}-{}", params_.stream_name, set + 1, object);
      const ShadedPoints shaded = cut(object, part.points, tree,
                                      make_set_rule(params_.error_ratio, params_.floor, part.totals,
                                                    params_.seed, stream, params_.roulette_of_ratio));
      layers.push_back(make_black());
      add_to_layer(shaded, 0, 0, part.points, 1, layers.back());
      part.sums.add(layers.back());
    }
    std::vector<const HdrImage*> all;
    for (const HdrImage& layer : layers) all.push_back(&layer);
    regions_.add(set % positions_, all);
  }

  VplSets finish() const {
    VplSets sets;
    sets.sets = count_sets();
    for (std::size_t object = 0; object < count_objects(); ++object) {
      PositionSums sums(make_black().values.size());
      for (int position = 0; position < positions_; ++position)
        sums.add(parts_[index_of(object, position)].sums);
      sets.layers.push_back(sums.finish(scene_.primary.width, scene_.primary.height));
    }
    sets.mean_vpls = vpls_ / sets.sets;
    sets.mean_clusters = cuts_ > 0 ? clusters_ / cuts_ : 0;
    sets.shadow_rays = rays_;
    sets.regions = regions_.finish();
    return sets;
  }

 private:
  // Of VPLs that no other set has: each set's stream is its own.
  LightTree make_tree(const std::string& kind, std::uint64_t set) const {
    return make_light_tree(
        join_vpls(trace_vpls(scene_.world, scene_.materials, params_.paths, params_.seed,
                             fmt::format("{}.{}-{}", params_.stream_name, kind, set), params_.emission)),
        {params_.seed + set, 4});
  }

  HdrImage make_black() const { return HdrImage(scene_.primary.width, scene_.primary.height); }

  std::size_t count_objects() const { return scene_.world.objects().size(); }

  std::size_t index_of(std::size_t object, int position) const {
    return object * static_cast<std::size_t>(positions_) + static_cast<std::size_t>(position);
  }
  PositionPoints& at(std::size_t object, int position) { return parts_[index_of(object, position)]; }

  ShadedPoints cut(std::size_t object, const std::vector<ShadingPoint>& points, const LightTree& tree,
                   const LightcutParams& rule) {
    CutRecord record;
    ShadedPoints shaded = shade_lightcut(scene_.world, points, tree, {scene_.materials[object]},
                                         {params_.clamps_per_m2[object]}, rule, &record);
    rays_ += record.shadow_rays;
    if (rule.adaptive) return shaded;
    clusters_ += std::accumulate(record.sizes.begin(), record.sizes.end(), 0.0);
    cuts_ += static_cast<double>(record.sizes.size());
    return shaded;
  }

  const FamilyScene& scene_;
  const VplSetsParams& params_;
  int positions_;
  std::vector<PositionPoints> parts_;  // shape: object x position
  RegionSums regions_;
  double vpls_ = 0, clusters_ = 0, cuts_ = 0;
  std::uint64_t rays_ = 0;
};

void check_finite_layers(const VplSets& sets, const std::string& name) {
  std::vector<const TracedLayer*> layers;
  for (const TracedLayer& layer : sets.layers) layers.push_back(&layer);
  check_finite(layers, name);
}

}  // namespace

LightcutParams make_set_rule(double error_ratio, double floor, const ShadedPoints& totals, std::uint64_t seed,
                             const std::string& stream_name, double roulette_of_ratio) {
  return {error_ratio, floor,       &totals,
          false,       kNeighbours, {roulette_of_ratio * error_ratio, make_stream_key(seed, stream_name)}};
}

Primary take_position(const Primary& primary, int position) {
  Primary taken{primary.width, primary.height, 1, {}};
  for (std::size_t i = static_cast<std::size_t>(position); i < primary.hits.size();
       i += static_cast<std::size_t>(primary.positions))
    taken.hits.push_back(primary.hits[i]);
  return taken;
}

int count_vpl_sets(int sets, int positions) {
  return std::max(2, (sets + positions - 1) / positions) * positions;
}

VplSets trace_vpl_sets(const FamilyScene& scene, const VplSetsParams& params,
                       const std::function<void()>& progress) {
  EQ_CHECK(params.sets >= 1, params.sets);
  EQ_CHECK(params.clamps_per_m2.size() == scene.world.objects().size(), params.clamps_per_m2.size(),
           scene.world.objects().size());
  EQ_CHECK(params.totals.empty() || params.totals.size() == params.clamps_per_m2.size(),
           params.totals.size());
  SetTracer tracer(scene, params);
  if (params.totals.empty()) {
    tracer.trace_pilot();
    progress();
  } else {
    tracer.use_totals();
  }
  for (int set = 0; set < tracer.count_sets(); ++set) {
    tracer.trace_set(set);
    progress();
  }
  VplSets sets = tracer.finish();
  check_finite_layers(sets, params.stream_name + ".sets");
  return sets;
}

}  // namespace equilux
