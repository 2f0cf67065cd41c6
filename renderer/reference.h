// References: the unbiased layers of a family, with as many paths, or VPL sets, as their noise target asks
// for.
#pragma once

#include <optional>

#include "renderer/compensated.h"
#include "renderer/compensated_room.h"

namespace equilux {

/// A rendering that was added to others, since these missed the target.
struct AddedTurn {
  double share = 0;  ///< of the whole when it was added
  double paths = 0;
  std::optional<SetMeasures> sets = {};
};

/// Layers of one family, premultiplied by coverage: they add up. standard_error is that of their sum.
struct FamilyLayers {
  HdrImage background, direct, indirect, standard_error;
  double paths = 0;  ///< traced for them, without the pilots'; of trace_object for the object alone
  std::optional<SetMeasures> sets = {};  ///< of indirect light by VPL sets and compensation, first turn; its
                                         ///< regions of all turns that were made so
  std::optional<SetMeasures> room = {};  ///< the same of the room
  int room_turns = 1;                    ///< of the room alone: all but the last were thrown away
  std::vector<AddedTurn> added = {};     ///< to the object's first turn
};

/// Of the room's random numbers, the same for every material of the object.
std::string name_background_stream(const Family& family);

/// How a study's references are traced. The stream names are the family's.
ReferenceParams make_reference_params(const Study& study, const Scene& scene, const Family& family);

/// Work that the room and an object of one material are likely to report; exact where the counts are fixed.
/// `pixels`: for which each of the primary's stands. units: paths
double estimate_background_paths(const ReferenceParams& params, const Primary& primary, double pixels = 1);
double estimate_object_paths(const ReferenceParams& params, const Primary& primary, double pixels = 1);

/// The room of one geometry, illumination and view. It is made alike whatever the object is made of: its
/// pilot sees a grey one.
struct BackgroundPlan {
  PathMap map;                           ///< of path tracing; with `by_sets` of silhouettes alone
  std::optional<RoomPlan> by_sets = {};  ///< of all else
  PathMap pilot_map = {};
  TracedLayer pilot = {};  ///< empty where the counts are fixed
};

/// errors: as trace_layers
BackgroundPlan plan_background(const World& world, const Primary& primary, const ReferenceParams& params,
                               const FamilyProgress& progress, const RoomStages& stages = {});

/// Beside an object of one material.
struct Background {
  TracedLayer layer;
  std::optional<SetMeasures> sets = {};
};

/// The room beside the object in several materials: paths in eight parts where `stages` are kept, and what
/// trace_compensated_rooms keeps. The same bits whatever of it is kept. errors: as trace_layers
std::vector<Background> trace_planned_backgrounds(const RoomScene& scene, const BackgroundPlan& plan,
                                                  const ReferenceParams& params,
                                                  const FamilyProgress& progress,
                                                  const RoomStages& stages = {});

/// The paths of the object's pixels, fixed or by pilots for the target; none of the room. errors: as
/// trace_layers
PathMaps allot_object(const FamilyScene& scene, const BackgroundPlan& plan, const ReferenceParams& params,
                      const FamilyProgress& progress);

/// The object's layers, joined with the room's. Where the object's error misses the target an independent
/// rendering of it is added, with the weight that their expected errors give it; a room that misses is made
/// again. A few times; what comes of it is unbiased but for that choice. errors: as trace_layers
FamilyLayers trace_object(const FamilyScene& scene, const BackgroundPlan& plan, const Background& background,
                          const ReferenceParams& params, const FamilyProgress& progress);

/// All of it for one material. errors: as trace_layers
FamilyLayers trace_family(const FamilyScene& scene, const ReferenceParams& params,
                          const FamilyProgress& progress);

}  // namespace equilux
