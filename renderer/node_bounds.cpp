#include "renderer/node_bounds.h"

#include "renderer/kernels.h"

namespace equilux {

NodeBounds bound_nodes(const LightTree& tree, const Material& material, const BoundPoint& point,
                       const std::uint32_t* ids, std::size_t count) {
  const auto bound = current_isa() == Isa::kV4 ? &v4::bound_nodes : &v3::bound_nodes;
  return bound(tree, material, point, ids, count);
}

}  // namespace equilux
