// What VPL sets of references cost and err by over their VPLs and their error ratio, and the constants by
// which plan_vpl_sets foresees both; prints Markdown.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>
#include <optional>

#include "renderer/compensation.h"
#include "renderer/set_plan.h"
#include "renderer/stopwatch.h"
#include "renderer/vpl.h"
#include "renderer/vpl_sets.h"

namespace {

using namespace equilux;

struct Options {
  std::vector<std::string> objects{"G0-GS-ind", "G1-LG-ind", "G0-MS-ind"};
  std::vector<double> vpls{20e3, 80e3, 320e3, 1.28e6}, ratios{0.0025, 0.01, 0.04, 0.16},
      shares{0, 0.2, 0.4, 0.8, 1.2};
  int width = 280, height = 210, sets = 8, level = 5;
  std::uint64_t seed = 1;
};

void advance(double) {}

// An object, and light that its cuts go by.
struct Subject {
  const FamilyScene& scene;
  HdrImage coverage;
  HdrImage light;     // not premultiplied
  double path_s = 0;  // of processors
  double points = 0;  // of one position
};

struct Run {
  double vpls = 0, ratio = 0, clusters = 0;
  double cost = 0;      // of a set. units: paths
  double variance = 0;  // of a set, over the square of the light
};

// Over the subject's whole pixels, without the worst thousandth.
double measure_variance(const Subject& subject, const VplSets& sets) {
  std::vector<double> squares;
  double light = 0;
  for (std::size_t i = 0; i < subject.coverage.pixel_count(); ++i) {
    if (subject.coverage.values[i] < 1) continue;
    double square = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      square += std::pow(sets.layers[0].standard_error.pixel(i)[c], 2);
      light += std::pow(subject.light.pixel(i)[c], 2);
    }
    squares.push_back(square);
  }
  std::sort(squares.begin(), squares.end());
  squares.resize(squares.size() - squares.size() / 1000);
  return sets.sets * std::accumulate(squares.begin(), squares.end(), 0.0) / light;
}

VplSetsParams make_params(const Subject& subject, const Options& options, double vpls, double ratio) {
  VplSetsParams params;
  params.sets = options.sets;
  params.paths = find_path_count(subject.scene.world, std::llround(vpls), options.seed);
  params.clamps_per_m2 = {clamp_per_m2(options.level)};
  params.error_ratio = ratio;
  params.seed = options.seed;
  params.stream_name = fmt::format("bench-{}-{}", vpls, ratio);
  if (!subject.light.values.empty()) params.totals = {subject.light};
  return params;
}

Run trace(const Subject& subject, const VplSetsParams& params) {
  const double start = measure_processor_seconds();
  const VplSets sets = trace_vpl_sets(subject.scene, params, [] {});
  const double seconds = measure_processor_seconds() - start;
  return {sets.mean_vpls, params.error_ratio, sets.mean_clusters, seconds / sets.sets / subject.path_s,
          measure_variance(subject, sets)};
}

// By many cuts of small sets.
HdrImage find_light(const Subject& subject, const Options& options) {
  constexpr double kVpls = 40e3, kRatio = 0.005;
  VplSetsParams params = make_params(subject, options, kVpls, kRatio);
  params.sets = 4 * options.sets;
  HdrImage light = trace_vpl_sets(subject.scene, params, [] {}).layers[0].mean;
  for (std::size_t i = 0; i < light.pixel_count(); ++i) {
    const float covered = subject.coverage.values[i];
    for (std::size_t c = 0; c < 3; ++c) light.pixel(i)[c] /= covered > 0 ? covered : 1;
  }
  return light;
}

double measure_path(const FamilyScene& scene, const Options& options) {
  const PathMaps maps = make_fixed_maps(scene.primary, {64, 64, 64});
  const double start = measure_processor_seconds();
  trace_layers(scene, maps, options.seed, "bench", {}, advance);
  return (measure_processor_seconds() - start) / count_paths(scene.primary, maps);
}

// One unknown after another, by the normal equations of least squares.
template <std::size_t N>
std::array<double, N> solve(std::array<std::array<double, N + 1>, N> rows) {
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t k = 0; k < N; ++k) {
      if (k == i) continue;
      const double factor = rows[k][i] / rows[i][i];
      for (std::size_t j = 0; j <= N; ++j) rows[k][j] -= factor * rows[i][j];
    }
  }
  std::array<double, N> solution;
  for (std::size_t i = 0; i < N; ++i) solution[i] = rows[i][N] / rows[i][i];
  return solution;
}

// terms(run): N factors, and what their sum should be. `left`: mean square of what is left
template <std::size_t N, typename Terms>
std::array<double, N> fit(const std::vector<Run>& runs, const Terms& terms, double* left = nullptr) {
  std::array<std::array<double, N + 1>, N> rows{};
  for (const Run& run : runs) {
    const std::array<double, N + 1> of_run = terms(run);
    for (std::size_t i = 0; i < N; ++i) {
      for (std::size_t j = 0; j <= N; ++j) rows[i][j] += of_run[i] * of_run[j];
    }
  }
  const std::array<double, N> solution = solve<N>(rows);
  for (const Run& run : runs) {
    const std::array<double, N + 1> of_run = terms(run);
    const double sum = std::inner_product(solution.begin(), solution.end(), of_run.begin(), 0.0);
    if (left) *left += std::pow(sum - of_run[N], 2) / static_cast<double>(runs.size());
  }
  return solution;
}

// variance = a / v + b r^e.
struct VarianceFit {
  double exponent = 0, of_vpls = 0, of_ratio = 0;
  double left = std::numeric_limits<double>::infinity();  // mean square, relative
};

VarianceFit fit_variance(const std::vector<Run>& runs) {
  VarianceFit best;
  for (double exponent = 0.4; exponent < 2; exponent += 0.05) {
    double left = 0;
    const auto [a, b] = fit<2>(
        runs,
        [&](const Run& run) {
          return std::array<double, 3>{1 / run.vpls / run.variance,
                                       std::pow(run.ratio, exponent) / run.variance, 1};
        },
        &left);
    if (left < best.left) best = {exponent, a, b, left};
  }
  return best;
}

void print_grid(const Subject& subject, const Options& options) {
  std::vector<Run> runs;
  fmt::print(
      "| VPLs of a set | ratio % | clusters | paths' worth | us a cluster | rms % of a set |\n"
      "|---:|---:|---:|---:|---:|---:|\n");
  for (const double vpls : options.vpls) {
    for (const double ratio : options.ratios) {
      const Run run = trace(subject, make_params(subject, options, vpls, ratio));
      fmt::print("| {:.0f}k | {:.3g} | {:.0f} | {:.3g} | {:.3f} | {:.2f} |\n", run.vpls / 1000, 100 * ratio,
                 run.clusters, run.cost, 1e6 * run.cost * subject.path_s / run.clusters / subject.points,
                 100 * std::sqrt(run.variance));
      std::fflush(stdout);
      runs.push_back(run);
    }
  }
  const auto [of_vpl, of_cluster] = fit<2>(runs, [&](const Run& run) {
    return std::array<double, 3>{run.vpls / run.cost, run.clusters * subject.points / run.cost, 1};
  });
  const auto size = fit<3>(runs, [](const Run& run) {
    return std::array<double, 4>{1, std::log(run.vpls), std::log(run.ratio), std::log(run.clusters)};
  });
  const VarianceFit variance = fit_variance(runs);
  fmt::print(
      "\nA path takes {:.2f} us; a VPL {:.2f} paths, a cluster {:.3f}. Sizes go with VPLs^{:.2f} and "
      "ratio^{:.2f}; variances of the ratio with ratio^{:.2f} (rms of what is left {:.0f} %).\n\n",
      1e6 * subject.path_s, of_vpl, of_cluster, size[1], size[2], variance.exponent,
      100 * std::sqrt(variance.left));
}

void print_roulette(const Subject& subject, const Options& options) {
  constexpr double kVpls = 100e3, kRatio = 0.01;
  fmt::print(
      "| roulette's share of the ratio | paths' worth | rms % of a set | time to equal error |\n"
      "|---:|---:|---:|---:|\n");
  std::optional<double> whole;
  for (const double share : options.shares) {
    VplSetsParams params = make_params(subject, options, kVpls, kRatio);
    params.roulette_of_ratio = share;
    const Run run = trace(subject, params);
    if (!whole) whole = run.cost * run.variance;
    fmt::print("| {} | {:.3g} | {:.2f} | {:.2f} |\n", share, run.cost, 100 * std::sqrt(run.variance),
               run.cost * run.variance / *whole);
    std::fflush(stdout);
  }
  fmt::print("\n");
}

void print_compensation(const Subject& subject, const Options& options) {
  const PathMaps maps = make_fixed_maps(subject.scene.primary, {64, 64, 64});
  const PathMap none(maps.indirect.size(), 0);
  const double paths = count_paths(subject.scene.primary, {none, none, maps.indirect});
  fmt::print(
      "| level | paths of compensation that go on, % | a path of compensation, paths |\n|---|---:|---:|\n");
  double ones = 0, shares = 0, squares = 0, costs = 0, products = 0;
  for (int level = 1; level < kClampLevelCount; ++level) {
    CompensationParams params;
    params.clamps_per_m2 = {clamp_per_m2(level)};
    params.seed = options.seed;
    params.stream_name = "bench";
    CompensationRecord record;
    const double start = measure_processor_seconds();
    trace_compensation(subject.scene, maps.indirect, params, advance, &record);
    const double cost = (measure_processor_seconds() - start) / paths / subject.path_s;
    const double share = record.walked[0];
    fmt::print("| {} | {:.1f} | {:.2f} |\n", format_clamp(level), 100 * share, cost);
    ones += 1, shares += share, squares += share * share, costs += cost, products += share * cost;
  }
  const double walk = (ones * products - shares * costs) / (ones * squares - shares * shares);
  fmt::print("\nA first ray takes {:.2f} paths, going on {:.2f}.\n\n", (costs - walk * shares) / ones, walk);
}

// Sum of a channel's values over the subject's whole pixels, over that of its squared light.
template <typename Value>
double average(const Subject& subject, const Value& value) {
  double sum = 0, light = 0;
  for (std::size_t pixel = 0; pixel < subject.coverage.pixel_count(); ++pixel) {
    if (subject.coverage.values[pixel] < 1) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      sum += value(pixel, c);
      light += std::pow(subject.light.pixel(pixel)[c], 2);
    }
  }
  return sum / light;
}

// Variance by level beyond that of C10, of sets and as compensation's paths foresee it.
void print_levels(const Subject& subject, const Options& options) {
  constexpr double kVpls = 100e3, kRatio = 0.0025;
  const PathMaps maps = make_fixed_maps(subject.scene.primary, {64, 64, 64});
  CompensationParams params;
  params.clamps_per_m2 = list_finite_clamps();
  params.seed = options.seed;
  params.stream_name = "bench";
  CompensationRecord record;
  trace_compensation(subject.scene, maps.indirect, params, advance, &record);
  const std::int64_t paths = find_path_count(subject.scene.world, std::llround(kVpls), options.seed);
  const std::vector<ShadingPoint> points = make_object_subject(subject.scene.primary).points;
  std::vector<SurfacePoint> some;
  for (std::size_t i = 0; i < 32; ++i) some.push_back(points[i * points.size() / 32].surface);
  const std::array<double, 3> intensity = measure_intensity(
      join_vpls(trace_vpls(subject.scene.world, subject.scene.materials, paths, options.seed, "bench")),
      some);
  std::vector<double> foreseen, seen;
  for (int level = 1; level < kClampLevelCount; ++level) {
    VplSetsParams sets_params = make_params(subject, options, kVpls, kRatio);
    sets_params.sets = 4 * options.sets;
    sets_params.clamps_per_m2 = {clamp_per_m2(level)};
    const VplSets sets = trace_vpl_sets(subject.scene, sets_params, [] {});
    seen.push_back(sets.sets * average(subject, [&](std::size_t pixel, std::size_t c) {
                     return std::pow(sets.layers[0].standard_error.pixel(pixel)[c], 2);
                   }));
    const HdrImage& variance = record.variances[static_cast<std::size_t>(level - 1)];
    foreseen.push_back(average(
        subject, [&](std::size_t pixel, std::size_t c) { return intensity[c] * variance.pixel(pixel)[c]; }));
  }
  fmt::print("| level | rms % of a set | beyond C10, rms % | the same foreseen |\n|---|---:|---:|---:|\n");
  for (std::size_t i = 0; i < seen.size(); ++i) {
    fmt::print("| {} | {:.2f} | {:.2f} | {:.2f} |\n", format_clamp(static_cast<int>(i) + 1),
               100 * std::sqrt(seen[i]), 100 * std::sqrt(std::max(0.0, seen[i] - seen.back())),
               100 * std::sqrt(foreseen[i] - foreseen.back()));
  }
  fmt::print("\n");
}

void print_object(const Scene& scene, const std::string& key, const Options& options) {
  const Object object = parse_family(key + "-ref-v0", "--objects").object;
  const World world = make_world(scene, object.geometry, object.illumination);
  const Materials materials = make_materials(world, find_material(scene, object.material));
  const Primary primary = trace_primary(world, make_view_camera(scene, 0), options.width, options.height, 4);
  const FamilyScene family{world, materials, primary};
  Subject subject{family,
                  make_coverage(primary),
                  {},
                  measure_path(family, options),
                  make_object_subject(primary).points_a_position};
  subject.light = find_light(subject, options);
  fmt::print("{}, C{}, sets of {}:\n\n", key, options.level, options.sets);
  print_grid(subject, options);
  print_roulette(subject, options);
  print_compensation(subject, options);
  print_levels(subject, options);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Cost and error of VPL sets of references over their VPLs, error ratio and roulette");
  app.add_option("--objects", options.objects, "Such as G0-MS-ind")->delimiter(',');
  app.add_option("--vpls", options.vpls, "VPLs of a set")->delimiter(',');
  app.add_option("--ratios", options.ratios, "Error ratios of cuts")->delimiter(',');
  app.add_option("--roulette", options.shares, "Roulette's share of the ratio")->delimiter(',');
  app.add_option("--width", options.width, "Pixels");
  app.add_option("--height", options.height, "Pixels");
  app.add_option("--sets", options.sets, "Sets of each kind (8)");
  app.add_option("--level", options.level, "Clamp level (5)");
  app.add_option("--seed", options.seed, "Seed (1)");
  CLI11_PARSE(app, argc, argv);
  const Scene scene = load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/cafe.json");
  for (const std::string& key : options.objects) print_object(scene, key, options);
}
