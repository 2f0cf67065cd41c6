// Spreads over sets, and over trees of one set.
#include "renderer/small_sets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

#include "renderer/vpl_sets.h"

namespace equilux {
namespace {

// Trees of each, at points of one subpixel position, of so many VPLs a point that the camera sees there.
constexpr std::size_t kPilotTrees = 2;
constexpr std::size_t kPilotPoints = 256;
constexpr double kPilotVplsPerPoint = 2, kFewestPilotVpls = 10000, kMostPilotVpls = 50000;

// What VPLs err by is a difference of two spreads, of sets and of trees, each known to a third or so: this
// share of the larger one is the least, lest sets of very few VPLs be taken and miss the target.
constexpr double kLeastOfVpls = 0.25;

// The 99th percentile of an error that few sets show, over its own mean, is so much over that of the error
// itself.
constexpr double kPercentileOfPilot = 1.7;

double square(double x) { return x * x; }

double sum_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

// Some points of the subject where it fills its pixel.
std::vector<ShadingPoint> draw_pilot_points(const SetSubject& subject) {
  std::vector<ShadingPoint> inner;
  for (const ShadingPoint& point : subject.points) {
    if (subject.share.values[point.pixel] == 1) inner.push_back(point);
  }
  const auto& points = inner.empty() ? subject.points : inner;
  const std::size_t count = std::min(kPilotPoints, points.size());
  std::vector<ShadingPoint> drawn;
  for (std::size_t i = 0; i < count; ++i) drawn.push_back(points[i * points.size() / count]);
  return drawn;
}

// Points of one material one after another.
struct PilotGroup {
  std::vector<ShadingPoint> points;
  ShadedPoints totals;
};

// What is to be added to the light of the rule.
Vec3 light_beside(const SetPilot& pilot, std::size_t pixel) {
  if (pilot.beside.values.empty()) return {};
  const float* p = pilot.beside.pixel(pixel);
  return {p[0], p[1], p[2]};
}

double channel_of(const Vec3& light, std::size_t c) { return c == 0 ? light.x : c == 1 ? light.y : light.z; }

class SetPilotTracer {
 public:
  SetPilotTracer(const FamilyScene& scene, const SetTask& task, std::vector<SetCandidate>& candidates)
      : scene_(scene),
        view_(task.pilot.view),
        candidates_(candidates),
        points_(draw_pilot_points(task.pilot.subject)) {
    for (const SetCandidate& candidate : candidates) clamps_.push_back(clamp_per_m2(candidate.level));
    for (const ShadingPoint& point : points_) {
      if (groups_.empty() || groups_.back().points.back().surface.material != point.surface.material)
        groups_.emplace_back();
      groups_.back().points.push_back(point);
    }
    for (PilotGroup& group : groups_) {
      group.totals.levels = candidates.size();
      group.totals.points = group.points.size();
      for (const SetCandidate& candidate : candidates) {
        for (const ShadingPoint& point : group.points) {
          const float* p = candidate.light.pixel(point.pixel);
          group.totals.radiance.push_back(Vec3{p[0], p[1], p[2]} + light_beside(task.pilot, point.pixel));
        }
      }
    }
  }

  // Fills in the candidates' variances.
  SmallSets trace(double vpls, std::uint64_t seed, const std::string& stream_name) {
    SmallSets small;
    const std::int64_t paths = find_path_count(scene_.world, std::llround(vpls), seed);
    for (std::size_t set = 0; set < kSmallSets; ++set) {
      const VplList list = join_vpls(trace_vpls(scene_.world, scene_.materials, paths, seed,
                                                fmt::format("{}.set-pilot-{}", stream_name, set)));
      small.vpls += static_cast<double>(list.size()) / kSmallSets;
      for (std::size_t tree = 0; tree < kPilotTrees; ++tree)
        small.cut_size +=
            cut(list, seed + kPilotTrees * set + tree, stream_name) / (kSmallSets * kPilotTrees);
    }
    for (std::size_t k = 0; k < candidates_.size(); ++k) compare(k);
    return small;
  }

 private:
  // Gives the mean size.
  double cut(VplList list, std::uint64_t tree_seed, const std::string& stream_name) {
    const LightTree lights = make_light_tree(std::move(list), {tree_seed, 4});
    ShadedPoints lit{candidates_.size(), points_.size(), {}};
    lit.radiance.resize(candidates_.size() * points_.size());
    double sizes = 0;
    std::size_t first = 0;
    for (const PilotGroup& group : groups_) {
      LightcutParams rule =
          make_set_rule(kSmallSetsRatio, find_radiance_of_step(view_.tone().record, kFloorSteps),
                        group.totals, tree_seed, fmt::format("{}.set-pilot-rays-{}", stream_name, first));
      rule.neighbours = 0;
      CutRecord record;
      const ShadedPoints some =
          shade_lightcut(scene_.world, group.points, lights,
                         {scene_.materials[group.points.front().surface.material]}, clamps_, rule, &record);
      sizes = std::accumulate(record.sizes.begin(), record.sizes.end(), sizes);
      for (std::size_t level = 0; level < candidates_.size(); ++level)
        std::copy_n(some.radiance.begin() + static_cast<std::ptrdiff_t>(some.index(0, level, 0)),
                    group.points.size(),
                    lit.radiance.begin() + static_cast<std::ptrdiff_t>(lit.index(0, level, first)));
      first += group.points.size();
    }
    lit_.push_back(std::move(lit));
    return sizes / static_cast<double>(std::max<std::size_t>(1, points_.size()));
  }

  // Displayed variances of one level at its points: of trees over the same VPLs, and of the sets' means.
  void compare(std::size_t level) {
    double within = 0, between = 0, light = 0;
    std::vector<double> spreads;
    for (std::size_t point = 0; point < points_.size(); ++point) {
      const std::size_t pixel = points_[point].pixel;
      std::array<double, 3> inner{}, outer{};
      for (std::size_t c = 0; c < 3; ++c) {
        std::array<double, kSmallSets> means{};
        for (std::size_t set = 0; set < kSmallSets; ++set) {
          const double one = channel_of(at(kPilotTrees * set, level, point), c),
                       two = channel_of(at(kPilotTrees * set + 1, level, point), c);
          inner[c] += square(one - two) / 2 / kSmallSets;
          means[set] = (one + two) / 2;
        }
        const double mean = std::accumulate(means.begin(), means.end(), 0.0) / kSmallSets;
        for (const double of_set : means) outer[c] += square(of_set - mean) / (kSmallSets - 1);
      }
      within += square(size_of(pixel, inner));
      spreads.push_back(size_of(pixel, outer));
      between += square(spreads.back());
      light += square(candidates_[level].sizes[pixel]);
    }
    if (!(light > 0)) return;
    const double mean_spread = sum_of(spreads) / static_cast<double>(spreads.size());
    if (mean_spread > 0)
      candidates_[level].p99_over_mean =
          std::max(candidates_[level].p99_over_mean,
                   nearest_rank(std::move(spreads), 0.99) / mean_spread / kPercentileOfPilot);
    candidates_[level].cut_variance = within / light;
    candidates_[level].vpl_variance =
        std::max(kLeastOfVpls * between, between - within / kPilotTrees) / light;
  }

  double size_of(std::size_t pixel, const std::array<double, 3>& variance) const {
    return view_.find_size(pixel, {std::sqrt(variance[0]), std::sqrt(variance[1]), std::sqrt(variance[2])});
  }

  const Vec3& at(std::size_t run, std::size_t level, std::size_t point) const {
    return lit_[run].radiance[lit_[run].index(0, level, point)];
  }

  const FamilyScene& scene_;
  const DisplayPilot& view_;
  std::vector<SetCandidate>& candidates_;
  std::vector<ShadingPoint> points_;
  std::vector<PilotGroup> groups_;  // of those points
  std::vector<double> clamps_;
  std::vector<ShadedPoints> lit_;
};

}  // namespace

double count_small_set_vpls(const SetTask& task) {
  return std::clamp(kPilotVplsPerPoint * task.points, kFewestPilotVpls, kMostPilotVpls);
}

SmallSets trace_small_sets(const FamilyScene& scene, const SetTask& task,
                           std::vector<SetCandidate>& candidates, std::uint64_t seed,
                           const std::string& stream_name) {
  return SetPilotTracer(scene, task, candidates).trace(count_small_set_vpls(task), seed, stream_name);
}

}  // namespace equilux
