// Pilots, plan, sets, compensation, check.
#include "renderer/compensated.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "renderer/lightcut.h"
#include "renderer/set_plan.h"
#include "renderer/vpl.h"

namespace equilux {
namespace {

PathMap make_even_map(const PathMap& like, std::uint32_t paths) { return PathMap(like.size(), paths); }

double count_object_paths(const Primary& primary, const PathMap& map) {
  const PathMap none = make_even_map(map, 0);
  return count_paths(primary, {none, none, map});
}

// Paths from gloss to gloss are rare and bright, and a pilot may see few of them. Where what VPLs lack is
// a thousandth of the light or more, no pixel takes fewer paths than this; where it is less, fewer in
// proportion.
constexpr int kFewestPaths = 256;
constexpr double kLackingLight = 0.001;

double sum_light(const HdrImage& layer, const PathMap& seen) {
  double sum = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const float* p = layer.pixel(i);
    if (seen[i] > 0) sum += luminance({p[0], p[1], p[2]});
  }
  return sum;
}

// `lacking`: what compensation brings where hardly anything is clamped.
std::uint32_t find_least_paths(const HdrImage& lacking, const HdrImage& light, const PathMap& seen,
                               int positions) {
  const double whole = sum_light(light, seen);
  const double share = whole > 0 ? std::clamp(sum_light(lacking, seen) / whole / kLackingLight, 0.0, 1.0) : 0;
  const int paths = std::max(1, static_cast<int>(std::lround(kFewestPaths * share)));
  return static_cast<std::uint32_t>(round_paths(paths, positions) / (kBatches * positions));
}

// One object's way from its pilot to its layers.
class CompensatedTracer {
 public:
  CompensatedTracer(const FamilyScene& scene, const ObjectPilot& pilot, const ReferenceParams& params,
                    const FamilyProgress& progress)
      : scene_(scene),
        pilot_(pilot),
        params_(params),
        progress_(progress),
        coverage_(make_coverage(scene.primary)),
        view_({&pilot.layers.background.mean, &pilot.layers.direct.mean, &pilot.layers.indirect.mean},
              coverage_, params.tone),
        background_errors_(view_.find_errors(pilot.layers.background, pilot.maps.background)),
        direct_errors_(view_.find_errors(pilot.layers.direct, pilot.maps.direct)) {}

  std::optional<CompensatedObject> trace() const {
    const SetPilot pilot = trace_set_pilot();
    const double cost_of_paths = foresee_cost_of_paths(pilot);
    const std::optional<SetPlan> plan =
        plan_vpl_sets(scene_, pilot, params_.target, cost_of_paths, params_.seed, params_.stream_name);
    if (!plan) return {};
    return render(*plan, pilot.least_paths);
  }

 private:
  // To the same target by path tracing.
  double foresee_cost_of_paths(const SetPilot& pilot) const {
    const std::vector<double> errors = view_.find_errors(pilot.indirect, pilot.map);
    std::vector<PixelError> of_object;
    for (std::size_t i = 0; i < errors.size(); ++i) {
      if (coverage_.values[i] > 0) of_object.push_back({errors[i] + pilot.other_errors[i]});
    }
    double paths = 0;
    for (const double of_pixel : foresee_paths(of_object, scene_.primary.positions, params_.target))
      paths += of_pixel * kBatches * scene_.primary.positions;
    return paths;
  }

  std::vector<TracedLayer> compensate(const PathMap& map, std::vector<double> clamps, const std::string& name,
                                      CompensationRecord* record = nullptr) const {
    const CompensationParams compensation{std::move(clamps), Emission::kLambertian, params_.seed,
                                          params_.stream_name + name, params_.measures};
    return trace_compensation(scene_, map, compensation, progress_.advance, record);
  }

  SetPilot trace_set_pilot() const {
    progress_.expect_more(count_object_paths(scene_.primary, pilot_.seen));
    CompensationRecord record;
    auto layers = std::make_shared<const std::vector<TracedLayer>>(
        compensate(pilot_.seen, list_finite_clamps(), ".pilot", &record));
    const auto fill = [this, layers](std::size_t level) {
      TracedLayer layer = (*layers)[level];
      fill_between(layer, pilot_.seen, coverage_, pilot_.reach);
      return layer;
    };
    SetPilot pilot{view_,
                   make_object_subject(scene_.primary),
                   background_errors_,
                   pilot_.layers.indirect,
                   fill,
                   std::move(record),
                   pilot_.seen,
                   pilot_.maps.indirect,
                   find_least_paths(layers->front().mean, pilot_.layers.indirect.mean, pilot_.seen,
                                    scene_.primary.positions)};
    for (std::size_t i = 0; i < direct_errors_.size(); ++i) pilot.other_errors[i] += direct_errors_[i];
    return pilot;
  }

  VplSets trace_sets(const SetPlan& plan, std::vector<int> regions) const {
    VplSetsParams sets;
    sets.sets = plan.sets;
    sets.paths = find_path_count(scene_.world, plan.vpls, params_.seed);
    sets.clamps_per_m2 = {clamp_per_m2(plan.clamp_level)};
    sets.error_ratio = plan.error_ratio;
    sets.floor = find_radiance_of_step(view_.tone().record, kFloorSteps);
    sets.seed = params_.seed;
    sets.stream_name = params_.stream_name;
    sets.totals.push_back(plan.light);
    sets.regions = std::move(regions);
    VplSets traced;
    const double share = plan.sets_cost / plan.sets;
    with_vpl_memory(plan.vpls,
                    [&] { traced = trace_vpl_sets(scene_, sets, [&] { progress_.advance(share); }); });
    return traced;
  }

  // Paths beside sets that err by so much.
  PathMaps allot_beside(const SetPlan& plan, const std::vector<double>& set_errors,
                        std::uint32_t least_paths) const {
    PathMaps maps = allot_paths({background_errors_, direct_errors_, plan.compensation_errors, set_errors},
                                coverage_, scene_.primary.positions, params_.target);
    maps.background = make_even_map(maps.direct, 0);
    for (std::uint32_t& of_pixel : maps.indirect) of_pixel = std::max(of_pixel, least_paths);
    return maps;
  }

  // The paths know what the sets before them err by, and are none the less unbiased: whatever these are,
  // their own light is as expected. Where sets miss so far that paths would cost more than another turn, they
  // are as many as were foreseen.
  PathMaps allot_after(const SetPlan& plan, const TracedLayer& sets, std::uint32_t least_paths) const {
    const PathMaps foreseen = allot_beside(plan, plan.set_errors, least_paths);
    PathMaps maps =
        allot_beside(plan, view_.find_errors(sets, make_even_map(foreseen.direct, 1)), least_paths);
    const double most = plan.sets_cost + 2 * count_paths(scene_.primary, foreseen);
    return count_paths(scene_.primary, maps) <= most ? maps : foreseen;
  }

  CompensatedObject render(const SetPlan& plan, std::uint32_t least_paths) const {
    progress_.expect_more(plan.sets_cost);
    const std::vector<int> regions = find_regions(coverage_, pilot_.seen);
    VplSets sets = trace_sets(plan, regions);
    const PathMaps maps = allot_after(plan, sets.layers[0], least_paths);
    const double paths = count_paths(scene_.primary, maps);
    progress_.expect_more(paths);
    TracedLayers direct = trace_layers(scene_, {maps.background, maps.direct, maps.background}, params_.seed,
                                       params_.stream_name, params_.measures, progress_.advance);
    TracedLayer returned = std::move(compensate(maps.indirect, {clamp_per_m2(plan.clamp_level)}, "")[0]);
    CompensatedObject object;
    object.measures = {plan.clamp_level,
                       sets.sets,
                       sets.mean_vpls,
                       plan.error_ratio,
                       sets.mean_clusters,
                       count_object_paths(scene_.primary, maps.indirect),
                       check_regions(std::move(sets.regions), returned, pilot_.layers.indirect, regions,
                                     find_radiance_of_step(view_.tone().record, 1))};
    object.direct = std::move(direct.direct);
    object.indirect = std::move(sets.layers[0]);
    add_independent(object.indirect, returned);
    object.paths = paths;
    return object;
  }

  const FamilyScene& scene_;
  const ObjectPilot& pilot_;
  const ReferenceParams& params_;
  const FamilyProgress& progress_;
  HdrImage coverage_;
  DisplayPilot view_;
  std::vector<double> background_errors_, direct_errors_;
};

}  // namespace

std::optional<CompensatedObject> trace_compensated(const FamilyScene& scene, const ObjectPilot& pilot,
                                                   const ReferenceParams& params,
                                                   const FamilyProgress& progress) {
  return CompensatedTracer(scene, pilot, params, progress).trace();
}

}  // namespace equilux
