// Clamp levels that VPL sets may be planned at, each by what pilots tell of it.
#pragma once

#include <vector>

#include "renderer/set_plan.h"

namespace equilux {

/// What the choice of sets is made for.
struct SetTask {
  const SetPilot& pilot;
  const NoiseTarget& target;
  double most_cost;  ///< of path tracing. units: paths
  int positions;
  std::vector<std::size_t> pixels;  ///< of the subject
  double points = 0;                ///< of one position

  /// Paths of compensation, one in each batch.
  double count_pixel_paths() const { return kBatches * points * positions; }
};

SetTask make_set_task(const FamilyScene& scene, const SetPilot& pilot, const NoiseTarget& target,
                      double most_cost);

/// One level that may be chosen. units of sizes and errors: displayed steps of 255
struct SetCandidate {
  int level = 0;
  HdrImage light;                ///< as SetPlan::light, without what is beside it
  std::vector<double> sizes;     ///< of that light, as an error of 100 % is displayed. shape: height x width
  std::vector<double> errors;    ///< of compensation. shape: height x width
  double mean_size = 0;          ///< over the subject's pixels
  double p99_over_mean = 1;      ///< of the sizes
  double path_cost = 0;          ///< of one path of compensation. units: paths
  double compensation_cost = 0;  ///< for a mean error of one step. units: paths
  double vpl_variance = 0;       ///< relative, of a small set's VPLs
  double cut_variance = 0;       ///< the same, of representatives alone
  double cut_exponent = 1;       ///< of the latter over the ratio
  double cut_size = 0;           ///< of a small set's cuts, mean. units: clusters
  double size_exponent = 0;      ///< of it over the ratio
};

/// Those that are worth a look, the hardest clamp first.
std::vector<SetCandidate> find_candidates(const SetTask& task);

}  // namespace equilux
