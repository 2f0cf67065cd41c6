// Spreads over sets, and over trees of one set.
#include "renderer/small_sets.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

#include "renderer/parallel.h"
#include "renderer/vpl_sets.h"

namespace equilux {
namespace {

// Trees of each, at points of one subpixel position, of so many VPLs a point that the camera sees there.
constexpr std::size_t kPilotTrees = 2;
constexpr std::size_t kPilotPoints = 128;
constexpr double kPilotVplsPerPoint = 2, kFewestPilotVpls = 10000, kMostPilotVpls = 50000;

// Of them those by which VPLs are told to be near.
constexpr std::size_t kPointsStride = 8;

// What VPLs err by is a difference of two spreads, of sets and of trees, each known to a third or so: this
// share of the larger one is the least, lest sets of very few VPLs be taken and miss the target.
constexpr double kLeastOfVpls = 0.25;

// The 99th percentile of an error that few sets show, over its own mean, is so much over that of the error
// itself.
constexpr double kPercentileOfPilot = 1.7;

// What is believed of how variances and sizes go with the ratio: from evenly spread representatives to such
// as are all alike.
constexpr double kLeastVarianceExponent = 0.7, kMostVarianceExponent = 2;
constexpr double kLeastSizeExponent = -0.8, kMostSizeExponent = -0.2;

double square(double x) { return x * x; }

// Of a power of the ratio that goes through both; the middle of the limits where nothing is known.
double find_exponent(double fine, double coarse, double least, double most) {
  if (!(fine > 0) || !(coarse > 0)) return (least + most) / 2;
  return std::clamp(std::log(coarse / fine) / std::log(kCoarseRatio / kSmallSetsRatio), least, most);
}

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
  std::vector<ShadedPoints> totals;  // of each level
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
        pilot_(task.pilot),
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
      for (const SetCandidate& candidate : candidates) {
        ShadedPoints totals{1, group.points.size(), {}};
        for (const ShadingPoint& point : group.points) {
          const float* p = candidate.light.pixel(point.pixel);
          totals.radiance.push_back(Vec3{p[0], p[1], p[2]} + light_beside(task.pilot, point.pixel));
        }
        group.totals.push_back(std::move(totals));
      }
    }
    for (Cuts* cuts : {&fine_, &coarse_}) cuts->trees.resize(kSmallSets * kPilotTrees);
  }

  // Fills in what the candidates are to know.
  double trace(double vpls, std::uint64_t seed, const std::string& stream_name) {
    const std::int64_t paths = find_path_count(scene_.world, std::llround(vpls), seed);
    std::vector<VplList> lists;
    double made = 0;
    for (std::size_t set = 0; set < kSmallSets; ++set) {
      lists.push_back(join_vpls(trace_vpls(scene_.world, scene_.materials, paths, seed,
                                           fmt::format("{}.set-pilot-{}", stream_name, set))));
      made += static_cast<double>(lists.back().size()) / kSmallSets;
    }
    // The points of one call are few: trees, not points, are what threads share.
    for_each_parallel(kSmallSets * kPilotTrees, [&](std::size_t tree) {
      const LightTree lights = make_light_tree(lists[tree / kPilotTrees], {seed + tree, 4});
      for (Cuts* cuts : {&fine_, &coarse_}) cuts->trees[tree] = cut(lights, *cuts, seed + tree, stream_name);
    });
    for (std::size_t k = 0; k < candidates_.size(); ++k) compare(k);
    add_near_vpls(lists);
    return made;
  }

 private:
  // What cuts of one tree give.
  struct TreeCuts {
    ShadedPoints lit;
    std::vector<double> sizes;  // by level, summed
  };

  // What cuts of one ratio give, of each tree of each set.
  struct Cuts {
    double ratio = 0;
    const char* name = "";
    std::vector<TreeCuts> trees = {};

    double count_clusters(std::size_t level) const {
      double sum = 0;
      for (const TreeCuts& tree : trees) sum += tree.sizes[level];
      return sum;
    }
  };

  // Level by level, as the sets themselves: one cut for all of them would be longer and err less.
  TreeCuts cut(const LightTree& lights, const Cuts& how, std::uint64_t tree_seed,
               const std::string& stream_name) const {
    TreeCuts cuts{{candidates_.size(), points_.size(), {}}, std::vector<double>(candidates_.size())};
    for (std::size_t level = 0; level < candidates_.size(); ++level) {
      for (const PilotGroup& group : groups_) {
        LightcutParams rule = make_set_rule(
            how.ratio, find_radiance_of_step(view_.tone().record, kFloorSteps), group.totals[level],
            tree_seed, fmt::format("{}.set-pilot-{}-{}", stream_name, how.name, cuts.lit.radiance.size()));
        rule.neighbours = 0;
        CutRecord record;
        const ShadedPoints some = shade_lightcut(scene_.world, group.points, lights,
                                                 {scene_.materials[group.points.front().surface.material]},
                                                 {clamps_[level]}, rule, &record);
        cuts.sizes[level] = std::accumulate(record.sizes.begin(), record.sizes.end(), cuts.sizes[level]);
        cuts.lit.radiance.insert(cuts.lit.radiance.end(), some.radiance.begin(), some.radiance.end());
      }
    }
    return cuts;
  }

  // Of a channel at a point: half the mean square of what trees of one set differ by.
  double find_variance_within(const Cuts& cuts, std::size_t level, std::size_t point, std::size_t c) const {
    double variance = 0;
    for (std::size_t set = 0; set < kSmallSets; ++set) {
      const double one = channel_of(at(cuts, kPilotTrees * set, level, point), c),
                   two = channel_of(at(cuts, kPilotTrees * set + 1, level, point), c);
      variance += square(one - two) / 2 / kSmallSets;
    }
    return variance;
  }

  // Sizes of one level's cuts, and displayed variances at its points: of trees over the same VPLs, and of the
  // sets' means.
  void compare(std::size_t level) {
    SetCandidate& candidate = candidates_[level];
    const std::size_t cuts = kSmallSets * kPilotTrees * points_.size();
    candidate.cut_size = fine_.count_clusters(level) / static_cast<double>(std::max<std::size_t>(1, cuts));
    candidate.size_exponent = find_exponent(fine_.count_clusters(level), coarse_.count_clusters(level),
                                            kLeastSizeExponent, kMostSizeExponent);
    double within = 0, within_coarse = 0, between = 0, light = 0;
    std::vector<double> spreads;
    for (std::size_t point = 0; point < points_.size(); ++point) {
      const std::size_t pixel = points_[point].pixel;
      std::array<double, 3> inner{}, coarse{}, outer{};
      for (std::size_t c = 0; c < 3; ++c) {
        inner[c] = find_variance_within(fine_, level, point, c);
        coarse[c] = find_variance_within(coarse_, level, point, c);
        std::array<double, kSmallSets> means{};
        for (std::size_t set = 0; set < kSmallSets; ++set) {
          means[set] = (channel_of(at(fine_, kPilotTrees * set, level, point), c) +
                        channel_of(at(fine_, kPilotTrees * set + 1, level, point), c)) /
                       2;
        }
        const double mean = std::accumulate(means.begin(), means.end(), 0.0) / kSmallSets;
        for (const double of_set : means) outer[c] += square(of_set - mean) / (kSmallSets - 1);
      }
      within += square(size_of(pixel, inner));
      within_coarse += square(size_of(pixel, coarse));
      spreads.push_back(size_of(pixel, outer));
      between += square(spreads.back());
      light += square(candidate.sizes[pixel]);
    }
    if (!(light > 0)) return;
    const double mean_spread = sum_of(spreads) / static_cast<double>(spreads.size());
    if (mean_spread > 0)
      candidate.p99_over_mean = std::max(
          candidate.p99_over_mean, nearest_rank(std::move(spreads), 0.99) / mean_spread / kPercentileOfPilot);
    candidate.cut_variance = within / light;
    candidate.cut_exponent =
        find_exponent(within, within_coarse, kLeastVarianceExponent, kMostVarianceExponent);
    candidate.vpl_variance = std::max(kLeastOfVpls * between, between - within / kPilotTrees) / light;
  }

  // Few points see too little of VPLs that are near and rare, which weak clamps leave bright. So what a
  // level's VPLs err by beyond those of the hardest clamp is what compensation's paths foresee, which look
  // for such places at every pixel.
  void add_near_vpls(const std::vector<VplList>& lists) {
    std::array<double, 3> intensity{};
    std::vector<SurfacePoint> some;
    for (std::size_t i = 0; i < points_.size(); i += kPointsStride) some.push_back(points_[i].surface);
    for (const VplList& list : lists) {
      const std::array<double, 3> of_list = measure_intensity(list, some);
      for (std::size_t c = 0; c < 3; ++c) intensity[c] += of_list[c] / kSmallSets;
    }
    const auto sum_variance = [&](std::size_t level) {
      const HdrImage& variance =
          pilot_.seen_of_it.variances[static_cast<std::size_t>(candidates_[level].level - 1)];
      double sum = 0;
      for (std::size_t i = 0; i < pilot_.seen.size(); ++i) {
        if (pilot_.seen[i] == 0) continue;
        const float* of_pixel = variance.pixel(i);
        sum += square(
            size_of(i, {intensity[0] * of_pixel[0], intensity[1] * of_pixel[1], intensity[2] * of_pixel[2]}));
      }
      return sum;
    };
    const auto sum_light = [&](std::size_t level) {
      double sum = 0;
      for (std::size_t i = 0; i < pilot_.seen.size(); ++i)
        sum += pilot_.seen[i] == 0 ? 0 : square(candidates_[level].sizes[i]);
      return sum;
    };
    const double least = sum_variance(0), far = candidates_[0].vpl_variance * sum_light(0);
    for (std::size_t k = 1; k < candidates_.size(); ++k) {
      const double light = sum_light(k);
      if (!(light > 0)) continue;
      const double foreseen = (far + sum_variance(k) - least) / light;
      // Where the points saw nothing of the hardest level, what they saw of this one counts too.
      candidates_[k].vpl_variance = far > 0 ? foreseen : std::max(foreseen, candidates_[k].vpl_variance);
    }
  }

  double size_of(std::size_t pixel, const std::array<double, 3>& variance) const {
    return view_.find_size(pixel, {std::sqrt(variance[0]), std::sqrt(variance[1]), std::sqrt(variance[2])});
  }

  static const Vec3& at(const Cuts& cuts, std::size_t tree, std::size_t level, std::size_t point) {
    const ShadedPoints& lit = cuts.trees[tree].lit;
    return lit.radiance[lit.index(0, level, point)];
  }

  const FamilyScene& scene_;
  const SetPilot& pilot_;
  const DisplayPilot& view_;
  std::vector<SetCandidate>& candidates_;
  std::vector<ShadingPoint> points_;
  std::vector<PilotGroup> groups_;  // of those points
  std::vector<double> clamps_;
  Cuts fine_{kSmallSetsRatio, "rays"}, coarse_{kCoarseRatio, "coarse-rays"};
};

}  // namespace

double count_small_set_vpls(const SetTask& task) {
  return std::clamp(kPilotVplsPerPoint * task.points, kFewestPilotVpls, kMostPilotVpls);
}

double trace_small_sets(const FamilyScene& scene, const SetTask& task, std::vector<SetCandidate>& candidates,
                        std::uint64_t seed, const std::string& stream_name) {
  return SetPilotTracer(scene, task, candidates).trace(count_small_set_vpls(task), seed, stream_name);
}

}  // namespace equilux
