// Ladders, slopes, advice.
#include "renderer/converge.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/program.h"
#include "base/progress.h"
#include "renderer/converge_lab.h"
#include "renderer/isa.h"
#include "renderer/lightcut.h"
#include "renderer/parallel.h"
#include "renderer/reference.h"
#include "renderer/wanted.h"

namespace equilux {
namespace {

// Of the sets' cuts.
constexpr double kSetRatio = 0.0025;
constexpr int kDirectPaths = 256, kBackgroundPaths = 256;

// Settings in the order of their cost.
struct Ladder {
  std::string series;
  std::vector<std::pair<std::string, LightSetting>> rungs;
};

ReferenceTruth trace_truth(const Laboratory& lab) {
  const ConvergeParams& params = lab.params;
  const PathMaps maps =
      make_fixed_maps(lab.primary, {params.reference_paths, kDirectPaths, kBackgroundPaths});
  Progress progress("reference", count_paths(lab.primary, maps));
  TracedLayers traced = trace_layers(lab.family(), maps, params.seed, "converge.reference", {},
                                     [&](double paths) { progress.advance(paths); });
  TruthLayers layers;
  layers.background = std::move(traced.background.mean);
  layers.direct = std::move(traced.direct.mean);
  layers.indirect = std::move(traced.indirect);
  layers.coverage = make_coverage(lab.primary);
  layers.tone = make_tone_curve(composite({&layers.background, &layers.direct, &layers.indirect.mean}),
                                layers.coverage, params.tone);
  layers.pixels_per_degree = params.pixels_per_degree;
  return {std::move(layers), fmt::format("{}: {}", lab.world.scene_path(), format_key(params.condition))};
}

std::string name_level(int level, ClampRemedy remedy) {
  switch (remedy) {
    case ClampRemedy::kNormalised:
      return format_clamp(level) + ", normalised";
    case ClampRemedy::kCompensated:
      return format_clamp(level) + ", compensated";
    default:
      return format_clamp(level);
  }
}

std::string name_vpls(std::int64_t vpls) { return format_vpl_count(vpls) + " VPLs"; }

LightMethod method_of(std::int64_t vpls) {
  return is_summed_plainly(vpls) ? LightMethod::kPlainSum : LightMethod::kLightcuts;
}

Ladder make_path_ladder(const Laboratory& lab) {
  Ladder ladder{"path tracing", {}};
  int paths = lab.least_paths();
  for (int step = 0; step < lab.params.ladders.steps && paths <= (1 << 20); ++step, paths *= 4) {
    LightSetting setting;
    setting.paths_a_pixel = paths;
    ladder.rungs.push_back({fmt::format("{} paths a pixel", paths), setting});
  }
  return ladder;
}

Ladder make_count_ladder(const char* name, LightMethod method, const std::vector<std::int64_t>& counts,
                         int level) {
  Ladder ladder{fmt::format("{} {}", name, format_clamp(level)), {}};
  for (const std::int64_t vpls : counts)
    ladder.rungs.push_back({name_vpls(vpls), {method, vpls, kErrorRatio, level, ClampRemedy::kNone, 0, 0}});
  return ladder;
}

Ladder make_ratio_ladder(const Laboratory& lab, int level) {
  Ladder ladder{fmt::format("ratios {} at {}", format_clamp(level), format_vpl_count(lab.vpls())), {}};
  for (const double ratio : lab.params.ladders.error_ratios)
    ladder.rungs.push_back({fmt::format("{}, ratio {:.3g} %", name_vpls(lab.vpls()), 100 * ratio),
                            {LightMethod::kLightcuts, lab.vpls(), ratio, level, ClampRemedy::kNone, 0, 0}});
  return ladder;
}

// Without a clamp there is nothing to give back but gloss that VPLs do not send on.
bool changes_unclamped(const Laboratory& lab, ClampRemedy remedy) {
  return remedy == ClampRemedy::kNone ||
         (remedy == ClampRemedy::kCompensated && lacks_gloss(lab.params.emission, lab.materials));
}

Ladder make_level_ladder(const Laboratory& lab, ClampRemedy remedy) {
  const char* names[] = {"clamped", "clamped and normalised", "clamped and compensated"};
  const int paths = remedy == ClampRemedy::kCompensated ? lab.least_paths() : 0;
  Ladder ladder{
      fmt::format("{} at {}", names[static_cast<std::size_t>(remedy)], format_vpl_count(lab.vpls())), {}};
  for (const int level : lab.params.ladders.clamp_levels) {
    if (level == 0 && !changes_unclamped(lab, remedy)) continue;
    ladder.rungs.push_back({name_level(level, remedy),
                            {method_of(lab.vpls()), lab.vpls(), kErrorRatio, level, remedy, paths, 0}});
  }
  return ladder;
}

// More and more paths give back what one set's clamp takes.
Ladder make_compensation_ladder(const Laboratory& lab) {
  Ladder ladder{fmt::format("compensated {} at {}, more paths", format_clamp(lab.level()),
                            format_vpl_count(lab.vpls())),
                {}};
  int paths = lab.least_paths();
  for (int step = 0; step < 3; ++step, paths *= 4)
    ladder.rungs.push_back(
        {fmt::format("{}, {} paths a pixel", name_vpls(lab.vpls()), paths),
         {method_of(lab.vpls()), lab.vpls(), kErrorRatio, lab.level(), ClampRemedy::kCompensated, paths, 0}});
  return ladder;
}

Ladder make_set_ladder(const Laboratory& lab) {
  Ladder ladder{
      fmt::format("compensated sets {} of {}", format_clamp(lab.level()), format_vpl_count(lab.vpls())), {}};
  int paths = lab.least_paths(), sets = 2 * lab.params.positions;
  for (int step = 0; step < 3; ++step, paths *= 2, sets *= 2)
    ladder.rungs.push_back(
        {fmt::format("{} sets, {} paths a pixel", sets, paths),
         {LightMethod::kSets, lab.vpls(), kSetRatio, lab.level(), ClampRemedy::kCompensated, paths, sets}});
  return ladder;
}

std::vector<Ladder> make_ladders(const Laboratory& lab) {
  const ConvergeLadders& ladders = lab.params.ladders;
  std::vector<int> levels{0};
  if (lab.level() != 0) levels.push_back(lab.level());
  std::vector<Ladder> made{make_path_ladder(lab)};
  for (const int level : levels)
    made.push_back(make_count_ladder("plain sum", LightMethod::kPlainSum, ladders.plain_counts, level));
  for (const int level : levels)
    made.push_back(make_count_ladder("lightcuts", LightMethod::kLightcuts, ladders.cut_counts, level));
  for (const int level : levels) made.push_back(make_ratio_ladder(lab, level));
  for (const ClampRemedy remedy : {ClampRemedy::kNone, ClampRemedy::kNormalised, ClampRemedy::kCompensated})
    made.push_back(make_level_ladder(lab, remedy));
  if (lab.level() != 0) {
    made.push_back(make_compensation_ladder(lab));
    made.push_back(make_set_ladder(lab));
  }
  return made;
}

ConvergencePoint make_point(const std::string& series, const std::string& label,
                            const LightSetting& setting) {
  ConvergencePoint point;
  point.series = series;
  point.setting = label;
  point.vpls = setting.vpls;
  const bool cut = setting.method == LightMethod::kLightcuts || setting.method == LightMethod::kSets;
  point.error_ratio = cut ? setting.error_ratio : 0;
  if (setting.method != LightMethod::kPaths) point.clamp_level = setting.clamp_level;
  point.paths_a_pixel = setting.paths_a_pixel;
  point.sets = setting.sets;
  return point;
}

void add_times(std::map<std::string, double>& sum, const std::map<std::string, double>& more, int seeds) {
  for (const auto& [stage, seconds] : more) sum[stage] += seconds / seeds;
}

ConvergencePoint measure_point(const Laboratory& lab, const ReferenceTruth& truth, const LitScene& scene,
                               ConvergencePoint point, const LightSetting& setting) {
  std::vector<RunError> runs;
  for (int run = 0; run < lab.params.seeds; ++run) {
    const LitLayer lit = light_object(scene, setting, lab.seed(run));
    runs.push_back(truth.compare(lit.layer));
    add_times(point.wall_s, lit.times.wall_s, lab.params.seeds);
    add_times(point.cpu_s, lit.times.cpu_s, lab.params.seeds);
  }
  point.error = summarise_runs(runs, truth.error_of_mean());
  return point;
}

// What cannot be measured loses nothing of the rest.
template <typename Body>
void run_or_tell(const std::string& what, std::vector<std::string>& left_out, const Body& body) {
  try {
    body();
  } catch (const InputError& error) {
    left_out.push_back(fmt::format("{}: {}", what, error.what()));
  }
}

void climb(const Laboratory& lab, const ReferenceTruth& truth, const LitScene& scene, const Ladder& ladder,
           Progress& progress, Convergence& made) {
  double seconds = 0, work_done = 1;
  for (const auto& [label, setting] : ladder.rungs) {
    const double work = estimate_work(scene, setting), all = work * lab.params.seeds;
    if (seconds * work / work_done > lab.params.budget_s) {
      progress.expect_more(-all);
      continue;
    }
    const ConvergencePoint point = make_point(ladder.series, label, setting);
    run_or_tell(fmt::format("{} at {}", ladder.series, label), made.left_out, [&] {
      made.points.push_back(measure_point(lab, truth, scene, point, setting));
      seconds = made.points.back().wall();
      work_done = work;
    });
    progress.advance(all);
  }
}

void climb_all(const Laboratory& lab, const ReferenceTruth& truth, const LitScene& scene, Convergence& made) {
  const std::vector<Ladder> ladders = make_ladders(lab);
  double work = 0;
  for (const Ladder& ladder : ladders) {
    for (const auto& rung : ladder.rungs) work += estimate_work(scene, rung.second) * lab.params.seeds;
  }
  Progress progress("methods", work);
  for (const Ladder& ladder : ladders) climb(lab, truth, scene, ladder, progress, made);
}

constexpr double kLeastRange = 2;  // of times, to which a slope is fitted

std::vector<FittedSlope> fit_slopes(const Convergence& convergence) {
  std::map<std::string, std::vector<std::pair<double, double>>> logs;
  for (const ConvergencePoint& point : convergence.points) {
    if (is_resolved(convergence, point))
      logs[point.series].emplace_back(std::log(point.wall()), std::log(point.error.relative_rms));
  }
  std::vector<FittedSlope> slopes;
  for (const auto& [series, values] : logs) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    if (values.size() < 3 || high->first - low->first < std::log(kLeastRange)) continue;
    const auto count = static_cast<double>(values.size());
    double x = 0, y = 0, xx = 0, xy = 0;
    for (const auto& [time, error] : values) {
      x += time / count;
      y += error / count;
    }
    for (const auto& [time, error] : values) {
      xx += (time - x) * (time - x);
      xy += (time - x) * (error - y);
    }
    slopes.push_back({series, xy / xx});
  }
  return slopes;
}

ConvergenceAdvice find_advice(const Convergence& convergence, double seconds) {
  ConvergenceAdvice advice{seconds, {}};
  for (const ConvergencePoint* point : find_frontier(convergence)) {
    if (point->wall() <= seconds) advice.point = static_cast<std::size_t>(point - convergence.points.data());
  }
  return advice;
}

}  // namespace

Convergence measure_convergence(const Scene& scene, const ConvergeParams& params) {
  EQ_CHECK(params.seeds >= 2, params.seeds);
  const Laboratory lab(scene, params);
  const ReferenceTruth truth = trace_truth(lab);
  const LitScene lit = lab.lit(find_radiance_of_step(truth.layers().tone.record, kFloorSteps));
  Convergence made;
  made.source = params.source;
  made.condition = format_key(params.condition);
  made.width = params.width;
  made.height = params.height;
  made.positions = params.positions;
  made.seed = params.seed;
  made.seeds = params.seeds;
  made.threads = count_threads();
  made.isa = format_isa(current_isa());
  made.host = find_host_name();
  made.reference =
      fmt::format("path tracing, {} paths a pixel", round_paths(params.reference_paths, params.positions));
  made.reference_mean = truth.mean();
  made.reference_rms = truth.rms_of_error();
  made.reference_square_error = truth.error_of_square();
  made.object_pixels = truth.object_pixels();
  climb_all(lab, truth, lit, made);
  made.slopes = fit_slopes(made);
  run_or_tell("the error in its parts", made.left_out, [&] { made.parts = measure_parts(lab, truth, lit); });
  for (const double seconds : params.asked_s) made.advice.push_back(find_advice(made, seconds));
  return made;
}

}  // namespace equilux
