// Pilots, plan, sets, compensation, check.
#include "renderer/compensated_room.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/lightcut.h"
#include "renderer/room_format.h"
#include "renderer/room_sets.h"
#include "renderer/vpl.h"
#include "renderer/vpl_sets.h"

namespace equilux {
namespace {

// Sets are taken where they are foreseen to cost less than this share of the paths: what each material's own
// VPLs, the pilots and the check take comes on top.
constexpr double kWorthWhile = 0.5;

// What the room is foreseen to err by over what is asked.
constexpr double kMargin = 0.95;

// Pixels of the pilot of compensation: every so many-th line and column, so that it sees about so many, each
// by so many paths in each batch and at each position.
constexpr double kPilotPixels = 20000;
constexpr std::uint32_t kPilotShare = 1;

// The check: so many pixels, each by so many paths.
constexpr double kCheckedPixels = 6000;
constexpr int kCheckPaths = 256;

// Of what the pilots' object is made.
constexpr float kGrey = 0.19f, kGloss = 0.22f, kRoughness = 0.05f;

bool is_room(const HdrImage& coverage, std::size_t pixel) { return coverage.values[pixel] == 0; }

PathMap mask(PathMap map, const HdrImage& coverage) {
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (!is_room(coverage, i)) map[i] = 0;
  }
  return map;
}

// That leaves about so many pixels of the room.
std::size_t find_stride(const HdrImage& coverage, double pixels) {
  const auto all = std::count(coverage.values.begin(), coverage.values.end(), 0.f);
  return static_cast<std::size_t>(std::max(1.0, std::sqrt(static_cast<double>(all) / pixels)));
}

PathMap make_sparse_map(const HdrImage& coverage, std::size_t stride, std::uint32_t paths) {
  return thin_out(mask(PathMap(coverage.pixel_count(), paths), coverage), coverage.width, stride);
}

// The pilot's background without light that comes straight from the lights: taken away where the pilot saw
// both, so that no edge of a lamp or of a shadow remains.
TracedLayer take_indirect(const RoomPilot& pilot, const TracedLayer& direct, const HdrImage& coverage) {
  TracedLayer layer = pilot.layers.background;
  for (std::size_t i = 0; i < layer.mean.values.size(); ++i) layer.mean.values[i] -= direct.mean.values[i];
  fill_room_between(layer, pilot.seen, coverage, pilot.reach);
  return layer;
}

// Of the room's pixels, whatever share of them it fills: light beside it does not depend on the sets.
HdrImage take_room(const HdrImage& image, const HdrImage& coverage) {
  HdrImage taken = image;
  for (std::size_t i = 0; i < coverage.pixel_count(); ++i) {
    if (!is_room(coverage, i)) std::fill_n(taken.pixel(i), 3, 0.f);
  }
  return taken;
}

Materials make_pilot_materials(const World& world) {
  const MaterialSpec spec{"pilot", {kGrey, kGrey, kGrey}, {kGloss, kGloss, kGloss}, kRoughness};
  return make_materials(world, std::vector(world.objects().size(), spec));
}

TracedLayer trace_direct(const World& world, const Primary& primary, const PathMap& map,
                         const ReferenceParams& params, const std::string& name,
                         const FamilyProgress& progress) {
  const std::string stream = params.background_stream_name + name;
  const BatchJob job{make_stream_key(params.seed, stream + ".room-direct"), map, params.measures};
  return trace_room_direct(world, primary, job, stream, progress.advance);
}

std::vector<TracedLayer> compensate(const RoomScene& scene, const PathMap& map, std::vector<double> clamps,
                                    const ReferenceParams& params, const std::string& name,
                                    const FamilyProgress& progress, CompensationRecord* record = nullptr) {
  const CompensationParams compensation{std::move(clamps), Emission::kLambertian, params.seed,
                                        params.background_stream_name + name, params.measures};
  return trace_room_compensation(scene, map, compensation, progress.advance, record);
}

// Eight sets tell one region's spread badly: by four degrees of freedom one region of five hundred would
// differ by seven standard errors. So none counts as surer than all are in the root mean square, relative to
// their light.
std::vector<RegionLight> steady(std::vector<RegionLight> regions) {
  double squares = 0, count = 0;
  for (const RegionLight& region : regions) {
    if (!(region.mean > 0)) continue;
    squares += std::pow(region.standard_error / region.mean, 2);
    ++count;
  }
  if (count == 0) return regions;
  const double relative = std::sqrt(squares / count);
  for (RegionLight& region : regions)
    region.standard_error = std::max(region.standard_error, relative * region.mean);
  return regions;
}

// In which a whole picture's regions are told apart.
HdrImage make_whole_room(const HdrImage& coverage) {
  HdrImage share(coverage.width, coverage.height, 1);
  for (std::size_t i = 0; i < coverage.pixel_count(); ++i) share.values[i] = is_room(coverage, i) ? 1 : 0;
  return share;
}

}  // namespace

std::optional<RoomPlan> plan_compensated_room(const World& world, const Primary& primary,
                                              const RoomPilot& pilot, const ReferenceParams& params,
                                              const FamilyProgress& progress) {
  const HdrImage coverage = make_coverage(primary);
  const double most_cost = kWorthWhile * count_room_paths(primary, mask(pilot.planned, coverage));
  const PathMap few = mask(pilot.maps.background, coverage);
  const std::size_t stride = find_stride(coverage, kPilotPixels);
  const PathMap seen = make_sparse_map(coverage, stride, kPilotShare);
  progress.expect_more(count_room_paths(primary, few) + count_room_paths(primary, seen));
  const TracedLayer direct = trace_direct(world, primary, few, params, ".pilot", progress);
  const Materials glossy = make_pilot_materials(world);
  CompensationRecord record;
  auto returned = compensate({world, {&glossy, 1}, primary}, seen, list_finite_clamps(), params, ".pilot",
                             progress, &record);
  for (TracedLayer& layer : returned) fill_room_between(layer, seen, coverage, static_cast<int>(stride));
  const DisplayPilot view(
      {&pilot.layers.background.mean, &pilot.layers.direct.mean, &pilot.layers.indirect.mean}, coverage,
      params.tone);
  const std::vector<double> direct_errors = view.find_errors(direct, few);
  const SetPilot sets{view,
                      make_room_subject(primary, coverage),
                      direct_errors,
                      take_indirect(pilot, direct, coverage),
                      [&](std::size_t level) { return returned[level]; },
                      std::move(record),
                      seen,
                      PathMap(seen.size(), kPilotShare),
                      1,
                      take_room(direct.mean, coverage)};
  NoiseTarget target = params.target;
  target.object_mean = kMargin * params.target.outside_mean;
  target.object_p99 = std::numeric_limits<double>::infinity();
  const Materials grey = make_grey_materials(world);
  std::optional<SetPlan> plan = plan_vpl_sets({world, grey, primary}, sets, target, most_cost, params.seed,
                                              params.background_stream_name);
  if (!plan) return {};
  PathMaps maps = allot_paths(
      {plan->compensation_errors, direct_errors, std::vector<double>(seen.size()), plan->set_errors},
      coverage, primary.positions, params.target);
  return RoomPlan{std::move(*plan), find_radiance_of_step(view.tone().record, 1),
                  mask(std::move(maps.direct), coverage), mask(std::move(maps.background), coverage)};
}

double count_room_work(const Primary& primary, const RoomPlan& plan) {
  return plan.sets.sets_cost + count_room_paths(primary, plan.direct) +
         count_room_paths(primary, plan.compensation);
}

std::vector<CompensatedRoom> trace_compensated_rooms(const RoomScene& scene, const RoomPlan& plan,
                                                     const ReferenceParams& params,
                                                     const FamilyProgress& progress,
                                                     const RoomStages& stages) {
  const auto& [world, materials, primary] = scene;
  const HdrImage coverage = make_coverage(primary);
  const std::string& name = params.background_stream_name;
  using Places = std::vector<std::size_t>;
  const auto skip = [&](const PathMap& map) {
    return [&] { progress.expect_more(-count_room_paths(primary, map)); };
  };
  const TracedLayer direct = stages.keep<TracedLayer>(
      "direct", [&] { return trace_direct(world, primary, plan.direct, params, "", progress); },
      skip(plan.direct));
  const auto returned = stages.keep_each<TracedLayer>(
      "compensation", materials.size(),
      [&](const Places& which) {
        const std::vector<Materials> some = take_materials(materials, which);
        return compensate({world, some, primary}, plan.compensation, {clamp_per_m2(plan.sets.clamp_level)},
                          params, "", progress);
      },
      skip(plan.compensation));
  const auto check_share = static_cast<std::uint32_t>(round_paths(kCheckPaths, primary.positions) /
                                                      (kBatches * primary.positions));
  const PathMap checked = make_sparse_map(coverage, find_stride(coverage, kCheckedPixels), check_share);
  progress.expect_more(count_room_paths(primary, checked));
  const auto traced = stages.keep_each<TracedLayer>(
      "check", materials.size(),
      [&](const Places& which) {
        return trace_backgrounds(
            world, take_materials(materials, which), primary,
            {make_background_key(params.seed, name + ".check"), checked, params.measures}, name + ".check",
            progress.advance);
      },
      skip(checked));
  const std::vector<int> regions = find_regions(make_whole_room(coverage), checked);
  const RoomSetsParams sets_params{plan.sets.sets,
                                   find_path_count(world, plan.sets.vpls, params.seed),
                                   clamp_per_m2(plan.sets.clamp_level),
                                   plan.sets.error_ratio,
                                   kFloorSteps * plan.step,
                                   params.seed,
                                   name,
                                   plan.sets.light,
                                   regions};
  const auto trace_sets = [&](const Places& which) {
    const std::vector<Materials> some = take_materials(materials, which);
    std::vector<RoomSets> made;
    with_vpl_memory(plan.sets.vpls, [&] {
      made = trace_room_sets({world, some, primary}, sets_params,
                             [&] { progress.advance(plan.sets.sets_cost / plan.sets.sets); });
    });
    return made;
  };
  std::vector<RoomSets> sets = stages.keep_each<RoomSets>(
      "sets", materials.size(), trace_sets, [&] { progress.expect_more(-plan.sets.sets_cost); });
  std::vector<CompensatedRoom> rooms;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    TracedLayer beside = direct;
    add_independent(beside, returned[i]);
    CompensatedRoom room{
        std::move(sets[i].layer),
        {plan.sets.clamp_level, sets[i].sets, sets[i].mean_vpls, plan.sets.error_ratio, sets[i].mean_clusters,
         count_room_paths(primary, plan.compensation),
         check_regions(steady(std::move(sets[i].regions)), beside, traced[i], regions, plan.step)}};
    add_independent(room.layer, beside);
    rooms.push_back(std::move(room));
  }
  return rooms;
}

}  // namespace equilux
