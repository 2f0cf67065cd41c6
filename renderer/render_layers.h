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

/// Renders what is missing, whose conditions are not normalised; each layer is recorded as soon as it is
/// whole, and each product is logged. Adds to the seconds by stage, and gives the work as it was foreseen.
/// units: paths; errors: WorkCancelled
double render_layers(const Recipes& recipes, const Scene& scene, const Wanted& missing, LayerStore& store,
                     WorkLog& log, std::map<std::string, double>& seconds);

}  // namespace equilux
