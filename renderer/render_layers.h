// From the layers that are missing to EXR files, in the order in which worlds, views and VPL sets are shared.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "protocols/study.h"
#include "renderer/layer_store.h"
#include "renderer/wanted.h"
#include "stimuli/scene.h"

namespace equilux {

/// Layers to render. `levels` are conditions that are not normalised.
struct MissingLayers {
  std::vector<Family> families;
  std::vector<Condition> conditions;
  bool empty() const { return families.empty() && conditions.empty(); }
};

/// Renders them; each layer is recorded as soon as it is whole. Gives the seconds by stage.
std::map<std::string, double> render_layers(const Recipes& recipes, const Scene& scene,
                                            const MissingLayers& missing, LayerStore& store);

}  // namespace equilux
