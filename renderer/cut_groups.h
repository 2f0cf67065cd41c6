// Which points walk the light tree together, and where cuts start: the same for every instruction set.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "renderer/light_tree.h"
#include "renderer/shade.h"

namespace equilux {

/// Points that walk together.
struct PointRange {
  std::size_t first = 0, count = 0;
};

/// Samples of a pixel that follow one another, at most `most` in a range; or so many neighbours, if not 0.
std::vector<PointRange> group_points(const std::vector<ShadingPoint>& points, std::size_t most,
                                     std::size_t neighbours);

/// Clusters that hold all VPLs: the tree's first level of at least 256, leaves above it included, or all
/// leaves. Cuts that start higher err by too much where few clusters hold all light.
std::vector<std::uint32_t> find_top(const LightTree& tree);

}  // namespace equilux
