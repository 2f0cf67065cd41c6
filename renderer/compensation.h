// What a clamp takes from VPL light, given back by paths.
#pragma once

#include "renderer/family.h"

namespace equilux {

/// Whether VPLs of the scene lack light at any distance: gloss that Lambertian ones do not send on.
bool lacks_gloss(Emission emission, const Materials& materials);

struct CompensationParams {
  std::vector<double> clamps_per_m2;          ///< infinite for none
  Emission emission = Emission::kLambertian;  ///< of the VPLs
  std::uint64_t seed = 1;
  std::string stream_name;
  PathMeasures measures;
  bool clamped_alone = false;  ///< without what the emission lacks
};

/// Of each layer, the share of its paths that went on beyond their first ray: what they cost goes by it.
struct CompensationRecord {
  std::vector<double> walked;
};

/// Of the objects' light, a layer for each clamp, all from the same paths: added to the VPL layer of that
/// clamp and emission, its expectation is the path-traced indirect layer. `map`: paths in each batch and at
/// each position. `progress` is told the paths done, from any thread. errors: as trace_layers
std::vector<TracedLayer> trace_compensation(const FamilyScene& scene, const PathMap& map,
                                            const CompensationParams& params,
                                            const std::function<void(double)>& progress,
                                            CompensationRecord* record = nullptr);

/// The same of the room's light, beside objects of several materials, each as by itself. shape: material x
/// clamp
std::vector<TracedLayer> trace_room_compensation(const RoomScene& scene, const PathMap& map,
                                                 const CompensationParams& params,
                                                 const std::function<void(double)>& progress,
                                                 CompensationRecord* record = nullptr);

}  // namespace equilux
