// Pilot, allotment, paths.
#include "renderer/reference.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "renderer/room_format.h"
#include "renderer/turns.h"

namespace equilux {
namespace {

// Rough numbers of paths for an error of one displayed step. They only foresee progress.
constexpr double kPathsForOneStepOnObject = 6000;
constexpr double kPathsForOneStepOutside = 4700;

// Work of compensated VPL sets over that of path tracing, of a black object and more for what its gloss
// reflects, and of their pilots whatever the object's size. Measured in the café.
constexpr double kCompensatedShare = 0.0247, kShareOfGloss = 0.185, kSetPilots = 3.4e6;
// The same of the room, whose sets cost something at every pixel whatever the target, and whose pilots
// whatever is chosen.
constexpr double kCompensatedRoom = 0.082, kRoomSets = 225, kRoomPilots = 3e6;
// Pilots look at every pixel of small pictures.
constexpr double kPilotsOfPixel = 51, kPilotsOfObjectPixel = 210;

// Enough for the spread of a pixel to be seen, few beside what follows.
constexpr int kPilotPaths = 32;

PathMaps make_pilot_maps(const Primary& primary) {
  return make_fixed_maps(primary, {kPilotPaths, kPilotPaths, kPilotPaths});
}

PathCounts guess_counts(const NoiseTarget& target) {
  const auto paths = [](double at_one_step, double steps) {
    return static_cast<int>(std::clamp(at_one_step / (steps * steps), 1.0, 1e6));
  };
  return {paths(kPathsForOneStepOnObject, target.object_mean), 1,
          paths(kPathsForOneStepOutside, target.outside_mean)};
}

// A percentile under this many means is met by few paths more or missed: the worst pixels must be known well.
constexpr double kSteepPercentile = 2.5;
// The second pilot's share of the paths that the first allots.
constexpr std::uint32_t kSecondShare = 8;

// Of the room's paths where an object is seen too, whose material may take another share of the error than
// grey does: few pixels.
constexpr std::uint32_t kSilhouetteMargin = 2;

PathMap take_share(PathMap map, const PathMap& least) {
  for (std::size_t i = 0; i < map.size(); ++i)
    map[i] = std::max(least[i], (map[i] + kSecondShare - 1) / kSecondShare);
  return map;
}

PathMaps allot_by(const TracedLayers& pilot, const PathMaps& maps, const HdrImage& coverage, int positions,
                  const ReferenceParams& params) {
  return allot_paths(pilot, maps, coverage, positions, params.tone, params.target);
}

PathMap make_no_paths(const PathMap& map) { return PathMap(map.size(), 0); }

// A pilot's smoothed spread lies above what many paths show, so that the room would err by less than is
// asked. A second pilot takes the planned paths at every so many-th line and column: as many pixels as tell
// the mean error to a fiftieth.
constexpr double kLookedAt = 6000;
// What the room is foreseen to err by over what is asked: that the pixels are few and grey is not every
// material.
constexpr double kMarginOfRoom = 0.93;
// Against a second pilot that saw hardly anything.
constexpr double kLeastScale = 0.4, kMostScale = 2.5;

// 0 where pixels outside the object are too few for it to be worth while.
std::size_t find_look_stride(const HdrImage& coverage) {
  const auto outside = std::count(coverage.values.begin(), coverage.values.end(), 0.f);
  const auto stride = static_cast<std::size_t>(std::sqrt(static_cast<double>(outside) / kLookedAt));
  return stride < 2 ? 0 : stride;
}

// The pilot's picture, the room as it was looked at: a curve from pixels of few paths would be too bright,
// since noise lowers a mean of logarithms.
HdrImage show_look(const TracedLayers& pilot, const TracedLayer& look, const PathMap& map,
                   std::size_t stride) {
  HdrImage image = composite({&pilot.background.mean, &pilot.direct.mean, &pilot.indirect.mean});
  const auto width = static_cast<std::size_t>(image.width);
  for (std::size_t i = 0; i < map.size(); ++i) {
    const std::size_t x = i % width, y = i / width, seen = (y - y % stride) * width + x - x % stride;
    if (map[seen] > 0) std::copy_n(look.mean.pixel(seen), 3, image.pixel(i));
  }
  return image;
}

std::uint32_t scale_paths(std::uint32_t paths, double scale) {
  return static_cast<std::uint32_t>(std::max(1L, std::lround(scale * paths)));
}

// What the room's paths are to be multiplied by, so that the mean displayed error of those pixels becomes
// what is asked; paths are whole numbers, and few where much error is allowed.
double find_scale(const std::vector<double>& noise, const PathMap& map, double target) {
  const auto mean_after = [&](double scale) {
    double sum = 0, pixels = 0;
    for (std::size_t i = 0; i < map.size(); ++i) {
      if (map[i] == 0) continue;
      sum += noise[i] * std::sqrt(static_cast<double>(map[i]) / scale_paths(map[i], scale));
      ++pixels;
    }
    return sum / pixels;
  };
  double low = kLeastScale, high = kMostScale;
  for (int i = 0; i < 30; ++i) {
    const double middle = (low + high) / 2;
    (mean_after(middle) > target ? low : high) = middle;
  }
  return high;
}

// In a map, of a batch and position.
std::uint32_t find_most_paths(const Primary& primary) {
  return static_cast<std::uint32_t>(kMostPathsAPixel / (kBatches * primary.positions));
}

double count_object(const Primary& primary, const PathMaps& maps) {
  return count_paths(primary, {make_no_paths(maps.direct), maps.direct, maps.indirect});
}

double count_object_pixels(const Primary& primary) {
  const auto hits = std::count_if(primary.hits.begin(), primary.hits.end(),
                                  [](const PrimaryHit& hit) { return hit.kind == PrimaryKind::kObject; });
  return static_cast<double>(hits) / primary.positions;
}

PathMaps guess_maps(const ReferenceParams& params, const Primary& primary) {
  return make_fixed_maps(primary, params.fixed ? *params.fixed : guess_counts(params.target));
}

}  // namespace

std::string name_background_stream(const Family& family) {
  return fmt::format("{}-{}-v{}", family.object.geometry, format_illumination(family.object.illumination),
                     family.view);
}

ReferenceParams make_reference_params(const Study& study, const Scene& scene, const Family& family) {
  ReferenceParams params;
  params.fixed = study.paths;
  params.target = study.noise_target;
  params.method = study.reference;
  params.tone = study.planned_tone;
  params.gloss = luminance(find_material(scene, family.object.material).rho_s);
  params.seed = study.seed;
  params.stream_name = format_key(family);
  params.background_stream_name = name_background_stream(family);
  return params;
}

namespace {

double guess_background_paths(const ReferenceParams& params, const Primary& primary, double pixels = 1) {
  const double traced = pixels * count_room_paths(primary, guess_maps(params, primary).background);
  if (params.fixed || params.method != ReferenceMethod::kCompensated) return traced;
  const PathMap one(primary.hits.size() / static_cast<std::size_t>(primary.positions), 1);
  const double all = pixels * static_cast<double>(one.size());
  const double outside = pixels * count_room_paths(primary, one) / (kBatches * primary.positions);
  return std::min(kRoomPilots, kPilotsOfPixel * all) +
         std::min(traced, kCompensatedRoom * traced + kRoomSets * outside);
}

}  // namespace

double estimate_background_paths(const ReferenceParams& params, const Primary& primary, double pixels) {
  const double work = guess_background_paths(params, primary, pixels);
  return params.fixed ? work : work + pixels * count_paths(primary, make_pilot_maps(primary));
}

double estimate_object_paths(const ReferenceParams& params, const Primary& primary, double pixels) {
  const double traced = pixels * count_object(primary, guess_maps(params, primary));
  if (params.fixed) return traced;
  if (params.method == ReferenceMethod::kCompensated)
    return (kCompensatedShare + kShareOfGloss * params.gloss) * traced +
           std::min(kSetPilots, kPilotsOfObjectPixel * pixels * count_object_pixels(primary));
  return traced + pixels * count_object(primary, make_pilot_maps(primary));
}

namespace {

// Else by path tracing alone.
bool is_by_sets(const World& world, const ReferenceParams& params) {
  return !params.fixed && params.method == ReferenceMethod::kCompensated && world.objects().size() == 1;
}

// Scales the room's paths to what they are seen to do.
void look_again(const World& world, const Primary& primary, const TracedLayers& pilot,
                const HdrImage& coverage, const ReferenceParams& params, const FamilyProgress& progress,
                PathMap& map) {
  const std::size_t stride = find_look_stride(coverage);
  if (stride == 0) return;
  PathMap some = thin_out(map, coverage.width, stride);
  for (std::size_t i = 0; i < some.size(); ++i) {
    if (coverage.values[i] > 0) some[i] = 0;
  }
  progress.expect_more(count_room_paths(primary, some));
  const TracedLayer look =
      trace_layers({world, make_grey_materials(world), primary},
                   {some, make_no_paths(map), make_no_paths(map)}, params.seed,
                   params.background_stream_name + ".second-pilot", params.measures, progress.advance)
          .background;
  const HdrImage shown = show_look(pilot, look, some, stride);
  const std::vector<double> noise =
      measure_pixel_noise(shown, look.standard_error, make_tone_curve(shown, coverage, params.tone));
  const double scale = find_scale(noise, some, kMarginOfRoom * params.target.outside_mean);
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (coverage.values[i] == 0) map[i] = scale_paths(map[i], scale);
  }
}

// Every pixel of a small room; of a large one that sets may make, whose rule needs less, every second or
// third line and column.
constexpr double kLargeRoom = 24000, kLargestRoom = 90000;

std::size_t find_room_stride(const World& world, const HdrImage& coverage, const ReferenceParams& params) {
  const auto room = static_cast<double>(std::count(coverage.values.begin(), coverage.values.end(), 0.f));
  if (!is_by_sets(world, params) || room < kLargeRoom) return 1;
  return room < kLargestRoom ? 2 : 3;
}

// Every pixel of a small object, every second or third line and column of a large one.
std::size_t find_pilot_stride(const HdrImage& coverage) {
  const auto pixels = std::count_if(coverage.values.begin(), coverage.values.end(),
                                    [](float covered) { return covered > 0; });
  return pixels <= 4000 ? 1 : pixels <= 32000 ? 2 : 3;
}

// The object's part of a pilot at some of its pixels, and between them; gives how far these are apart.
int thin_out_object(PathMaps& maps, const HdrImage& coverage) {
  const std::size_t stride = find_pilot_stride(coverage);
  maps.direct = thin_out(maps.direct, coverage.width, stride);
  maps.indirect = thin_out(maps.indirect, coverage.width, stride);
  return 1 + static_cast<int>(stride);
}

void fill_object_between(TracedLayers& pilot, const PathMaps& seen, const HdrImage& coverage, int reach) {
  for (TracedLayer* layer : {&pilot.direct, &pilot.indirect})
    fill_between(*layer, seen.indirect, coverage, reach);
}

// By pilots.
BackgroundPlan foresee_background(const World& world, const Primary& primary, const ReferenceParams& params,
                                  const FamilyProgress& progress) {
  const PathMaps few = make_pilot_maps(primary);
  const HdrImage coverage = make_coverage(primary);
  const std::size_t stride = find_room_stride(world, coverage, params);
  PathMaps some = few;
  some.background = thin_out(few.background, coverage.width, stride);
  for (std::size_t i = 0; i < coverage.pixel_count(); ++i) {
    if (coverage.values[i] > 0) some.background[i] = few.background[i];
  }
  const int object_reach = stride > 1 ? thin_out_object(some, coverage) : 0;
  progress.expect_more(count_paths(primary, some) - count_paths(primary, few));
  TracedLayers pilot =
      trace_layers({world, make_grey_materials(world), primary}, some, params.seed,
                   params.background_stream_name + ".pilot", params.measures, progress.advance);
  const int reach = static_cast<int>(stride);
  if (stride > 1) {
    fill_room_between(pilot.background, some.background, coverage, reach);
    fill_object_between(pilot, some, coverage, object_reach);
  }
  PathMap map = allot_by(pilot, few, coverage, primary.positions, params).background;
  std::optional<RoomPlan> by_sets;
  if (is_by_sets(world, params))
    by_sets =
        plan_compensated_room(world, primary, {pilot, few, some.background, reach, map}, params, progress);
  if (!by_sets) look_again(world, primary, pilot, coverage, params, progress, map);
  const std::uint32_t most = find_most_paths(primary);
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (coverage.values[i] > 0) {
      map[i] = std::min(map[i] * kSilhouetteMargin, most);
    } else if (by_sets) {
      map[i] = 0;
    }
  }
  return {std::move(map), std::move(by_sets), few.background, std::move(pilot.background)};
}

}  // namespace

BackgroundPlan plan_background(const World& world, const Primary& primary, const ReferenceParams& params,
                               const FamilyProgress& progress, const RoomStages& stages) {
  if (params.fixed) return {make_fixed_maps(primary, *params.fixed).background};
  BackgroundPlan plan = stages.keep<BackgroundPlan>(
      "plan", [&] { return foresee_background(world, primary, params, progress); },
      [&] { progress.expect_more(-count_paths(primary, make_pilot_maps(primary))); });
  progress.expect_more(count_room_paths(primary, plan.map) +
                       (plan.by_sets ? count_room_work(primary, *plan.by_sets) : 0) -
                       guess_background_paths(params, primary));
  return plan;
}

namespace {

// A pilot of the object, and beside it the room's.
struct PathPilot {
  TracedLayers layers;
  PathMaps maps;
};

PathPilot fly(const FamilyScene& scene, const BackgroundPlan& plan, PathMaps maps,
              const ReferenceParams& params, const std::string& name, const FamilyProgress& progress) {
  maps.background = make_no_paths(plan.map);
  TracedLayers layers =
      trace_layers(scene, maps, params.seed, params.stream_name + name, params.measures, progress.advance);
  layers.background = plan.pilot;
  maps.background = plan.pilot_map;
  return {std::move(layers), std::move(maps)};
}

PathMaps allot_by_pilots(const FamilyScene& scene, const BackgroundPlan& plan, const ReferenceParams& params,
                         const FamilyProgress& progress) {
  const HdrImage coverage = make_coverage(scene.primary);
  const auto allot = [&](const PathPilot& by) {
    PathMaps maps = allot_by(by.layers, by.maps, coverage, scene.primary.positions, params);
    maps.background = make_no_paths(plan.map);
    return maps;
  };
  const PathMaps first = make_pilot_maps(scene.primary);
  PathMaps maps = allot(fly(scene, plan, first, params, ".pilot", progress));
  if (params.target.object_p99 < kSteepPercentile * params.target.object_mean) {
    const PathMaps share{make_no_paths(plan.map), take_share(maps.direct, first.direct),
                         take_share(maps.indirect, first.indirect)};
    progress.expect_more(count_object(scene.primary, share));
    maps = allot(fly(scene, plan, share, params, ".second-pilot", progress));
  }
  progress.expect_more(count_object(scene.primary, maps) -
                       count_object(scene.primary, guess_maps(params, scene.primary)));
  return maps;
}

ObjectPilot fly_between(const FamilyScene& scene, const BackgroundPlan& plan, const ReferenceParams& params,
                        const FamilyProgress& progress) {
  const HdrImage coverage = make_coverage(scene.primary);
  PathMaps all = make_pilot_maps(scene.primary), some = all;
  const int reach = thin_out_object(some, coverage);
  progress.expect_more(count_object(scene.primary, some));
  PathPilot pilot = fly(scene, plan, some, params, ".sparse-pilot", progress);
  fill_object_between(pilot.layers, some, coverage, reach);
  all.background = plan.pilot_map;
  return {std::move(pilot.layers), std::move(all), std::move(some.indirect), reach};
}

FamilyLayers join_layers(TracedLayers layers, double paths) {
  HdrImage standard_error = combine_standard_errors(layers);
  return {std::move(layers.background.mean), std::move(layers.direct.mean), std::move(layers.indirect.mean),
          std::move(standard_error), paths};
}

FamilyLayers trace_by_paths(const FamilyScene& scene, const PathMaps& maps, TracedLayer background,
                            const ReferenceParams& params, const FamilyProgress& progress) {
  TracedLayers layers =
      trace_layers(scene, maps, params.seed, params.stream_name, params.measures, progress.advance);
  layers.background = std::move(background);
  return join_layers(std::move(layers), count_object(scene.primary, maps));
}

// What was foreseen can be missed. Of the object another rendering is then added, from other random numbers;
// the room is thrown away and made again, with so many more. A bias of second order: what stays as it is met
// the target by its own estimate of error, which bright rare paths raise; where another is added they lose
// some of their weight.
constexpr int kMostTurns = 4;
// The room's mean error is known from many pixels.
constexpr double kRoomTurnMargin = 1.03;

// Error over target: over 1 where it is missed.
struct Miss {
  double object = 0, room = 0;
};

Miss find_miss(const FamilyLayers& layers, const HdrImage& coverage, const ReferenceParams& params) {
  const HdrImage reference = composite({&layers.background, &layers.direct, &layers.indirect});
  const DisplayNoise noise = measure_display_noise(reference, layers.standard_error, coverage,
                                                   make_tone_curve(reference, coverage, params.tone));
  const NoiseTarget& target = params.target;
  return {std::max(noise.object_mean / target.object_mean, noise.object_p99 / target.object_p99),
          noise.outside_mean / target.outside_mean};
}

void scale_map(PathMap& map, double scale, std::uint32_t most) {
  for (std::uint32_t& paths : map) {
    if (paths > 0) paths = std::max(paths, std::min(scale_paths(paths, scale), most));
  }
}

// The room beside this object alone, by `scale` times the paths and sets, from other random numbers.
Background trace_room_again(const FamilyScene& scene, const BackgroundPlan& plan, double scale,
                            const ReferenceParams& params, int turn, const FamilyProgress& progress) {
  BackgroundPlan more = plan;
  const std::uint32_t most = find_most_paths(scene.primary);
  scale_map(more.map, scale, most);
  if (more.by_sets) {
    scale_map(more.by_sets->direct, scale, most);
    scale_map(more.by_sets->compensation, scale, most);
    more.by_sets->sets = take_more_sets(std::move(more.by_sets->sets), scale, scene.primary.positions);
  }
  ReferenceParams again = params;
  again.background_stream_name = fmt::format("{}.room-turn-{}", params.stream_name, turn);
  progress.expect_more(count_room_paths(scene.primary, more.map) +
                       (more.by_sets ? count_room_work(scene.primary, *more.by_sets) : 0));
  return std::move(trace_planned_backgrounds({scene.world, {&scene.materials, 1}, scene.primary}, more, again,
                                             progress)[0]);
}

}  // namespace

PathMaps allot_object(const FamilyScene& scene, const BackgroundPlan& plan, const ReferenceParams& params,
                      const FamilyProgress& progress) {
  if (!params.fixed) return allot_by_pilots(scene, plan, params, progress);
  PathMaps maps = make_fixed_maps(scene.primary, *params.fixed);
  maps.background = make_no_paths(plan.map);
  return maps;
}

namespace {

// Whether or not it meets the target.
FamilyLayers trace_once(const FamilyScene& scene, const BackgroundPlan& plan, TracedLayer background,
                        const ReferenceParams& params, const FamilyProgress& progress) {
  if (is_by_sets(scene.world, params)) {
    progress.expect_more(-estimate_object_paths(params, scene.primary));
    const ObjectPilot pilot = fly_between(scene, plan, params, progress);
    if (std::optional<CompensatedObject> object = trace_compensated(scene, pilot, params, progress)) {
      FamilyLayers layers = join_layers(
          {std::move(background), std::move(object->direct), std::move(object->indirect)}, object->paths);
      layers.sets = std::move(object->measures);
      return layers;
    }
    ReferenceParams by_paths = params;
    by_paths.method = ReferenceMethod::kPath;
    progress.expect_more(estimate_object_paths(by_paths, scene.primary));
  }
  return trace_by_paths(scene, allot_object(scene, plan, params, progress), std::move(background), params,
                        progress);
}

}  // namespace

FamilyLayers trace_object(const FamilyScene& scene, const BackgroundPlan& plan, const Background& background,
                          const ReferenceParams& params, const FamilyProgress& progress) {
  FamilyLayers layers = trace_once(scene, plan, background.layer, params, progress);
  layers.room = background.sets;
  if (params.fixed) return layers;
  Background room = background;
  double room_scale = 1;
  for (int turn = 1; turn < kMostTurns; ++turn) {
    const Miss miss = find_miss(layers, make_coverage(scene.primary), params);
    if (miss.object <= 1 && miss.room <= 1) break;
    if (miss.room > 1) {
      // Where sets make it, whose pixels err alike, no better than the object's.
      const double margin = plan.by_sets ? kTurnMargin : kRoomTurnMargin;
      room_scale *= margin * margin * miss.room * miss.room;
      Background other = trace_room_again(scene, plan, room_scale, params, turn, progress);
      exchange_room(layers, room.layer, other.layer);
      room = std::move(other);
      ++layers.room_turns;
    }
    if (miss.object > 1) {
      const Addition addition = find_addition(miss.object);
      ReferenceParams other = params;
      other.target.object_mean *= addition.target;
      other.target.object_p99 *= addition.target;
      other.stream_name = fmt::format("{}.turn-{}", params.stream_name, turn);
      if (!layers.sets) other.method = ReferenceMethod::kPath;  // no light of VPLs without a check of it
      progress.expect_more(estimate_object_paths(other, scene.primary));
      add_turn(layers, trace_once(scene, plan, room.layer, other, progress), room.layer, addition.share);
    }
    layers.room = room.sets;
  }
  return layers;
}

FamilyLayers trace_family(const FamilyScene& scene, const ReferenceParams& params,
                          const FamilyProgress& progress) {
  const BackgroundPlan plan = plan_background(scene.world, scene.primary, params, progress);
  const std::vector<Background> background =
      trace_planned_backgrounds({scene.world, {&scene.materials, 1}, scene.primary}, plan, params, progress);
  FamilyLayers layers = trace_object(scene, plan, background[0], params, progress);
  layers.paths += count_room_paths(scene.primary, plan.map);
  if (layers.room) layers.paths += layers.room->compensation_paths;
  return layers;
}

}  // namespace equilux
