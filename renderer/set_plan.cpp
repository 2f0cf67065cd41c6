// A cost model whose few numbers come from pilots.
#include "renderer/set_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "renderer/set_candidates.h"
#include "renderer/small_sets.h"
#include "renderer/vpl_sets.h"

namespace equilux {
namespace {

constexpr int kFiniteLevels = kClampLevelCount - 1;

// Costs in units of a path, measured in the café: a VPL with its share of the tree, and a cluster of a cut
// with the rays that roulette leaves of it. `bench_sets` (tests/bench/sets.cpp) measures these and the
// numbers below anew.
constexpr double kVplCost = 0.55, kClusterCost = 0.06;

// How sizes of cuts go on with the number of VPLs from what small sets show; fitted to three objects of the
// café, 20k to 1.3M VPLs. What representatives and roulette err by hardly does.
constexpr double kSizeByVpls = 0.06;

// Points of a set err alike, so that eight sets may well err by a fifth more than is foreseen. What then
// misses its target costs a part of it again.
constexpr double kMoreVariance = 1.2;

// What may be chosen.
constexpr double kRatios[] = {0.0025, 0.0035, 0.005, 0.007, 0.01, 0.014, 0.02,
                              0.028,  0.04,   0.056, 0.08,  0.11, 0.16};
constexpr double kFewestVpls = 10000, kMostVpls = 5e6, kVplStep = 1.5;
constexpr int kMostSets = 10000;
// Fewer tell too little of their spread.
constexpr int kFewestSets = 8;

// Of levels that cost alike, the hardest clamp: its sets err most evenly.
constexpr double kAlike = 1.05;

// Pixels by which a plan is priced, and numbers of sets tried over that foreseen to be best.
constexpr std::size_t kPricedPixels = 4000;
constexpr double kMoreSets[] = {1, 1.5, 2.5};

// The 99th percentile of an error that is known from some ten sets is so much over that of the error itself.
constexpr double kPercentileOfFew = 1.4;

double square(double x) { return x * x; }

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
Choice choose_sets(const SetCandidate& candidate, double small_vpls, const SetTask& task, double vpls,
                   double ratio) {
  const double more = vpls / small_vpls, coarser = ratio / kSmallSetsRatio;
  Choice choice;
  choice.vpls = vpls;
  choice.ratio = ratio;
  choice.set_variance = kMoreVariance * (candidate.vpl_variance / more +
                                         candidate.cut_variance * std::pow(coarser, candidate.cut_exponent));
  const double size =
      candidate.cut_size * std::pow(more, kSizeByVpls) * std::pow(coarser, candidate.size_exponent);
  choice.set_cost = kVplCost * vpls + kClusterCost * size * task.points;
  const double error = candidate.mean_size * std::sqrt(choice.set_variance);
  const double one = error * std::sqrt(choice.set_cost), other = std::sqrt(candidate.compensation_cost);
  const double target = square(task.target.object_mean);
  // Fewer paths than the fewest are not to be had: what they err by is not asked of the sets.
  const double fewest = candidate.path_cost * task.pilot.least_paths * task.count_pixel_paths();
  const double wanted =
      std::min(std::max(target * one / (one + other), target - candidate.compensation_cost / fewest),
               square(task.target.object_p99 / kPercentileOfFew / candidate.p99_over_mean));
  const double sets = wanted > 0 ? std::ceil(square(error) / wanted) : 0;
  choice.sets = round_sets(std::max<double>(kFewestSets, sets), task.positions);
  const double left = target - square(error) / choice.sets;
  if (left > 0)
    choice.cost = choice.sets * choice.set_cost + std::max(fewest, candidate.compensation_cost / left);
  return choice;
}

Choice find_best_choice(const SetCandidate& candidate, double small_vpls, const SetTask& task) {
  Choice best;
  for (double vpls = kFewestVpls; vpls <= kMostVpls; vpls *= kVplStep) {
    for (const double ratio : kRatios) {
      const Choice choice = choose_sets(candidate, small_vpls, task, vpls, ratio);
      if (choice.cost < best.cost) best = choice;
    }
  }
  return best;
}

// Of sets, and of paths as they would be allotted at some of the pixels.
double price(const SetTask& task, const SetCandidate& candidate, const Choice& choice) {
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
         candidate.path_cost * sum / static_cast<double>(count) * task.count_pixel_paths();
}

SetPlan make_plan(SetCandidate candidate, const Choice& choice) {
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
Choice choose_best(const SetTask& task, const SetCandidate& candidate, double small_vpls) {
  const Choice least = find_best_choice(candidate, small_vpls, task);
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
std::optional<SetPlan> find_cheapest(std::vector<SetCandidate> candidates, double small_vpls,
                                     const SetTask& task) {
  std::vector<Choice> choices;
  double least = task.most_cost;
  for (const SetCandidate& candidate : candidates) {
    choices.push_back(choose_best(task, candidate, small_vpls));
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
  const SetTask task = make_set_task(scene, pilot, target, most_cost);
  if (task.pixels.empty() || 2 * kSmallSets * kVplCost * count_small_set_vpls(task) > most_cost) return {};
  std::vector<SetCandidate> candidates = find_candidates(task);
  if (candidates.empty() || !find_vpls_per_path(scene.world, seed)) return {};
  const double small_vpls = trace_small_sets(scene, task, candidates, seed, stream_name);
  if (!(small_vpls > 0)) return {};
  std::optional<SetPlan> plan = find_cheapest(std::move(candidates), small_vpls, task);
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
