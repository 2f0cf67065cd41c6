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

/// What trace_compensation sees of its layers beside their light.
struct CompensationRecord {
  /// The share of a layer's paths that went on beyond their first ray: what they cost goes by it.
  std::vector<double> walked;
  /// What those Lambertian VPLs that the hardest clamp acts on add to the variance of a VPL sum clamped as
  /// the layer is, over their intensity (sum of squares over sum), if they come independently of each other.
  /// shape: as the layer. units: 1/m^2 W/(m^2 sr)
  std::vector<HdrImage> variances;
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
