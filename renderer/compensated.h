// An object's light to a noise target by VPL sets and compensation, checked against its pilot's paths.
#pragma once

#include <optional>

#include "renderer/allot.h"
#include "renderer/reference_params.h"
#include "renderer/set_measures.h"
#include "renderer/vpl_sets.h"

namespace equilux {

/// Of a family, the object at some of its pixels.
struct ObjectPilot {
  TracedLayers layers;  ///< filled between those pixels, see fill_between
  PathMaps maps;        ///< as if all had been seen
  PathMap seen;         ///< of the object's light; 0 at the pixels between
  int reach = 0;        ///< within which those between are filled. units: pixels
};

struct CompensatedObject {
  TracedLayer direct, indirect;
  double paths = 0;
  SetMeasures measures;
};

/// Of a scene with one object. Empty where path tracing is foreseen to cost less. The layers are unbiased:
/// what is chosen by pilots is independent of what is then rendered, no cut depends on its own
/// representatives, and paths whose number goes by what the sets err by have random numbers of their own.
/// VPLs emit by the diffuse part. errors: as trace_layers and trace_vpl_sets
std::optional<CompensatedObject> trace_compensated(const FamilyScene& scene, const ObjectPilot& pilot,
                                                   const ReferenceParams& params,
                                                   const FamilyProgress& progress);

}  // namespace equilux
