// One clamp level for each object of the gallery against one for all, with and without giving back what the
// clamps take: error and time side by side.
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <vector>

#include "renderer/compensation.h"
#include "renderer/family.h"
#include "renderer/lightcut.h"
#include "tests/bench/bench.h"

namespace equilux {
namespace {

using bench::all_levels;
using bench::time_s;

constexpr int kSeeds = 3, kWidth = 280, kHeight = 210, kPositions = 1, kReferencePaths = 2048;
// With what the clamps took given back: paths a pixel by which its cost is measured; how much the sets of a
// safe level may differ; what is given back may err by. Relative to an object's mean light, rms over its
// points.
constexpr int kCompensationPaths = 64;
constexpr double kSafeSpread = 0.1, kCompensationError = 0.02;
constexpr std::int64_t kCounts[] = {10000, 30000, 100000, 300000, 1000000};

using Levels = std::array<double, kClampLevelCount>;

struct Gallery {
  Scene scene = load_scene(EQUILUX_SOURCE_DIR "/stimuli/scenes/gallery.json");
  World world = make_sculpture_world(scene, Illumination::kIndirect);
  Materials materials;
  Primary primary = trace_primary(world, make_view_camera(scene, 0), kWidth, kHeight, kPositions);
  TracedLayer reference;
  std::vector<std::vector<ShadingPoint>> points;

  Gallery() {
    std::vector<MaterialSpec> own;
    for (const Sculpture& sculpture : scene.sculptures)
      own.push_back(find_material(scene, sculpture.material));
    materials = make_materials(world, own);
    reference = trace_layers({world, materials, primary}, make_fixed_maps(primary, {kReferencePaths, 0, 0}),
                             1, "gallery", {}, [](double) {})
                    .indirect;
    for (std::size_t i = 0; i < world.objects().size(); ++i)
      points.push_back(find_shading_points(primary, static_cast<std::int32_t>(i)));
  }

  // Mean square relative error of an object's points, the reference's variance subtracted.
  double compare(std::size_t object, const ShadedPoints& shaded, std::size_t level) const {
    double square = 0, mean = 0;
    for (std::size_t i = 0; i < points[object].size(); ++i) {
      const std::size_t pixel = points[object][i].pixel;
      const Vec3 light = shaded.radiance[shaded.index(0, level, i)];
      const float values[] = {light.x, light.y, light.z};
      for (std::size_t c = 0; c < 3; ++c) {
        const double truth = reference.mean.pixel(pixel)[c], noise = reference.standard_error.pixel(pixel)[c];
        square += (values[c] - truth) * (values[c] - truth) - noise * noise;
        mean += truth;
      }
    }
    const auto count = static_cast<double>(3 * points[object].size());
    return std::max(0.0, square / count) / (mean / count * mean / count);
  }
};

// Mean over the points of the variance between shaded points of several seeds, over the square of their mean.
double find_relative_variance(const std::vector<ShadedPoints>& seeds, std::size_t points) {
  const auto n = static_cast<double>(seeds.size());
  double variance = 0, mean = 0;
  for (std::size_t i = 0; i < points; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      double sum = 0, squares = 0;
      for (const ShadedPoints& shaded : seeds) {
        const Vec3 light = shaded.radiance[shaded.index(0, 0, i)];
        const double value = std::array{light.x, light.y, light.z}[c];
        sum += value;
        squares += value * value;
      }
      variance += (squares - sum * sum / n) / (n - 1);
      mean += sum / n;
    }
  }
  const auto count = static_cast<double>(3 * points);
  return variance / count / std::pow(mean / count, 2);
}

// Of one VPL count: squares and variances by object and level, and times.
struct CountRun {
  std::vector<Levels> squares;
  std::vector<Levels> variances;  // between seeds, relative
  double set_s = 0;
  std::vector<Levels> shade_s;
};

CountRun run_count(const Gallery& gallery, std::int64_t count) {
  const std::size_t objects = gallery.points.size();
  CountRun run{std::vector<Levels>(objects), std::vector<Levels>(objects), 0, std::vector<Levels>(objects)};
  std::vector<LightTree> trees(kSeeds);
  for (int seed = 1; seed <= kSeeds; ++seed) {
    run.set_s += time_s([&] {
                   const auto random = static_cast<std::uint64_t>(seed);
                   VplSet set = trace_vpls(gallery.world, gallery.materials,
                                           find_path_count(gallery.world, count, random), random, "gallery");
                   VplList list = std::move(set.shared);
                   list.append(set.own);
                   trees[random - 1] = make_light_tree(std::move(list), {random, 4});
                 }) /
                 kSeeds;
  }
  for (std::size_t object = 0; object < objects; ++object) {
    for (std::size_t level = 0; level < kClampLevelCount; ++level) {
      std::vector<ShadedPoints> seeds;
      for (const LightTree& tree : trees) {
        ShadedPoints shaded;
        run.shade_s[object][level] +=
            time_s([&] {
              shaded = shade_lightcut(gallery.world, gallery.points[object], tree,
                                      {gallery.materials[object]}, {all_levels()[level]}, {0.0075, 1e-4});
            }) /
            kSeeds;
        run.squares[object][level] += gallery.compare(object, shaded, 0) / kSeeds;
        seeds.push_back(std::move(shaded));
      }
      run.variances[object][level] = find_relative_variance(seeds, gallery.points[object].size());
    }
  }
  return run;
}

// Of giving back what a level takes from an object: seconds times relative variance, so that a relative
// standard error e costs this over e^2 seconds.
std::vector<Levels> measure_compensation(const Gallery& gallery) {
  std::vector<Levels> costs(gallery.points.size());
  for (std::size_t object = 0; object < costs.size(); ++object) {
    PathMap map(static_cast<std::size_t>(kWidth) * kHeight, 0);
    for (const ShadingPoint& point : gallery.points[object]) map[point.pixel] = kCompensationPaths / kBatches;
    for (std::size_t level = 1; level < kClampLevelCount; ++level) {  // C0 takes nothing
      CompensationParams params;
      params.clamps_per_m2 = {all_levels()[level]};
      params.stream_name = "gallery";
      params.clamped_alone = true;
      std::vector<TracedLayer> given;
      const double seconds = time_s([&] {
        given = trace_compensation({gallery.world, gallery.materials, gallery.primary}, map, params,
                                   [](double) {});
      });
      double variance = 0, mean = 0;
      for (const ShadingPoint& point : gallery.points[object]) {
        for (std::size_t c = 0; c < 3; ++c) {
          variance += std::pow(given[0].standard_error.pixel(point.pixel)[c], 2);
          mean += gallery.reference.mean.pixel(point.pixel)[c];
        }
      }
      const auto count = static_cast<double>(3 * gallery.points[object].size());
      costs[object][level] = seconds * variance / count / std::pow(mean / count, 2);
    }
  }
  return costs;
}

// The least clamp under which the VPL sets differ by no more than is allowed; C10 where none does.
std::size_t find_safe_level(const Levels& variances) {
  std::size_t level = 0;
  while (level + 1 < kClampLevelCount && std::sqrt(variances[level]) > kSafeSpread) ++level;
  return level;
}

// Seconds of a VPL set and cuts, and of the paths that give back what the levels take until that errs by
// kCompensationError of each object's light.
struct CompensatedTime {
  double vpls = 0, paths = 0;
};

CompensatedTime find_compensated_time(const CountRun& run, const std::vector<Levels>& costs,
                                      const std::vector<std::size_t>& levels) {
  CompensatedTime time{run.set_s, 0};
  for (std::size_t object = 0; object < levels.size(); ++object) {
    time.vpls += run.shade_s[object][levels[object]];
    time.paths += costs[object][levels[object]] / (kCompensationError * kCompensationError);
  }
  return time;
}

struct Choice {
  std::vector<std::size_t> levels;
  double error = 0, seconds = 0;  // rms over the objects
};

Choice judge(const CountRun& run, std::vector<std::size_t> levels) {
  Choice choice{std::move(levels), 0, run.set_s};
  for (std::size_t object = 0; object < run.squares.size(); ++object) {
    choice.error += run.squares[object][choice.levels[object]] / static_cast<double>(run.squares.size());
    choice.seconds += run.shade_s[object][choice.levels[object]];
  }
  choice.error = std::sqrt(choice.error);
  return choice;
}

Choice choose_each(const CountRun& run) {
  std::vector<std::size_t> levels;
  for (const Levels& squares : run.squares)
    levels.push_back(
        static_cast<std::size_t>(std::min_element(squares.begin(), squares.end()) - squares.begin()));
  return judge(run, std::move(levels));
}

Choice choose_one(const CountRun& run) {
  Choice best;
  for (std::size_t level = 0; level < kClampLevelCount; ++level) {
    Choice choice = judge(run, std::vector<std::size_t>(run.squares.size(), level));
    if (level == 0 || choice.error < best.error) best = std::move(choice);
  }
  return best;
}

// The time at which a curve of falling errors reaches one, by logarithms between its counts; extrapolated
// beyond the last two.
double find_time(const std::vector<Choice>& curve, double error) {
  std::size_t i = 1;
  while (i + 1 < curve.size() && curve[i].error > error) ++i;
  const Choice &a = curve[i - 1], &b = curve[i];
  const double share = std::log(error / a.error) / std::log(b.error / a.error);
  return a.seconds * std::pow(b.seconds / a.seconds, share);
}

std::string format_levels(const std::vector<std::size_t>& levels) {
  std::string text;
  for (const std::size_t level : levels) text += fmt::format("{}C{}", text.empty() ? "" : " ", level);
  return text;
}

// What is given back makes every level right, so the least safe one is the cheapest.
void print_compensated(const std::vector<CountRun>& runs, const std::vector<Levels>& costs) {
  fmt::print(
      "\n| VPLs | one safe level | VPLs, s | paths, s | a safe level each | VPLs, s | paths, s | ratio of "
      "paths | "
      "of all |\n|---|---|---:|---:|---|---:|---:|---:|---:|\n");
  for (std::size_t i = 0; i < runs.size(); ++i) {
    std::vector<std::size_t> levels;
    for (const Levels& variances : runs[i].variances) levels.push_back(find_safe_level(variances));
    const std::size_t highest = *std::max_element(levels.begin(), levels.end());
    const CompensatedTime one = find_compensated_time(runs[i], costs, std::vector(levels.size(), highest)),
                          each = find_compensated_time(runs[i], costs, levels);
    fmt::print("| {} | C{} | {:.2f} | {:.2f} | {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n",
               format_vpl_count(kCounts[i]), highest, one.vpls, one.paths, format_levels(levels), each.vpls,
               each.paths, one.paths / each.paths, (one.vpls + one.paths) / (each.vpls + each.paths));
  }
}

}  // namespace
}  // namespace equilux

int main() {
  using namespace equilux;
  const Gallery gallery;
  std::vector<CountRun> runs;
  std::vector<Choice> one, each;
  for (const std::int64_t count : kCounts) {
    runs.push_back(run_count(gallery, count));
    one.push_back(choose_one(runs.back()));
    each.push_back(choose_each(runs.back()));
  }
  fmt::print("Objects: ");
  for (const std::string& name : gallery.world.objects()) fmt::print("{} ", name);
  fmt::print(
      "\n\n| VPLs | one level | s | rms % | a level each | s | rms % | time of one level for that error | "
      "ratio "
      "|\n|---|---|---:|---:|---|---:|---:|---:|---:|\n");
  for (std::size_t i = 0; i < one.size(); ++i) {
    const double seconds = find_time(one, each[i].error);
    fmt::print("| {} | {} | {:.2f} | {:.1f} | {} | {:.2f} | {:.1f} | {:.2f} | {:.2f} |\n",
               format_vpl_count(kCounts[i]), format_clamp(static_cast<int>(one[i].levels[0])), one[i].seconds,
               100 * one[i].error, format_levels(each[i].levels), each[i].seconds, 100 * each[i].error,
               seconds, seconds / each[i].seconds);
  }
  print_compensated(runs, measure_compensation(gallery));
}
