// The room's pixels beside an object of several materials by path tracing, and by VPL sets with what their
// clamp takes given back by paths: what each costs at equal error.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
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
const std::vector<std::int64_t> kCounts{30000, 100000, 300000, 1000000};
const std::vector<double> kRatios{0.01, 0.04};
constexpr std::size_t kLevels[] = {5, 6, 7};
const std::vector<std::string> kMaterials{"MS", "MR", "BS", "BR", "GS"};

// By material and point.
using Values = std::vector<std::vector<double>>;

struct Room {
  Scene scene = load_scene(EQUILUX_SOURCE_DIR "/stimuli/scenes/cafe.json");
  World world = make_world(scene, "G0", Illumination::kIndirect);
  std::vector<Materials> materials;
  Primary primary = trace_primary(world, make_view_camera(scene, 0), kWidth, kHeight, 1);
  std::vector<ShadingPoint> points;  // those of a material of the room one after another
  std::vector<std::pair<std::size_t, std::size_t>> groups;
  std::vector<double> light;  // of the first material, path traced
  double mean = 0;

  Room() {
    for (const std::string& name : kMaterials)
      materials.push_back(make_materials(world, find_material(scene, name)));
    std::map<std::uint32_t, std::vector<ShadingPoint>> by_material;
    for (std::size_t pixel = 0; pixel < primary.hits.size(); ++pixel) {
      const PrimaryHit& hit = primary.hits[pixel];
      if (hit.kind == PrimaryKind::kRoom && hit.point.emitter < 0)
        by_material[hit.point.material].push_back({static_cast<std::uint32_t>(pixel), hit.point, hit.v});
    }
    for (auto& [material, some] : by_material) {
      groups.emplace_back(points.size(), points.size() + some.size());
      points.insert(points.end(), some.begin(), some.end());
    }
  }
};

Values make_values(const Room& room) {
  return Values(room.materials.size(), std::vector<double>(room.points.size()));
}

struct Sampled {
  Values mean, variance;  // of the mean
  double seconds = 0;
};

// Of kBatches randomisations at each point.
Sampled sample(const Room& room, int paths, const auto& estimate) {
  const StreamKey key = make_stream_key(1, "bench.backgrounds");
  Sampled sampled{make_values(room), make_values(room), 0};
  const std::size_t count = room.materials.size();
  sampled.seconds = time_s([&] {
    for_each_parallel(room.points.size(), [&](std::size_t i) {
      const ShadingPoint& point = room.points[i];
      std::vector<double> sum(count), squares(count), mean(count), light(count);
      for (std::uint64_t batch = 0; batch < kBatches; ++batch) {
        PathSampler sampler(RandomStream(key, std::uint64_t{point.pixel} * kBatches + batch));
        std::fill(mean.begin(), mean.end(), 0.0);
        for (int path = 0; path < paths / kBatches; ++path) {
          sampler.next_path();
          estimate(point, sampler, light);
          for (std::size_t m = 0; m < count; ++m) mean[m] += light[m] / (paths / kBatches);
        }
        for (std::size_t m = 0; m < count; ++m) {
          sum[m] += mean[m];
          squares[m] += mean[m] * mean[m];
        }
      }
      for (std::size_t m = 0; m < count; ++m) {
        sampled.mean[m][i] = sum[m] / kBatches;
        sampled.variance[m][i] =
            std::max(0.0, squares[m] - sum[m] * sum[m] / kBatches) / (kBatches - 1) / kBatches;
      }
    });
  });
  return sampled;
}

// Mean over the points of the variance over the square of their light, as a displayed step sees it; a dark
// point counts as one of a tenth of the mean. Of all materials.
double find_relative_variance(const Values& variance, const Values& light, double mean) {
  double sum = 0, count = 0;
  for (std::size_t m = 0; m < light.size(); ++m) {
    for (std::size_t i = 0; i < light[m].size(); ++i) {
      sum += variance[m][i] / std::pow(std::max(light[m][i], 0.1 * mean), 2);
      ++count;
    }
  }
  return sum / count;
}

double find_mean(const Values& light) {
  double sum = 0, count = 0;
  for (const auto& of_material : light) {
    for (const double value : of_material) sum += value;
    count += static_cast<double>(of_material.size());
  }
  return sum / count;
}

// Seconds of a set.
struct SetTimes {
  double trace = 0, tree = 0, shared = 0, own = 0, shared_size = 0, own_size = 0;
  double sum() const { return trace + tree + shared + own; }
};

struct SetRun {
  SetTimes times;
  Values variance;
};

SetRun run_sets(const Room& room, std::int64_t count, std::size_t level, double ratio) {
  SetRun run;
  Values sums = make_values(room), squares = sums;
  run.variance = sums;
  const double clamp = all_levels()[level];
  for (std::uint64_t seed = 1; seed <= kSets; ++seed) {
    const std::int64_t paths = find_path_count(room.world, count, seed);
    VplSet first;
    LightTree shared;
    std::vector<LightTree> own(room.materials.size());
    for (std::size_t m = 0; m < room.materials.size(); ++m) {
      VplList list;
      run.times.trace += time_s([&] {
        if (m == 0) {
          first = trace_vpls(room.world, room.materials[m], paths, seed, "backgrounds");
          list = std::move(first.own);
        } else {
          list = trace_own_vpls(room.world, room.materials[m], first, seed, "backgrounds");
        }
      });
      run.times.tree += time_s([&] {
        if (m == 0) shared = make_light_tree(std::move(first.shared), {seed, 4});
        own[m] = make_light_tree(std::move(list), {seed, 4});
      });
    }
    for (const auto& [begin, end] : room.groups) {
      const std::vector<ShadingPoint> points(room.points.begin() + static_cast<long>(begin),
                                             room.points.begin() + static_cast<long>(end));
      ShadedPoints totals{1, points.size(), {}};
      for (std::size_t i = begin; i < end; ++i) {
        const auto light = static_cast<float>(room.light[i]);
        totals.radiance.push_back({light, light, light});
      }
      const auto cut = [&](const LightTree& tree, double& seconds, double& size) {
        ShadedPoints shaded;
        CutRecord record;
        seconds += time_s([&] {
          shaded =
              shade_lightcut(room.world, points, tree, {room.materials[0][points.front().surface.material]},
                             {clamp}, {ratio, 0.02 * room.mean, &totals, false}, &record);
        });
        for (const auto one : record.sizes) size += one / static_cast<double>(room.points.size()) / kSets;
        return shaded;
      };
      const ShadedPoints common = cut(shared, run.times.shared, run.times.shared_size);
      for (std::size_t m = 0; m < room.materials.size(); ++m) {
        const ShadedPoints more = cut(own[m], run.times.own, run.times.own_size);
        for (std::size_t i = begin; i < end; ++i) {
          const double value = luminance(common.radiance[i - begin]) + luminance(more.radiance[i - begin]);
          sums[m][i] += value;
          squares[m][i] += value * value;
        }
      }
    }
  }
  for (double* time : {&run.times.trace, &run.times.tree, &run.times.shared, &run.times.own}) *time /= kSets;
  for (std::size_t m = 0; m < sums.size(); ++m) {
    for (std::size_t i = 0; i < sums[m].size(); ++i) {
      run.variance[m][i] = std::max(0.0, squares[m][i] - sums[m][i] * sums[m][i] / kSets) / (kSets - 1);
    }
  }
  return run;
}

// Seconds times variance of two estimates that add up, time shared out at best.
double add_costs(double a, double b) { return std::pow(std::sqrt(a) + std::sqrt(b), 2); }

}  // namespace
}  // namespace equilux

int main() {
  using namespace equilux;
  Room room;
  const std::size_t count = room.materials.size();
  Sampled traced = sample(room, kPaths, [&](const ShadingPoint& point, PathSampler& sampler, auto& light) {
    std::vector<Vec3> found(count);
    estimate_reflected_by_material(room.world, room.materials, point.surface, point.v, sampler, {}, found);
    for (std::size_t m = 0; m < count; ++m) light[m] = luminance(found[m]);
  });
  room.light = traced.mean[0];
  room.mean = find_mean(traced.mean);
  const auto cost = [&](const Values& variance, double seconds) {
    return seconds * find_relative_variance(variance, traced.mean, room.mean);
  };
  const double traced_cost = cost(traced.variance, traced.seconds);
  fmt::print("path tracing: {:.1f} s to 1 % in {} x {} pixels, {} materials; {:.2f} s {} paths\n\n",
             traced_cost * 1e4, kWidth, kHeight, count, traced.seconds, kPaths);
  std::map<std::size_t, double> returned;
  for (const std::size_t level : kLevels) {
    const double clamp = all_levels()[level];
    const Sampled all =
        sample(room, kCompensationPaths, [&](const ShadingPoint& point, PathSampler& sampler, auto& light) {
          std::vector<ReturnedLight> found(count);
          estimate_returned_by_material(room.world, room.materials, point.surface, point.v, {clamp, true},
                                        sampler, {}, found);
          for (std::size_t m = 0; m < count; ++m)
            light[m] = found[m].peak_per_m2 == 0 ? 0 : luminance(found[m].at(clamp));
        });
    returned[level] = cost(all.variance, all.seconds);
  }
  fmt::print(
      "| VPLs | ratio | level | clusters, shared and own | error of a set, % | sets, s to 1 % | "
      "compensation, "
      "s | all, times path tracing |\n|---|---:|---|---:|---:|---:|---:|---:|\n");
  for (const std::int64_t vpls : kCounts) {
    for (const double ratio : kRatios) {
      for (const std::size_t level : kLevels) {
        const SetRun run = run_sets(room, vpls, level, ratio);
        const double sets = cost(run.variance, run.times.sum());
        fmt::print("| {} | {} % | C{} | {:.0f} + {:.0f} | {:.1f} | {:.1f} | {:.1f} | {:.2f} |\n",
                   format_vpl_count(vpls), 100 * ratio, level, run.times.shared_size,
                   run.times.own_size / static_cast<double>(count),
                   100 * std::sqrt(find_relative_variance(run.variance, traced.mean, room.mean)), sets * 1e4,
                   returned[level] * 1e4, add_costs(sets, returned[level]) / traced_cost);
        std::fflush(stdout);
      }
    }
  }
}
