// How a light tree splits. Large clusters decide how long cuts are, so their splits are searched for; small
// ones, which are most, follow a Morton curve.
#pragma once

#include "renderer/light_tree.h"

namespace equilux {

/// A cluster of VPLs: all of one range of the Morton order, or the two that it splits into.
struct PlanNode {
  std::uint32_t first = 0, last = 0;  ///< the range, where there are no children
  std::uint32_t count = 0;            ///< of VPLs
  std::uint32_t left = 0, right = 0;  ///< indices in the plan; 0: none

  bool is_range() const { return left == 0; }
};

/// Where a range of the Morton order splits: where the highest bit in which its keys differ changes; in its
/// middle where none does.
std::uint32_t split_range(const LargeArray<std::uint64_t>& keys, std::uint32_t first, std::uint32_t last);

/// Ranges of at most count / 65536 VPLs, or of `least`, joined from above: a cluster splits between the bins
/// of position or normal that make the sum over both sides of weight x extent least, extent being the box'
/// diagonal and a twentieth of the room's times the spread of normals. Children come behind their parents.
/// `sorted`: the VPLs in the order of their keys. size: the room's. units: m
std::vector<PlanNode> plan_tree(const VplList& sorted, const LargeArray<std::uint64_t>& keys,
                                std::uint32_t least, float size);

}  // namespace equilux
