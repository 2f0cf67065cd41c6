// Light of each level by what compensation's pilot returns, and what its paths would cost.
#include "renderer/set_candidates.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace equilux {
namespace {

// Levels whose compensation alone takes a larger share of the cost of path tracing are left out; and where it
// takes less than the smaller share, a weaker clamp only makes sets err more.
constexpr double kMostCompensation = 0.5, kLeastCompensation = 0.0002;

// Costs in units of a path of what a path of compensation does: its first ray, and all that follows where the
// clamp acts or gloss is met. `bench_sets` measures both.
constexpr double kFirstRayCost = 0.3, kWalkCost = 1.1;

// Below it a silhouette's own light is guessed too small rather than too large.
constexpr double kLeastShare = 0.25;

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

// Paths that a mean error of one step costs, allotted: (mean of S^(2/3))^3 for each pixel.
double count_paths_of_one_step(const std::vector<double>& errors, const SetTask& task) {
  double sum = 0;
  for (const std::size_t i : task.pixels) {
    const double error = errors[i] + task.pilot.other_errors[i];
    sum += std::cbrt(error * error);
  }
  return task.count_pixel_paths() * std::pow(sum / static_cast<double>(task.pixels.size()), 3);
}

SetCandidate make_candidate(const SetTask& task, std::size_t level_index) {
  SetCandidate candidate;
  candidate.level = static_cast<int>(level_index) + 1;
  const TracedLayer compensation = task.pilot.compensation(level_index);
  candidate.light = find_clamped_light(task.pilot, compensation.mean);
  candidate.sizes = find_light_sizes(task.pilot, candidate.light);
  candidate.errors = task.pilot.view.find_errors(compensation, task.pilot.map);
  std::vector<double> of_subject;
  for (const std::size_t i : task.pixels) of_subject.push_back(candidate.sizes[i]);
  candidate.mean_size =
      std::accumulate(of_subject.begin(), of_subject.end(), 0.0) / static_cast<double>(task.pixels.size());
  if (candidate.mean_size > 0)
    candidate.p99_over_mean = nearest_rank(std::move(of_subject), 0.99) / candidate.mean_size;
  candidate.path_cost = kFirstRayCost + kWalkCost * task.pilot.seen_of_it.walked[level_index];
  candidate.compensation_cost = candidate.path_cost * count_paths_of_one_step(candidate.errors, task);
  return candidate;
}

}  // namespace

SetTask make_set_task(const FamilyScene& scene, const SetPilot& pilot, const NoiseTarget& target,
                      double most_cost) {
  return {pilot,
          target,
          most_cost,
          scene.primary.positions,
          list_pixels(pilot.subject.share),
          pilot.subject.points_a_position};
}

std::vector<SetCandidate> find_candidates(const SetTask& task) {
  std::vector<SetCandidate> candidates;
  for (std::size_t level = list_finite_clamps().size(); level-- > 0;) {
    SetCandidate candidate = make_candidate(task, level);
    const double share = candidate.compensation_cost / std::pow(task.target.object_mean, 2) / task.most_cost;
    if (!(candidate.mean_size > 0) || share > kMostCompensation) continue;
    candidates.push_back(std::move(candidate));
    if (share < kLeastCompensation) break;
  }
  return candidates;
}

}  // namespace equilux
