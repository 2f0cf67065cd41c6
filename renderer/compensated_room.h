// The room's light to a noise target by VPL sets and compensation, checked against paths.
#pragma once

#include <optional>

#include "renderer/reference_params.h"
#include "renderer/room_stages.h"
#include "renderer/set_measures.h"
#include "renderer/set_plan.h"

namespace equilux {

/// How it is made at pixels that no object covers any of, the same beside every material of the object.
struct RoomPlan {
  SetPlan sets;
  double step = 0;               ///< of 255, where it is darkest. units: W/(m^2 sr), luminance
  PathMap direct, compensation;  ///< 0 at other pixels
};

/// The family's pilot, whose object is grey.
struct RoomPilot {
  const TracedLayers& layers;
  const PathMaps& maps;
  const PathMap& seen;     ///< of the background; 0 at pixels that were filled from near ones
  int reach = 0;           ///< within which. units: pixels
  const PathMap& planned;  ///< paths that the room takes by path tracing
};

/// Empty where path tracing is foreseen to cost less. What an object's gloss sends into the room is foreseen
/// by a glossy grey one. errors: as trace_layers and trace_vpl_sets
std::optional<RoomPlan> plan_compensated_room(const World& world, const Primary& primary,
                                              const RoomPilot& pilot, const ReferenceParams& params,
                                              const FamilyProgress& progress);

struct CompensatedRoom {
  TracedLayer layer;
  SetMeasures measures;
};

/// Unbiased, by material; each as by itself, bit for bit. What is made of it is kept in `stages`: direct
/// light, compensation, the check, the sets. errors: as plan_compensated_room
std::vector<CompensatedRoom> trace_compensated_rooms(const RoomScene& scene, const RoomPlan& plan,
                                                     const ReferenceParams& params,
                                                     const FamilyProgress& progress,
                                                     const RoomStages& stages = {});

/// Work of it, counted once for several materials. units: paths
double count_room_work(const Primary& primary, const RoomPlan& plan);

}  // namespace equilux
