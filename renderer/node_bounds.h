// Bounds of sixteen nodes at a time, as the fast lightcut has them: a door for those who hold them to the
// scalar ones.
#pragma once

#include <array>
#include <cstddef>

#include "renderer/cluster_bound.h"

namespace equilux {

inline constexpr std::size_t kNodeLanes = 16;

/// Of each node: the emission's bound, and that of M / r^2 without a clamp. Emission is 0 where the latter
/// is.
struct NodeBounds {
  std::array<float, kNodeLanes> emission{}, peak{};
};

/// As bound_emission, bound_material and bound_transfer of each node. shape: ids is count, at most kNodeLanes
NodeBounds bound_nodes(const LightTree& tree, const Material& material, const BoundPoint& point,
                       const std::uint32_t* ids, std::size_t count);

}  // namespace equilux
