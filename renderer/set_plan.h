// How the indirect light of an object, or of the room, is made cheapest of VPL sets and compensation, from
// pilots that are then thrown away.
#pragma once

#include <functional>
#include <optional>

#include "renderer/allot.h"
#include "renderer/compensation.h"
#include "renderer/shade.h"

namespace equilux {

/// What sets are planned for: an object, or the room.
struct SetSubject {
  HdrImage share;                    ///< of a pixel that it fills. shape: height x width x 1
  std::vector<ShadingPoint> points;  ///< through the first position, those of a material together
  double points_a_position = 0;
};

SetSubject make_object_subject(const Primary& primary);
/// Pixels that no object covers any of.
SetSubject make_room_subject(const Primary& primary, const HdrImage& coverage);

/// VPL sets for trace_vpl_sets, and what is foreseen of them.
struct SetPlan {
  int clamp_level = 0;
  std::int64_t vpls = 0;  ///< of a set
  int sets = 0;
  double error_ratio = 0;
  double sets_cost = 0;  ///< units: paths
  /// Radiance that the rule of the cuts goes by: of the clamped light as the pilot's paths know it, smoothed,
  /// and of what is beside it. Not premultiplied, never negative. shape: height x width x 3. units:
  /// W/(m^2 sr)
  HdrImage light;
  /// Displayed errors of compensation, for one path a batch and position, and of the mean of the sets, should
  /// these err by a tenth more than is foreseen. shape: height x width. units: steps of 255
  std::vector<double> compensation_errors, set_errors;
};

/// Its pilots in terms of what is displayed.
struct SetPilot {
  const DisplayPilot& view;
  SetSubject subject;
  /// Of what paths lower beside compensation. shape: height x width. units: as compensation_errors
  std::vector<double> other_errors;
  TracedLayer indirect;                                  ///< path traced
  std::function<TracedLayer(std::size_t)> compensation;  ///< for each of list_finite_clamps
  CompensationRecord seen_of_it;                         ///< of the same
  PathMap seen;                                          ///< by both layers, before what is between is filled
  PathMap map;                                           ///< of both layers
  std::uint32_t least_paths = 1;  ///< of compensation, in each batch and at each position
  /// Light that the rule of the cuts counts in beside its own; empty: none. As SetPlan::light
  HdrImage beside = {};
};

/// C1 to C10. units: 1/m^2
std::vector<double> list_finite_clamps();

/// The cheapest plan foreseen to meet the target: level, VPLs, ratio and number of sets. Empty where paths
/// are cheaper, or where no VPL can be made. Small sets, seen at some points of the subject, tell how far
/// sets err: by their VPLs as 1 / VPLs, and by their representatives. Of the target the object's limits
/// count. `most_cost`: of path tracing. units: paths. errors: InputError for lack of memory
std::optional<SetPlan> plan_vpl_sets(const FamilyScene& scene, const SetPilot& pilot,
                                     const NoiseTarget& target, double most_cost, std::uint64_t seed,
                                     const std::string& stream_name);

/// The same by `scale` times the sets.
SetPlan take_more_sets(SetPlan plan, double scale, int positions);

}  // namespace equilux
