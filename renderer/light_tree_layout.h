// Where the nodes and VPLs of a light tree lie in memory. Cuts go through the large nodes of a tree of
// millions, so nodes and the VPLs that stand for them come by size: what cuts meet lies together.
#pragma once

#include "renderer/light_tree.h"

namespace equilux {

/// A subtree as it is built: depth first, the left child behind its parent, the right one at `next`.
struct TreeDraft {
  LargeArray<LightNode> nodes;
  LargeArray<std::uint32_t> counts;  ///< of VPLs below each node
  std::vector<GlossCluster> gloss;   ///< beside nodes; empty if no VPL is glossy
};

/// Classes of nodes by how many VPLs are below them: at least 4096, 512, 64, 8, fewer.
inline constexpr std::size_t kSizeClasses = 5;

/// Numbers by size class: pairs of children by their parent's, VPLs by that of the largest node they stand
/// for. `root_class`: of the largest node that the root's representative stands for.
struct DraftSizes {
  std::array<std::uint32_t, kSizeClasses> pairs{}, vpls{};
};
DraftSizes measure_draft(const TreeDraft& draft, std::size_t root_class);

/// Of a node with so many VPLs below it.
std::size_t find_size_class(std::uint32_t count);

/// Moves a draft into its tree: the root to `root`, pairs of children to nodes[starts.pairs] and on, VPLs
/// from `sorted` to tree.vpls.vpls[starts.vpls] and on. Gives where the root's representative has gone.
std::uint32_t place_draft(const TreeDraft& draft, const LargeArray<Vpl>& sorted, std::uint32_t root,
                          std::size_t root_class, DraftSizes starts, LightTree& tree);

}  // namespace equilux
