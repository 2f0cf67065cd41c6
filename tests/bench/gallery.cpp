// One clamp level for each object of the gallery against one for all: error and time side by side.
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <vector>

#include "renderer/family.h"
#include "renderer/lightcut.h"
#include "tests/bench/bench.h"

namespace equilux {
namespace {

using bench::all_levels;
using bench::time_s;

constexpr int kSeeds = 3, kWidth = 280, kHeight = 210, kPositions = 1, kReferencePaths = 2048;
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

// Of one VPL count: squares by object and level, and times.
struct CountRun {
  std::vector<Levels> squares;
  double set_s = 0;
  std::vector<Levels> shade_s;
};

CountRun run_count(const Gallery& gallery, std::int64_t count) {
  const std::size_t objects = gallery.points.size();
  CountRun run{std::vector<Levels>(objects), 0, std::vector<Levels>(objects)};
  for (int seed = 1; seed <= kSeeds; ++seed) {
    LightTree tree;
    run.set_s += time_s([&] {
                   const auto random = static_cast<std::uint64_t>(seed);
                   VplSet set = trace_vpls(gallery.world, gallery.materials,
                                           find_path_count(gallery.world, count, random), random, "gallery");
                   VplList list = std::move(set.shared);
                   list.append(set.own);
                   tree = make_light_tree(std::move(list), {random, 4});
                 }) /
                 kSeeds;
    for (std::size_t object = 0; object < objects; ++object) {
      for (std::size_t level = 0; level < kClampLevelCount; ++level) {
        ShadedPoints shaded;
        run.shade_s[object][level] +=
            time_s([&] {
              shaded = shade_lightcut(gallery.world, gallery.points[object], tree,
                                      {gallery.materials[object]}, {all_levels()[level]}, {0.0075, 1e-4});
            }) /
            kSeeds;
        run.squares[object][level] += gallery.compare(object, shaded, 0) / kSeeds;
      }
    }
  }
  return run;
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

std::string format_levels(const Choice& choice) {
  std::string text;
  for (const std::size_t level : choice.levels) text += fmt::format("{}C{}", text.empty() ? "" : " ", level);
  return text;
}

}  // namespace
}  // namespace equilux

int main() {
  using namespace equilux;
  const Gallery gallery;
  std::vector<Choice> one, each;
  for (const std::int64_t count : kCounts) {
    const CountRun run = run_count(gallery, count);
    one.push_back(choose_one(run));
    each.push_back(choose_each(run));
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
               100 * one[i].error, format_levels(each[i]), each[i].seconds, 100 * each[i].error, seconds,
               seconds / each[i].seconds);
  }
}
