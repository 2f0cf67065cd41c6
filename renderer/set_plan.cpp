// A cost model whose few numbers come from pilots.
#include "renderer/set_plan.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <numeric>

#include "renderer/vpl_sets.h"

namespace equilux {
namespace {

constexpr int kFiniteLevels = kClampLevelCount - 1;

// Costs in units of a path, measured in the café: a VPL with its share of the tree, a cluster of a cut with
// the rays that roulette leaves of it, and a path of compensation, whose first ray is the longer the more is
// clamped.
constexpr double kVplCost = 0.7, kClusterCost = 0.07;
double cost_of_compensation(int level) { return 0.12 * std::pow(1.2, level); }

// The small sets: trees of each, at points of one subpixel position, of so many VPLs a point that the camera
// sees there.
constexpr std::size_t kPilotSets = 8, kPilotTrees = 2;
constexpr std::size_t kPilotPoints = 256;
constexpr double kPilotVplsPerPoint = 2, kFewestPilotVpls = 10000, kMostPilotVpls = 50000;
constexpr double kPilotRatio = 0.01;

// How what is measured there goes on: sizes of cuts over the number of VPLs and the ratio, and what
// representatives and roulette err by over the ratio, hardly over the number of VPLs; fitted to three objects
// of the café, 20k to 1.3M VPLs, .25 to 16 %.
constexpr double kSizeByVpls = 0.06, kSizeByRatio = -0.58;
constexpr double kVarianceByRatio = 1.1;
// What VPLs err by is a difference of two spreads, of sets and of trees, each known to a third or so: this
// share of the larger one is the least, lest sets of very few VPLs be taken and miss the target.
constexpr double kLeastOfVpls = 0.25;
// Points of a set err alike, so that eight sets may well err by a fifth more than is foreseen: a plan without
// room for that misses its target, and is made twice.
constexpr double kMoreVariance = 1.4;

// What may be chosen.
constexpr double kRatios[] = {0.0025, 0.005, 0.01, 0.02, 0.04, 0.08, 0.16};
constexpr double kFewestVpls = 10000, kMostVpls = 5e6, kVplStep = 1.5;
constexpr int kMostSets = 10000;
// Fewer tell too little of their spread.
constexpr int kFewestSets = 8;

// Levels whose compensation alone takes a larger share of the cost of path tracing are left out; and where it
// takes less than the smaller share, a weaker clamp only makes sets err more.
constexpr double kMostCompensation = 0.5, kLeastCompensation = 0.0002;

// Below it a silhouette's own light is guessed too small rather than too large.
constexpr double kLeastShare = 0.25;

// Of levels that cost alike, the hardest clamp: its sets err most evenly.
constexpr double kAlike = 1.05;

// Pixels by which a plan is priced, and numbers of sets tried over that foreseen to be best.
constexpr std::size_t kPricedPixels = 4000;
constexpr double kMoreSets[] = {1, 1.5, 2.5};

// The 99th percentile of an error that is known from some ten sets is so much over that of the error itself.
constexpr double kPercentileOfFew = 1.4;
// The same of the few small sets, over its own mean.
constexpr double kPercentileOfPilot = 1.7;

double square(double x) { return x * x; }

double sum_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

std::vector<std::size_t> list_pixels(const HdrImage& share) {
  std::vector<std::size_t> pixels;
  for (std::size_t i = 0; i < share.pixel_count(); ++i) {
    if (share.values[i] > 0) pixels.push_back(i);
  }
  return pixels;
}

// Smoothed, not premultiplied, never negative.
HdrImage find_clamped_light(const SetPilot& pilot, const HdrImage& returned) {
  const HdrImage& share = pilot.subject.share;
  HdrImage clamped = pilot.indirect.mean;
  for (std::size_t i = 0; i < clamped.values.size(); ++i) clamped.values[i] -= returned.values[i];
  const auto smooth = pilot.view.smooth(clamped);
  for (std::size_t i = 0; i < clamped.pixel_count(); ++i) {
    const double covered = std::max(kLeastShare, double{share.values[i]});
    for (std::size_t c = 0; c < 3; ++c)
      clamped.pixel(i)[c] = static_cast<float>(std::max(0.0, smooth[c][i] / covered));
  }
  return clamped;
}

// Displayed size of the clamped light itself, that is of an error of 100 %. shape: height x width
std::vector<double> find_light_sizes(const SetPilot& pilot, const HdrImage& light) {
  std::vector<double> sizes(light.pixel_count());
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const double covered = pilot.subject.share.values[i];
    const float* p = light.pixel(i);
    if (covered > 0) sizes[i] = pilot.view.find_size(i, {covered * p[0], covered * p[1], covered * p[2]});
  }
  return sizes;
}

// What the choice of sets is made for.
struct SetTask {
  const SetPilot& pilot;
  const NoiseTarget& target;
  double most_cost;
  int positions;
  std::vector<std::size_t> pixels;  // of the subject
  double points = 0;                // of one position

  // One in each batch.
  double count_pixel_paths() const { return kBatches * points * positions; }
};

// Paths that a mean error of one step costs, allotted: (mean of S^(2/3))^3 for each pixel.
double count_paths_of_one_step(const std::vector<double>& errors, const SetTask& task) {
  double sum = 0;
  for (const std::size_t i : task.pixels) {
    const double error = errors[i] + task.pilot.other_errors[i];
    sum += std::cbrt(error * error);
  }
  return task.count_pixel_paths() * std::pow(sum / static_cast<double>(task.pixels.size()), 3);
}

// One level that may be chosen.
struct Candidate {
  int level = 0;
  HdrImage light;
  std::vector<double> sizes;     // of that light
  std::vector<double> errors;    // of compensation
  double mean_size = 0;          // over the subject's pixels
  double p99_over_mean = 1;      // of the sizes
  double compensation_cost = 0;  // for a mean error of one step
  double vpl_variance = 0;       // relative, of a set of the pilot's size
  double cut_variance = 0;       // the same, of representatives alone
};

Candidate make_candidate(const SetTask& task, std::size_t level_index) {
  Candidate candidate;
  candidate.level = static_cast<int>(level_index) + 1;
  const TracedLayer compensation = task.pilot.compensation(level_index);
  candidate.light = find_clamped_light(task.pilot, compensation.mean);
  candidate.sizes = find_light_sizes(task.pilot, candidate.light);
  candidate.errors = task.pilot.view.find_errors(compensation, task.pilot.map);
  std::vector<double> of_subject;
  for (const std::size_t i : task.pixels) of_subject.push_back(candidate.sizes[i]);
  candidate.mean_size = sum_of(of_subject) / static_cast<double>(task.pixels.size());
  if (candidate.mean_size > 0)
    candidate.p99_over_mean = nearest_rank(std::move(of_subject), 0.99) / candidate.mean_size;
  candidate.compensation_cost =
      cost_of_compensation(candidate.level) * count_paths_of_one_step(candidate.errors, task);
  return candidate;
}

std::vector<Candidate> find_candidates(const SetTask& task) {
  std::vector<Candidate> candidates;
  for (std::size_t level = kFiniteLevels; level-- > 0;) {
    Candidate candidate = make_candidate(task, level);
    const double share = candidate.compensation_cost / square(task.target.object_mean) / task.most_cost;
    if (!(candidate.mean_size > 0) || share > kMostCompensation) continue;
    candidates.push_back(std::move(candidate));
    if (share < kLeastCompensation) break;
  }
  return candidates;
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

// What the small sets show beside the candidates' variances.
struct SmallSets {
  double vpls = 0;
  double cut_size = 0;
};

double channel_of(const Vec3& light, std::size_t c) { return c == 0 ? light.x : c == 1 ? light.y : light.z; }

class SetPilotTracer {
 public:
  SetPilotTracer(const FamilyScene& scene, const SetTask& task, std::vector<Candidate>& candidates)
      : scene_(scene),
        view_(task.pilot.view),
        candidates_(candidates),
        points_(draw_pilot_points(task.pilot.subject)) {
    for (const Candidate& candidate : candidates) clamps_.push_back(clamp_per_m2(candidate.level));
    for (const ShadingPoint& point : points_) {
      if (groups_.empty() || groups_.back().points.back().surface.material != point.surface.material)
        groups_.emplace_back();
      groups_.back().points.push_back(point);
    }
    for (PilotGroup& group : groups_) {
      group.totals.levels = candidates.size();
      group.totals.points = group.points.size();
      for (const Candidate& candidate : candidates) {
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
    for (std::size_t set = 0; set < kPilotSets; ++set) {
      const VplList list = join_vpls(trace_vpls(scene_.world, scene_.materials, paths, seed,
                                                fmt::format("{}.set-pilot-{}", stream_name, set)));
      small.vpls += static_cast<double>(list.size()) / kPilotSets;
      for (std::size_t tree = 0; tree < kPilotTrees; ++tree)
        small.cut_size +=
            cut(list, seed + kPilotTrees * set + tree, stream_name) / (kPilotSets * kPilotTrees);
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
          make_set_rule(kPilotRatio, find_radiance_of_step(view_.tone().record, kFloorSteps), group.totals,
                        tree_seed, fmt::format("{}.set-pilot-rays-{}", stream_name, first));
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
        std::array<double, kPilotSets> means{};
        for (std::size_t set = 0; set < kPilotSets; ++set) {
          const double one = channel_of(at(kPilotTrees * set, level, point), c),
                       two = channel_of(at(kPilotTrees * set + 1, level, point), c);
          inner[c] += square(one - two) / 2 / kPilotSets;
          means[set] = (one + two) / 2;
        }
        const double mean = std::accumulate(means.begin(), means.end(), 0.0) / kPilotSets;
        for (const double of_set : means) outer[c] += square(of_set - mean) / (kPilotSets - 1);
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
  std::vector<Candidate>& candidates_;
  std::vector<ShadingPoint> points_;
  std::vector<PilotGroup> groups_;  // of those points
  std::vector<double> clamps_;
  std::vector<ShadedPoints> lit_;
};

// A choice of numbers for one level.
struct Choice {
  double vpls = 0, ratio = 0;
  int sets = 0;
  double set_variance = 0;  // relative, of one
  double set_cost = 0;
  double cost = std::numeric_limits<double>::infinity();
};

int round_sets(double sets, int positions) {
  return count_vpl_sets(static_cast<int>(std::min<double>(sets, kMostSets)), positions);
}

// The fewest sets of one kind that leave compensation its best share of the error, and what both cost.
Choice choose_sets(const Candidate& candidate, const SmallSets& small, const SetTask& task, double vpls,
                   double ratio) {
  const double more = vpls / small.vpls, coarser = ratio / kPilotRatio;
  Choice choice;
  choice.vpls = vpls;
  choice.ratio = ratio;
  choice.set_variance = kMoreVariance * (candidate.vpl_variance / more +
                                         candidate.cut_variance * std::pow(coarser, kVarianceByRatio));
  const double size = small.cut_size * std::pow(more, kSizeByVpls) * std::pow(coarser, kSizeByRatio);
  choice.set_cost = kVplCost * vpls + kClusterCost * size * task.points;
  const double error = candidate.mean_size * std::sqrt(choice.set_variance);
  const double one = error * std::sqrt(choice.set_cost), other = std::sqrt(candidate.compensation_cost);
  const double wanted = std::min(square(task.target.object_mean) * one / (one + other),
                                 square(task.target.object_p99 / kPercentileOfFew / candidate.p99_over_mean));
  const double sets = wanted > 0 ? std::ceil(square(error) / wanted) : 0;
  choice.sets = round_sets(std::max<double>(kFewestSets, sets), task.positions);
  const double left = square(task.target.object_mean) - square(error) / choice.sets;
  if (left > 0) choice.cost = choice.sets * choice.set_cost + candidate.compensation_cost / left;
  return choice;
}

Choice find_best_choice(const Candidate& candidate, const SmallSets& small, const SetTask& task) {
  Choice best;
  for (double vpls = kFewestVpls; vpls <= kMostVpls; vpls *= kVplStep) {
    for (const double ratio : kRatios) {
      const Choice choice = choose_sets(candidate, small, task, vpls, ratio);
      if (choice.cost < best.cost) best = choice;
    }
  }
  return best;
}

// Of sets, and of paths as they would be allotted at some of the pixels.
double price(const SetTask& task, const Candidate& candidate, const Choice& choice) {
  const std::size_t count = std::min(kPricedPixels, task.pixels.size());
  std::vector<PixelError> errors;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t pixel = task.pixels[i * task.pixels.size() / count];
    errors.push_back({candidate.errors[pixel] + task.pilot.other_errors[pixel],
                      candidate.sizes[pixel] * std::sqrt(choice.set_variance / choice.sets)});
  }
  const std::vector<double> paths = foresee_paths(errors, task.positions, task.target, kPercentileBesideSets);
  double error = 0, sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    sum += std::max(paths[i], static_cast<double>(task.pilot.least_paths));
    error +=
        std::hypot(errors[i].given, errors[i].of_paths / std::sqrt(paths[i])) / static_cast<double>(count);
  }
  // Where sets alone miss the target no number of paths meets it.
  if (error > task.target.object_mean) return std::numeric_limits<double>::infinity();
  return choice.sets * choice.set_cost +
         cost_of_compensation(candidate.level) * sum / static_cast<double>(count) * task.count_pixel_paths();
}

SetPlan make_plan(Candidate candidate, const Choice& choice) {
  SetPlan plan{candidate.level,
               std::llround(choice.vpls),
               choice.sets,
               choice.ratio,
               choice.sets * choice.set_cost,
               std::move(candidate.light),
               std::move(candidate.errors),
               std::move(candidate.sizes)};
  for (double& error : plan.set_errors) error *= std::sqrt(choice.set_variance / choice.sets);
  return plan;
}

// By its price.
Choice choose_best(const SetTask& task, const Candidate& candidate, const SmallSets& small) {
  const Choice least = find_best_choice(candidate, small, task);
  Choice best;
  if (!(least.cost < task.most_cost)) return best;
  for (const double more : kMoreSets) {
    Choice choice = least;
    choice.sets = round_sets(more * choice.sets, task.positions);
    choice.cost = price(task, candidate, choice);
    if (choice.cost < best.cost) best = choice;
  }
  return best;
}

// `candidates`: the hardest clamp first.
std::optional<SetPlan> find_cheapest(std::vector<Candidate> candidates, const SmallSets& small,
                                     const SetTask& task) {
  std::vector<Choice> choices;
  double least = task.most_cost;
  for (const Candidate& candidate : candidates) {
    choices.push_back(choose_best(task, candidate, small));
    least = std::min(least, choices.back().cost);
  }
  for (std::size_t i = 0; i < choices.size(); ++i) {
    if (choices[i].cost < task.most_cost && choices[i].cost <= kAlike * least)
      return make_plan(std::move(candidates[i]), choices[i]);
  }
  return {};
}

}  // namespace

SetSubject make_object_subject(const Primary& primary) {
  SetSubject subject{make_coverage(primary), find_shading_points(take_position(primary, 0))};
  for (const PrimaryHit& hit : primary.hits)
    subject.points_a_position += hit.kind == PrimaryKind::kObject ? 1 : 0;
  subject.points_a_position /= primary.positions;
  return subject;
}

SetSubject make_room_subject(const Primary& primary, const HdrImage& coverage) {
  SetSubject subject{HdrImage(primary.width, primary.height, 1), {}, 0};
  for (std::size_t pixel = 0; pixel < coverage.pixel_count(); ++pixel) {
    double points = 0;
    for (int position = 0; position < primary.positions && coverage.values[pixel] == 0; ++position)
      points += primary.at(pixel, position).is_room_surface();
    subject.share.values[pixel] = static_cast<float>(points / primary.positions);
    subject.points_a_position += points / primary.positions;
  }
  for (const auto& of_material : find_room_points(take_position(primary, 0), coverage))
    subject.points.insert(subject.points.end(), of_material.begin(), of_material.end());
  return subject;
}

std::vector<double> list_finite_clamps() {
  std::vector<double> clamps;
  for (int level = 1; level <= kFiniteLevels; ++level) clamps.push_back(clamp_per_m2(level));
  return clamps;
}

std::optional<SetPlan> plan_vpl_sets(const FamilyScene& scene, const SetPilot& pilot,
                                     const NoiseTarget& target, double most_cost, std::uint64_t seed,
                                     const std::string& stream_name) {
  const SetTask task{pilot,
                     target,
                     most_cost,
                     scene.primary.positions,
                     list_pixels(pilot.subject.share),
                     pilot.subject.points_a_position};
  const double vpls = std::clamp(kPilotVplsPerPoint * task.points, kFewestPilotVpls, kMostPilotVpls);
  if (task.pixels.empty() || 2 * kPilotSets * kVplCost * vpls > most_cost) return {};
  std::vector<Candidate> candidates = find_candidates(task);
  if (candidates.empty()) return {};
  const SmallSets small = SetPilotTracer(scene, task, candidates).trace(vpls, seed, stream_name);
  std::optional<SetPlan> plan = find_cheapest(std::move(candidates), small, task);
  if (plan) {
    for (std::size_t i = 0; i < pilot.beside.values.size(); ++i)
      plan->light.values[i] += pilot.beside.values[i];
  }
  return plan;
}

SetPlan take_more_sets(SetPlan plan, double scale, int positions) {
  const int sets = std::max(plan.sets, round_sets(std::ceil(scale * plan.sets), positions));
  plan.sets_cost *= static_cast<double>(sets) / plan.sets;
  for (double& error : plan.set_errors) error *= std::sqrt(static_cast<double>(plan.sets) / sets);
  plan.sets = sets;
  return plan;
}

}  // namespace equilux
