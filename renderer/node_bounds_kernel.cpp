// The fast code's bounds by themselves, so that tests can hold them to the scalar ones.
#include "renderer/kernels.h"
#include "renderer/lane_bounds.h"

// After all other headers.
// clang-format off
#include "renderer/isa_begin.h"
// clang-format on

namespace equilux::EQ_ISA {

NodeBounds bound_nodes(const LightTree& tree, const Material& material, const BoundPoint& point,
                       const std::uint32_t* ids, std::size_t count) {
  const LanePoint lanes = load_points(std::vector<BoundPoint>(kLanes, point));
  const LaneBound bound = bound_lanes(load_nodes(tree, ids, count), lanes, material.glossy_share > 0);
  const Floats lobe =
      material.glossy_share > 0 ? bound_lobe({material.model, material.alpha}, lanes, bound) : zeros();
  const auto peaks = to_array(bound_peak(material, bound, lobe)), emissions = to_array(bound.emission);
  NodeBounds bounds;
  for (std::size_t lane = 0; lane < count; ++lane) {
    bounds.peak[lane] = peaks[lane];
    if (!(peaks[lane] > 0)) continue;
    bounds.emission[lane] = emissions[lane];
    if (tree.gloss.empty()) continue;
    const Cluster cluster = unpack_cluster(tree, tree.nodes[ids[lane]]);
    bounds.emission[lane] = bound_emission(point.p, cluster, &tree.gloss[ids[lane]]);
  }
  return bounds;
}

}  // namespace equilux::EQ_ISA

#include "renderer/isa_end.h"
