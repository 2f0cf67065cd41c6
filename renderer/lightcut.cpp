#include "renderer/lightcut.h"

#include "renderer/kernels.h"

namespace equilux {

ShadedPoints shade_lightcut(const World& world, const std::vector<ShadingPoint>& points,
                            const LightTree& tree, const std::vector<Material>& materials,
                            const std::vector<double>& clamps_per_m2, const LightcutParams& params,
                            CutRecord* record) {
  const auto shade = current_isa() == Isa::kV4 ? &v4::shade_lightcut : &v3::shade_lightcut;
  return shade(world, points, tree, materials, clamps_per_m2, params, record);
}

}  // namespace equilux
