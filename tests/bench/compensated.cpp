// Processor time to equal error of references by VPL sets and compensation against path tracing; prints a
// Markdown table.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

#include "renderer/reference.h"
#include "renderer/stopwatch.h"

namespace {

using namespace equilux;

struct Options {
  std::vector<std::string> objects{"G0-MS-ind", "G2-MR-ind", "G0-GS-ind", "G1-LG-ind"};
  int width = 280, height = 210;
  double object_mean = 1, of_paths = 1;
  std::uint64_t seed = 1;
};

struct Outcome {
  FamilyLayers layers;
  DisplayNoise noise;
  double seconds = 0;  // of processors
  double rms = 0;      // standard error of the object's indirect and direct light over that light
};

// Where the object fills its pixel, of its light; without the worst thousandth of the pixels: one rare bright
// path, which both methods have, would decide between them.
double measure_rms(const FamilyLayers& layers, const HdrImage& coverage) {
  std::vector<double> squares;
  double light = 0;
  for (std::size_t i = 0; i < coverage.pixel_count(); ++i) {
    if (coverage.values[i] < 1) continue;
    double square = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      square += std::pow(layers.standard_error.pixel(i)[c], 2);
      light += std::pow(layers.direct.pixel(i)[c] + layers.indirect.pixel(i)[c], 2);
    }
    squares.push_back(square);
  }
  std::sort(squares.begin(), squares.end());
  squares.resize(squares.size() - squares.size() / 1000);
  return std::sqrt(std::accumulate(squares.begin(), squares.end(), 0.0) / light);
}

// rms of the two methods' difference over what their standard errors foresee.
double compare(const Outcome& a, const Outcome& b, const HdrImage& coverage) {
  double squares = 0, foreseen = 0;
  for (std::size_t i = 0; i < coverage.pixel_count(); ++i) {
    if (coverage.values[i] < 1) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      squares += std::pow(a.layers.indirect.pixel(i)[c] - b.layers.indirect.pixel(i)[c], 2);
      foreseen +=
          std::pow(a.layers.standard_error.pixel(i)[c], 2) + std::pow(b.layers.standard_error.pixel(i)[c], 2);
    }
  }
  return std::sqrt(squares / foreseen);
}

void print_row(const Scene& scene, const std::string& key, const Options& options) {
  const Object object = parse_family(key + "-ref-v0", "--objects").object;
  const World world = make_world(scene, object.geometry, object.illumination);
  const Materials materials = make_materials(world, find_material(scene, object.material));
  const Primary primary = trace_primary(world, make_view_camera(scene, 0), options.width, options.height, 4);
  const FamilyScene family{world, materials, primary};
  const HdrImage coverage = make_coverage(primary);
  const FamilyProgress progress{[](double) {}, [](double) {}};
  ReferenceParams params;
  params.stream_name = params.background_stream_name = "bench";
  params.seed = options.seed;
  params.target = {options.object_mean, 3 * options.object_mean, 4};
  const BackgroundPlan plan = plan_background(world, primary, params, progress);
  const std::vector<Background> room =
      trace_planned_backgrounds({world, {&materials, 1}, primary}, plan, params, progress);
  const auto trace = [&](ReferenceMethod method) {
    params.method = method;
    const double mean = method == ReferenceMethod::kPath ? options.of_paths : options.object_mean;
    params.target = {mean, 3 * mean, 4};
    Outcome outcome;
    const double start = measure_processor_seconds();
    outcome.layers = trace_object(family, plan, room[0], params, progress);
    outcome.seconds = measure_processor_seconds() - start;
    const HdrImage reference =
        composite({&outcome.layers.background, &outcome.layers.direct, &outcome.layers.indirect});
    outcome.noise = measure_display_noise(reference, outcome.layers.standard_error, coverage,
                                          make_tone_curve(reference, coverage, ToneMapping{}));
    outcome.rms = measure_rms(outcome.layers, coverage);
    return outcome;
  };
  const Outcome sets = trace(ReferenceMethod::kCompensated), paths = trace(ReferenceMethod::kPath);
  const auto cost = [](const Outcome& outcome) { return outcome.seconds * outcome.rms * outcome.rms; };
  std::string how = "paths", worst;
  if (const auto& made = sets.layers.sets) {
    how = fmt::format("C{}, {} sets of {:.0f}k, {:.2g} %, {:.0f} clusters, {:.0f} paths a pixel",
                      made->clamp_level, made->sets, made->mean_vpls / 1000, 100 * made->error_ratio,
                      made->mean_clusters,
                      made->compensation_paths / std::count_if(coverage.values.begin(), coverage.values.end(),
                                                               [](float covered) { return covered > 0; }));
    if (!sets.layers.added.empty()) how += fmt::format(", {} added", sets.layers.added.size());
    double most = 0;
    for (const RegionCheck& region : made->regions) most = std::max(most, std::abs(region.z()));
    worst = fmt::format("{:.1f}", most);
  }
  fmt::print(
      "| {} | {} | {:.1f} | {:.2f}, {:.2f} | {:.2f} | {:.1f} | {:.2f}, {:.2f} | {:.2f} | {:.1f} | {:.2f} | "
      "{} |\n",
      key, how, sets.seconds, sets.noise.object_mean, sets.noise.object_p99, 100 * sets.rms, paths.seconds,
      paths.noise.object_mean, paths.noise.object_p99, 100 * paths.rms, cost(paths) / cost(sets),
      compare(sets, paths, coverage), worst);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Time to equal error of references by VPL sets and compensation against path tracing");
  app.add_option("--objects", options.objects, "Such as G0-MS-ind")->delimiter(',');
  app.add_option("--width", options.width, "Pixels");
  app.add_option("--height", options.height, "Pixels");
  app.add_option("--target", options.object_mean, "Standard error on the object, steps of 255 (1)");
  app.add_option("--paths-target", options.of_paths, "The same for path tracing, whose time is scaled (1)");
  app.add_option("--seed", options.seed, "Seed (1)");
  CLI11_PARSE(app, argc, argv);
  const Scene scene = load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/cafe.json");
  fmt::print(
      "| object | compensated | s | mean, p99 | rms % | paths, s | mean, p99 | rms % | time to equal rms "
      "error | "
      "difference over foreseen | largest z of a region "
      "|\n|---|---|---:|---|---:|---:|---|---:|---:|---:|---:|\n");
  for (const std::string& key : options.objects) print_row(scene, key, options);
}
