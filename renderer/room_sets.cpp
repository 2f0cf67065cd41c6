// Position by position: sets, each for all materials.
#include "renderer/room_sets.h"

#include <algorithm>
#include <numeric>

#include "base/error.h"
#include "renderer/vpl_sets.h"

namespace equilux {
namespace {

// Points of one material of the room, and the totals of their rule.
struct Group {
  Material material;
  std::vector<ShadingPoint> points;
  ShadedPoints totals;
};

class RoomTracer {
 public:
  RoomTracer(const RoomScene& scene, const RoomSetsParams& params)
      : scene_(scene),
        params_(params),
        coverage_(make_coverage(scene.primary)),
        sets_of_position_(count_vpl_sets(params.sets, scene.primary.positions) / scene.primary.positions) {
    for (std::size_t i = 0; i < scene.materials.size(); ++i)
      kept_.push_back({PositionSums(count_values()), RegionSums(params.regions, scene.primary.positions)});
  }

  std::vector<RoomSets> trace(const std::function<void()>& progress) {
    for (int position = 0; position < scene_.primary.positions; ++position) {
      const std::vector<Group> groups = find_groups(position);
      std::vector<LayerSums> sums(scene_.materials.size(), LayerSums(count_values()));
      for (int turn = 0; turn < sets_of_position_; ++turn) {
        trace_set(turn * scene_.primary.positions + position, position, groups, sums);
        progress();
      }
      for (std::size_t i = 0; i < kept_.size(); ++i) kept_[i].layer.add(sums[i]);
    }
    return finish();
  }

 private:
  // Of one material of the object.
  struct Kept {
    PositionSums layer;
    RegionSums regions;
    double vpls = 0, clusters = 0;
  };

  std::size_t count_values() const { return 3 * coverage_.pixel_count(); }

  std::vector<Group> find_groups(int position) const {
    std::vector<Group> groups;
    for (auto& points : find_room_points(take_position(scene_.primary, position), coverage_)) {
      ShadedPoints totals = look_up(params_.totals, points);
      groups.push_back(
          {scene_.materials[0][points.front().surface.material], std::move(points), std::move(totals)});
    }
    return groups;
  }

  void trace_set(int set, int position, const std::vector<Group>& groups, std::vector<LayerSums>& sums) {
    const std::string stream = fmt::format("{}.set-{}", params_.stream_name, set + 1);
    const LightTreeParams tree_params{params_.seed + static_cast<std::uint64_t>(set) + 1, 4};
    VplSet first = trace_vpls(scene_.world, scene_.materials[0], params_.paths, params_.seed, stream);
    VplList own = std::move(first.own);
    const LightTree shared = make_light_tree(std::move(first.shared), tree_params);
    double shared_clusters = 0;
    const HdrImage common = cut(shared, groups, stream + ".shared-rays", shared_clusters);
    for (std::size_t i = 0; i < kept_.size(); ++i) {
      if (i > 0) own = trace_own_vpls(scene_.world, scene_.materials[i], first, params_.seed, stream);
      const LightTree tree = make_light_tree(std::move(own), tree_params);
      Kept& kept = kept_[i];
      kept.clusters += shared_clusters;
      kept.vpls += static_cast<double>(shared.vpls.size() + tree.vpls.size());
      HdrImage layer = cut(tree, groups, stream + ".own-rays", kept.clusters);
      for (std::size_t value = 0; value < layer.values.size(); ++value)
        layer.values[value] += common.values[value];
      sums[i].add(layer);
      kept.regions.add(position, {&layer});
    }
  }

  // Of one position. `clusters` grows by a point's in the mean.
  HdrImage cut(const LightTree& tree, const std::vector<Group>& groups, const std::string& stream_name,
               double& clusters) const {
    HdrImage layer(scene_.primary.width, scene_.primary.height);
    double sizes = 0, points = 0;
    for (const Group& group : groups) {
      CutRecord record;
      const ShadedPoints shaded =
          shade_lightcut(scene_.world, group.points, tree, {group.material}, {params_.clamp_per_m2},
                         make_set_rule(params_.error_ratio, params_.floor, group.totals, params_.seed,
                                       fmt::format("{}-{}", stream_name, &group - groups.data())),
                         &record);
      add_to_layer(shaded, 0, 0, group.points, 1, layer);
      sizes = std::accumulate(record.sizes.begin(), record.sizes.end(), sizes);
      points += static_cast<double>(record.sizes.size());
    }
    if (points > 0) clusters += sizes / points;
    return layer;
  }

  std::vector<RoomSets> finish() const {
    const int sets = sets_of_position_ * scene_.primary.positions;
    std::vector<RoomSets> rooms;
    for (const Kept& kept : kept_)
      rooms.push_back({kept.layer.finish(coverage_.width, coverage_.height), sets, kept.vpls / sets,
                       kept.clusters / sets, kept.regions.finish()});
    return rooms;
  }

  const RoomScene& scene_;
  const RoomSetsParams& params_;
  HdrImage coverage_;
  int sets_of_position_;
  std::vector<Kept> kept_;  // by material
};

}  // namespace

std::vector<RoomSets> trace_room_sets(const RoomScene& scene, const RoomSetsParams& params,
                                      const std::function<void()>& progress) {
  EQ_CHECK(params.sets >= 1, params.sets);
  EQ_CHECK(!scene.materials.empty(), scene.materials.size());
  std::vector<RoomSets> rooms = RoomTracer(scene, params).trace(progress);
  std::vector<const TracedLayer*> layers;
  for (const RoomSets& room : rooms) layers.push_back(&room.layer);
  check_finite(layers, params.stream_name + ".sets");
  return rooms;
}

}  // namespace equilux
