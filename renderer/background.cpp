// The room as it was planned: paths, sets, or both, whatever of it an interrupted run left.
#include <fmt/format.h>

#include "renderer/reference.h"
#include "renderer/room_format.h"

namespace equilux {
namespace {

// Layers of which one is black where the other is not.
void add_elsewhere(const TracedLayer& from, TracedLayer& to) {
  for (std::size_t i = 0; i < to.mean.values.size(); ++i) {
    to.mean.values[i] += from.mean.values[i];
    to.standard_error.values[i] += from.standard_error.values[i];
  }
}

// Parts of a room that is path traced, each kept when it is whole.
constexpr std::size_t kParts = 8;

PathMap take_part(PathMap map, std::size_t part, std::size_t parts) {
  const std::size_t first = map.size() * part / parts, end = map.size() * (part + 1) / parts;
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (i < first || i >= end) map[i] = 0;
  }
  return map;
}

// A pixel's paths are its own, whatever is traced beside it.
std::vector<TracedLayer> trace_in_parts(const RoomScene& scene, const PathMap& map,
                                        const ReferenceParams& params, const FamilyProgress& progress,
                                        const RoomStages& stages, std::size_t parts) {
  const std::string& name = params.background_stream_name;
  std::vector<TracedLayer> sums;
  for (std::size_t part = 0; part < parts; ++part) {
    const PathMap some = take_part(map, part, parts);
    const auto trace = [&](const std::vector<std::size_t>& which) {
      return trace_backgrounds(scene.world, take_materials(scene.materials, which), scene.primary,
                               {make_background_key(params.seed, name), some, params.measures}, name,
                               progress.advance);
    };
    auto layers = stages.keep_each<TracedLayer>(
        fmt::format("paths-{}-of-{}", part + 1, parts), scene.materials.size(), trace,
        [&] { progress.expect_more(-count_room_paths(scene.primary, some)); });
    if (part == 0) {
      sums = std::move(layers);
    } else {
      for (std::size_t i = 0; i < sums.size(); ++i) add_elsewhere(layers[i], sums[i]);
    }
  }
  return sums;
}

}  // namespace

std::vector<Background> trace_planned_backgrounds(const RoomScene& scene, const BackgroundPlan& plan,
                                                  const ReferenceParams& params,
                                                  const FamilyProgress& progress, const RoomStages& stages) {
  const std::size_t parts = stages.are_kept() && !plan.by_sets ? kParts : 1;
  std::vector<Background> backgrounds;
  for (TracedLayer& layer : trace_in_parts(scene, plan.map, params, progress, stages, parts))
    backgrounds.push_back({std::move(layer)});
  if (!plan.by_sets) return backgrounds;
  std::vector<CompensatedRoom> rooms =
      trace_compensated_rooms(scene, *plan.by_sets, params, progress, stages);
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    add_elsewhere(rooms[i].layer, backgrounds[i].layer);
    backgrounds[i].sets = std::move(rooms[i].measures);
  }
  return backgrounds;
}

}  // namespace equilux
