#include "renderer/cut_groups.h"

#include <algorithm>

namespace equilux {

std::vector<PointRange> group_points(const std::vector<ShadingPoint>& points, std::size_t most,
                                     std::size_t neighbours) {
  const std::size_t fill = neighbours > 0 ? std::min(neighbours, most) : most;
  std::vector<PointRange> groups;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto is_apart = [&](const PointRange& group) {
      return neighbours == 0 && points[i].pixel != points[group.first].pixel;
    };
    if (groups.empty() || groups.back().count == fill || is_apart(groups.back())) groups.push_back({i, 0});
    ++groups.back().count;
  }
  return groups;
}

std::vector<std::uint32_t> find_top(const LightTree& tree) {
  constexpr std::size_t kEnough = 256;
  std::vector<std::uint32_t> top{0};
  for (std::size_t before = 0; before < top.size() && top.size() < kEnough;) {
    before = top.size();
    std::vector<std::uint32_t> next;
    for (std::uint32_t index : top) {
      const LightNode& node = tree.nodes[index];
      next.push_back(node.leaf_count == 0 ? node.next : index);
      if (node.leaf_count == 0) next.push_back(node.next + 1);
    }
    top = std::move(next);
  }
  return top;
}

}  // namespace equilux
