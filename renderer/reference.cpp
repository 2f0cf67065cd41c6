// Pilot, allotment, paths.
#include "renderer/reference.h"

namespace equilux {
namespace {

// Rough numbers of paths for an error of one displayed step. They only foresee progress.
constexpr double kPathsForOneStepOnObject = 6000;
constexpr double kPathsForOneStepOutside = 2000;

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

PathMap take_share(PathMap map, const PathMap& least) {
  for (std::size_t i = 0; i < map.size(); ++i)
    map[i] = std::max(least[i], (map[i] + kSecondShare - 1) / kSecondShare);
  return map;
}

PathMaps allot(const FamilyScene& scene, const ReferenceParams& params, const FamilyProgress& progress) {
  if (params.fixed) return make_fixed_maps(scene.primary, *params.fixed);
  const HdrImage coverage = make_coverage(scene.primary);
  const auto fly = [&](const PathMaps& maps, const std::string& name) {
    const TracedLayers pilot =
        trace_layers(scene, maps, params.seed, params.stream_name + name, params.measures, progress.advance);
    return allot_paths(pilot, maps, coverage, scene.primary.positions, params.exposure, params.tone_key,
                       params.target);
  };
  const PathMaps first = make_pilot_maps(scene.primary);
  PathMaps maps = fly(first, ".pilot");
  if (params.target.object_p99 < kSteepPercentile * params.target.object_mean) {
    const PathMaps share{take_share(maps.background, first.background), take_share(maps.direct, first.direct),
                         take_share(maps.indirect, first.indirect)};
    progress.expect_more(count_paths(scene.primary, share));
    maps = fly(share, ".second-pilot");
  }
  return maps;
}

}  // namespace

ReferenceParams make_reference_params(const Study& study, const std::string& stream_name) {
  return {study.paths, study.noise_target, study.exposure, study.tone_key, study.seed, stream_name, {}};
}

double estimate_family_paths(const ReferenceParams& params, const Primary& primary) {
  if (params.fixed) return count_paths(primary, make_fixed_maps(primary, *params.fixed));
  return count_paths(primary, make_fixed_maps(primary, guess_counts(params.target))) +
         count_paths(primary, make_pilot_maps(primary));
}

PathMaps allot_family(const FamilyScene& scene, const ReferenceParams& params,
                      const FamilyProgress& progress) {
  PathMaps maps = allot(scene, params, progress);
  if (!params.fixed) {
    progress.expect_more(count_paths(scene.primary, maps) +
                         count_paths(scene.primary, make_pilot_maps(scene.primary)) -
                         estimate_family_paths(params, scene.primary));
  }
  return maps;
}

FamilyLayers trace_family(const FamilyScene& scene, const ReferenceParams& params,
                          const FamilyProgress& progress) {
  const PathMaps maps = allot_family(scene, params, progress);
  const double paths = count_paths(scene.primary, maps);
  TracedLayers layers =
      trace_layers(scene, maps, params.seed, params.stream_name, params.measures, progress.advance);
  HdrImage standard_error = combine_standard_errors(layers);
  return {std::move(layers.background.mean), std::move(layers.direct.mean), std::move(layers.indirect.mean),
          std::move(standard_error), paths};
}

}  // namespace equilux
