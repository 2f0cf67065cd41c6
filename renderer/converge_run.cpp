// The methods, each as its command runs it, with a clock at every stage.
#include "renderer/converge_run.h"

#include <chrono>
#include <limits>

#include "renderer/compensation.h"
#include "renderer/lightcut.h"
#include "renderer/stopwatch.h"
#include "renderer/tone.h"

namespace equilux {
namespace {

double read_wall_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Adds the time that it lives to a stage.
class StageClock {
 public:
  StageClock(StageTimes* times, const char* stage)
      : times_(times), stage_(stage), wall_s_(read_wall_s()), cpu_s_(measure_processor_seconds()) {}
  ~StageClock() {
    if (!times_) return;
    times_->wall_s[stage_] += read_wall_s() - wall_s_;
    times_->cpu_s[stage_] += measure_processor_seconds() - cpu_s_;
  }
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;

 private:
  StageTimes* times_;
  const char* stage_;
  double wall_s_, cpu_s_;
};

constexpr const char* kStream = "converge";

PathMap make_map(const LitScene& scene, int paths_a_pixel) {
  return make_fixed_maps(scene.primary, {paths_a_pixel, paths_a_pixel, paths_a_pixel}).indirect;
}

HdrImage trace_run_paths(const LitScene& scene, const LightSetting& setting, std::uint64_t seed,
                         StageTimes& times) {
  const StageClock clock(&times, "path tracing");
  const PathMap map = make_map(scene, setting.paths_a_pixel), none(map.size(), 0);
  return trace_layers({scene.world, scene.materials, scene.primary}, {none, none, map}, seed, kStream, {},
                      [](double) {})
      .indirect.mean;
}

HdrImage compensate(const LitScene& scene, const LightSetting& setting, std::uint64_t seed,
                    StageTimes& times) {
  const StageClock clock(&times, "compensation");
  const CompensationParams params{
      {clamp_per_m2(setting.clamp_level)}, scene.emission, seed, kStream, PathMeasures{}};
  return trace_compensation({scene.world, scene.materials, scene.primary},
                            make_map(scene, setting.paths_a_pixel), params, [](double) {})[0]
      .mean;
}

ShadedPoints shade_run(const LitScene& scene, const LightSetting& setting, std::uint64_t seed,
                       const std::vector<double>& clamps, StageTimes& times) {
  const Material& material = scene.materials[kObjectMaterial];
  if (setting.method == LightMethod::kPlainSum) {
    const VplList vpls = trace_run_vpls(scene, setting.vpls, seed, &times);
    const StageClock clock(&times, "shading");
    return shade_all_vpls(scene.world, scene.points, vpls, {material}, clamps, [](double) {});
  }
  const LightTree tree = make_run_tree(scene, setting.vpls, seed, &times);
  const StageClock clock(&times, "shading");
  return shade_lightcut(scene.world, scene.points, tree, {material}, clamps,
                        {setting.error_ratio, scene.floor});
}

HdrImage light_by_set(const LitScene& scene, const LightSetting& setting, std::uint64_t seed,
                      StageTimes& times) {
  std::vector<double> clamps{clamp_per_m2(setting.clamp_level)};
  if (setting.remedy == ClampRemedy::kNormalised) clamps.push_back(std::numeric_limits<double>::infinity());
  const ShadedPoints shaded = shade_run(scene, setting, seed, clamps, times);
  std::vector<HdrImage> layers(clamps.size(), HdrImage(scene.primary.width, scene.primary.height));
  for (std::size_t level = 0; level < clamps.size(); ++level)
    add_to_layer(shaded, 0, level, scene.points, scene.primary.positions, layers[level]);
  return clamps.size() > 1 ? normalise_luminance(layers[0], layers[1]) : layers[0];
}

HdrImage light_by_sets(const LitScene& scene, const LightSetting& setting, std::uint64_t seed,
                       StageTimes& times) {
  const StageClock clock(&times, "VPL sets");
  VplSetsParams params;
  params.sets = setting.sets;
  params.paths = find_path_count(scene.world, setting.vpls, seed, scene.emission);
  params.clamps_per_m2 = {clamp_per_m2(setting.clamp_level)};
  params.error_ratio = setting.error_ratio;
  params.floor = scene.floor;
  params.emission = scene.emission;
  params.seed = seed;
  params.stream_name = kStream;
  HdrImage layer;
  with_vpl_memory(setting.vpls, [&] {
    layer = trace_vpl_sets({scene.world, scene.materials, scene.primary}, params, [] {}).layers[0].mean;
  });
  return layer;
}

HdrImage light_by_vpls(const LitScene& scene, const LightSetting& setting, std::uint64_t seed,
                       StageTimes& times) {
  HdrImage layer = setting.method == LightMethod::kSets ? light_by_sets(scene, setting, seed, times)
                                                        : light_by_set(scene, setting, seed, times);
  if (setting.remedy != ClampRemedy::kCompensated) return layer;
  const HdrImage returned = compensate(scene, setting, seed, times);
  return composite({&layer, &returned});
}

// Rough costs beside a path's, measured in the café.
constexpr double kVplCost = 1.5, kPairCost = 0.05, kCutCost = 600, kCompensationCost = 0.7;

}  // namespace

VplList trace_run_vpls(const LitScene& scene, std::int64_t vpls, std::uint64_t seed, StageTimes* times) {
  const std::int64_t paths = [&] {
    const StageClock clock(times, "VPL pilot");
    return find_path_count(scene.world, vpls, seed, scene.emission);
  }();
  const StageClock clock(times, "VPL tracing");
  return join_vpls(trace_vpls(scene.world, scene.materials, paths, seed, kStream, scene.emission));
}

LightTree make_run_tree(const LitScene& scene, std::int64_t vpls, std::uint64_t seed, StageTimes* times) {
  LightTree tree;
  with_vpl_memory(vpls, [&] {
    VplList list = trace_run_vpls(scene, vpls, seed, times);
    const StageClock clock(times, "light tree");
    tree = make_light_tree(std::move(list), {seed, 4});
  });
  return tree;
}

LitLayer light_object(const LitScene& scene, const LightSetting& setting, std::uint64_t seed) {
  LitLayer lit;
  lit.layer = setting.method == LightMethod::kPaths ? trace_run_paths(scene, setting, seed, lit.times)
                                                    : light_by_vpls(scene, setting, seed, lit.times);
  return lit;
}

double estimate_work(const LitScene& scene, const LightSetting& setting) {
  const auto points = static_cast<double>(scene.points.size());
  const double paths = points / scene.primary.positions * setting.paths_a_pixel;
  if (setting.method == LightMethod::kPaths) return paths;
  const auto vpls = static_cast<double>(setting.vpls);
  double work = setting.remedy == ClampRemedy::kCompensated ? kCompensationCost * paths : 0;
  const double cut = kCutCost * std::pow(0.0075 / std::max(setting.error_ratio, 1e-6), 0.7);
  switch (setting.method) {
    case LightMethod::kPlainSum:
      return work + kVplCost * vpls + kPairCost * vpls * points;
    case LightMethod::kSets: {
      const double share = static_cast<double>(setting.sets) / scene.primary.positions;
      return work + kVplCost * vpls * (setting.sets + 1) + points * (share * cut + kCutCost);
    }
    default:
      return work + kVplCost * vpls + points * cut;
  }
}

}  // namespace equilux
