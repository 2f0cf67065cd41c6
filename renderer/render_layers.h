// From the layers that are missing to EXR files, in the order in which worlds, views and VPL sets are shared.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "protocols/study.h"
#include "renderer/layer_store.h"
#include "renderer/timing.h"
#include "renderer/wanted.h"
#include "stimuli/scene.h"

namespace equilux {

/// Of a set or share: what is wanted of it, and what of that is whole.
struct WorkCounts {
  std::size_t all_references = 0, all_layers = 0;  ///< layers: of VPL pictures
  std::size_t references = 0, layers = 0;
};

/// Renders what is missing, whose conditions are not normalised; each layer is recorded as soon as it is
/// whole, and each product is logged. `counts`, before it begins, are what progress goes on from. Adds to the
/// seconds by stage, and gives the work as it was foreseen. units: paths; errors: WorkCancelled
double render_layers(const Recipes& recipes, const Scene& scene, const Wanted& missing, WorkCounts counts,
                     LayerStore& store, WorkLog& log, std::map<std::string, double>& seconds);

}  // namespace equilux
