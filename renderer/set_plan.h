// How an object's indirect light is made cheapest of VPL sets and compensation, from pilots that are then
// thrown away.
#pragma once

#include <functional>
#include <optional>

#include "renderer/allot.h"
#include "renderer/compensation.h"

namespace equilux {

/// VPL sets for trace_vpl_sets, and what is foreseen of them.
struct SetPlan {
  int clamp_level = 0;
  std::int64_t vpls = 0;  ///< of a set
  int sets = 0;
  double error_ratio = 0;
  double sets_cost = 0;  ///< units: paths
  /// Radiance of the clamped light as the pilot's paths know it: smoothed, not premultiplied, never negative.
  /// shape: height x width x 3. units: W/(m^2 sr)
  HdrImage light;
  /// Displayed errors of compensation, for one path a batch and position, and of the mean of the sets. shape:
  /// height x width. units: steps of 255
  std::vector<double> compensation_errors, set_errors;
};

/// Pilots of one object in terms of what is displayed.
struct SetPilot {
  const DisplayPilot& view;
  /// Of what paths lower beside compensation. shape: height x width. units: as compensation_errors
  std::vector<double> other_errors;
  TracedLayer indirect;                                  ///< path traced
  std::function<TracedLayer(std::size_t)> compensation;  ///< for each of list_finite_clamps
  PathMap map;                                           ///< of both
  std::uint32_t least_paths = 1;  ///< of compensation, in each batch and at each position
};

/// C1 to C10. units: 1/m^2
std::vector<double> list_finite_clamps();

/// The cheapest plan foreseen to meet the target: level, VPLs, ratio and number of sets. Empty where paths
/// are cheaper, or where no VPL can be made. Small sets, seen at some points of the object, tell how far sets
/// err: by their VPLs as 1 / VPLs, and by their representatives. `most_cost`: of path tracing. units: paths.
/// errors: InputError for lack of memory
std::optional<SetPlan> plan_vpl_sets(const FamilyScene& scene, const SetPilot& pilot,
                                     const NoiseTarget& target, double most_cost, std::uint64_t seed,
                                     const std::string& stream_name);

}  // namespace equilux
