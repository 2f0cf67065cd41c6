// The room's pixels by path tracing, and by VPL sets with what their clamp takes given back by paths: what
// each costs at equal error.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <map>
#include <vector>

#include "renderer/family.h"
#include "renderer/lightcut.h"
#include "renderer/parallel.h"
#include "renderer/path_tracer.h"
#include "tests/bench/bench.h"

namespace equilux {
namespace {

using bench::all_levels;
using bench::time_s;

constexpr int kWidth = 140, kHeight = 105, kSets = 6;
constexpr int kPaths = 1024;  // of path tracing; a pixel of the paper's study takes about as many
constexpr int kCompensationPaths = 128;
constexpr std::int64_t kCounts[] = {30000, 300000, 3000000};
constexpr std::size_t kLevels[] = {2, 3, 4, 5, 6, 7, 8, 10};
constexpr double kErrorRatio = 0.03;  // of cuts: coarse, since the mean of sets forgives it

struct Room {
  Scene scene = load_scene(EQUILUX_SOURCE_DIR "/stimuli/scenes/cafe.json");
  World world = make_world(scene, "G0", Illumination::kIndirect);
  Materials materials = make_materials(world, find_material(scene, "MS"));
  Primary primary = trace_primary(world, make_view_camera(scene, 0), kWidth, kHeight, 1);
  std::vector<std::vector<ShadingPoint>> points;  // by material
  double mean = 0;                                // luminance, path traced

  Room() {
    std::map<std::uint32_t, std::vector<ShadingPoint>> by_material;
    for (std::size_t pixel = 0; pixel < primary.hits.size(); ++pixel) {
      const PrimaryHit& hit = primary.hits[pixel];
      if (hit.kind == PrimaryKind::kRoom && hit.point.emitter < 0)
        by_material[hit.point.material].push_back({static_cast<std::uint32_t>(pixel), hit.point, hit.v});
    }
    for (auto& [material, some] : by_material) points.push_back(std::move(some));
  }
};

// By group and point.
using Values = std::vector<std::vector<double>>;

Values make_values(const Room& room) {
  Values values;
  for (const auto& group : room.points) values.emplace_back(group.size(), 0.0);
  return values;
}

struct Sampled {
  Values mean, variance;  // of the mean
  double seconds = 0;
};

// Of kBatches randomisations at each point.
Sampled sample(const Room& room, int paths,
               const std::function<double(const ShadingPoint&, PathSampler&)>& estimate) {
  const StreamKey key = make_stream_key(1, "bench.backgrounds");
  Sampled sampled{make_values(room), make_values(room), 0};
  sampled.seconds = time_s([&] {
    for (std::size_t group = 0; group < room.points.size(); ++group) {
      for_each_parallel(room.points[group].size(), [&](std::size_t i) {
        const ShadingPoint& point = room.points[group][i];
        double sum = 0, squares = 0;
        for (std::uint64_t batch = 0; batch < kBatches; ++batch) {
          PathSampler sampler(RandomStream(key, std::uint64_t{point.pixel} * kBatches + batch));
          double mean = 0;
          for (int path = 0; path < paths / kBatches; ++path) {
            sampler.next_path();
            mean += estimate(point, sampler) / (paths / kBatches);
          }
          sum += mean;
          squares += mean * mean;
        }
        sampled.mean[group][i] = sum / kBatches;
        sampled.variance[group][i] =
            std::max(0.0, squares - sum * sum / kBatches) / (kBatches - 1) / kBatches;
      });
    }
  });
  return sampled;
}

// Mean over the points of the variance over the square of their light, as a displayed step sees it; a dark
// point counts as one of a tenth of the mean.
double find_relative_variance(const Values& variance, const Values& light, double mean) {
  double sum = 0, count = 0;
  for (std::size_t group = 0; group < light.size(); ++group) {
    for (std::size_t i = 0; i < light[group].size(); ++i) {
      sum += variance[group][i] / std::pow(std::max(light[group][i], 0.1 * mean), 2);
      ++count;
    }
  }
  return sum / count;
}

double find_mean(const Values& light) {
  double sum = 0, count = 0;
  for (const auto& group : light) {
    for (const double value : group) sum += value;
    count += static_cast<double>(group.size());
  }
  return sum / count;
}

// Of one VPL count: seconds of a set and of its cuts, and the variance between sets, by level.
struct SetRun {
  double set_s = 0;
  std::map<std::size_t, double> cut_s;
  std::map<std::size_t, Values> variance;
};

SetRun run_sets(const Room& room, std::int64_t count) {
  SetRun run;
  std::map<std::size_t, Values> sums, squares;
  for (const std::size_t level : kLevels)
    sums[level] = squares[level] = run.variance[level] = make_values(room);
  for (std::uint64_t seed = 1; seed <= kSets; ++seed) {
    LightTree tree;
    run.set_s += time_s([&] {
                   VplSet set = trace_vpls(room.world, room.materials,
                                           find_path_count(room.world, count, seed), seed, "backgrounds");
                   VplList list = std::move(set.shared);
                   list.append(set.own);
                   tree = make_light_tree(std::move(list), {seed, 4});
                 }) /
                 kSets;
    for (const std::size_t level : kLevels) {
      for (std::size_t group = 0; group < room.points.size(); ++group) {
        const auto& points = room.points[group];
        ShadedPoints shaded;
        run.cut_s[level] += time_s([&] {
                              shaded = shade_lightcut(room.world, points, tree,
                                                      {room.materials[points.front().surface.material]},
                                                      {all_levels()[level]}, {kErrorRatio, 0.02 * room.mean});
                            }) /
                            kSets;
        for (std::size_t i = 0; i < points.size(); ++i) {
          const double value = luminance(shaded.radiance[shaded.index(0, 0, i)]);
          sums[level][group][i] += value;
          squares[level][group][i] += value * value;
        }
      }
    }
  }
  for (const std::size_t level : kLevels) {
    for (std::size_t group = 0; group < room.points.size(); ++group) {
      for (std::size_t i = 0; i < room.points[group].size(); ++i) {
        const double sum = sums[level][group][i];
        run.variance[level][group][i] =
            std::max(0.0, squares[level][group][i] - sum * sum / kSets) / (kSets - 1);
      }
    }
  }
  return run;
}

// Without `gloss` the clamp's part alone: what Lambertian VPLs lack of what gloss sends on is left out.
Sampled sample_compensation(const Room& room, std::size_t level, bool gloss) {
  const double clamp = all_levels()[level];
  return sample(room, kCompensationPaths, [&](const ShadingPoint& point, PathSampler& sampler) {
    ReturnedLight light =
        estimate_returned(room.world, room.materials, point.surface, point.v, {clamp, gloss}, sampler);
    if (light.peak_per_m2 == 0) return 0.0;
    if (!gloss) light.missing = {};
    return static_cast<double>(luminance(light.at(clamp)));
  });
}

// Seconds times variance of two estimates that add up, time shared out at best.
double add_costs(double a, double b) { return std::pow(std::sqrt(a) + std::sqrt(b), 2); }

}  // namespace
}  // namespace equilux

int main() {
  using namespace equilux;
  Room room;
  const Sampled traced = sample(room, kPaths, [&](const ShadingPoint& point, PathSampler& sampler) {
    return static_cast<double>(
        luminance(estimate_reflected(room.world, room.materials, point.surface, point.v, false, sampler)));
  });
  room.mean = find_mean(traced.mean);
  const auto cost = [&](const Values& variance, double seconds) {
    return seconds * find_relative_variance(variance, traced.mean, room.mean);
  };
  const double traced_cost = cost(traced.variance, traced.seconds);
  fmt::print("path tracing: {:.1f} s to 1 % in {} x {} pixels\n\n", traced_cost * 1e4, kWidth, kHeight);
  std::map<std::size_t, double> clamp_alone, with_gloss;
  for (const std::size_t level : kLevels) {
    const Sampled clamped = sample_compensation(room, level, false),
                  all = sample_compensation(room, level, true);
    clamp_alone[level] = cost(clamped.variance, clamped.seconds);
    with_gloss[level] = cost(all.variance, all.seconds);
  }
  fmt::print(
      "| VPLs | level | sets, s to 1 % | what the clamp takes, s | and what gloss sends on, s | both, times "
      "path "
      "tracing | without the latter |\n|---|---|---:|---:|---:|---:|---:|\n");
  for (const std::int64_t count : kCounts) {
    const SetRun run = run_sets(room, count);
    for (const std::size_t level : kLevels) {
      const double sets = cost(run.variance.at(level), run.set_s + run.cut_s.at(level));
      fmt::print("| {} | C{} | {:.1f} | {:.1f} | {:.1f} | {:.2f} | {:.2f} |\n", format_vpl_count(count),
                 level, sets * 1e4, clamp_alone[level] * 1e4, with_gloss[level] * 1e4,
                 add_costs(sets, with_gloss[level]) / traced_cost,
                 add_costs(sets, clamp_alone[level]) / traced_cost);
    }
  }
}
