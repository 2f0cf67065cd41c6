// A binary tree over VPLs: each node bounds the VPLs below it, and names one of them that stands for all.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "renderer/vpl.h"

namespace equilux {

/// Bounds of a set of VPLs: each lies in the box, and its ng in the cone.
struct Cluster {
  Vec3 low, high;       ///< units: m
  Vec3 axis;            ///< unit
  float cos_angle = 1;  ///< of the cone's half angle; -1 holds all directions
  float weight = 0;     ///< sum of the VPLs' weights. units: W/sr
};

/// Bounds of the glossy emission of a set of VPLs: each mirrors wi about its ns within one cone, and has its
/// ns in the other. `peak` sums luminance(flux) K, with emission x cosine at most flux K E cos / (ns.wo), see
/// bound_gloss.
struct GlossCluster {
  Vec3 mirror;
  float mirror_angle =
      0;  ///< half the cone's; an angle, since a cosine in float is coarse near one. units: radians
  Vec3 ns;
  float ns_angle = 0;
  float peak = 0;   ///< 0: none glossy
  float alpha = 0;  ///< the largest
};

/// A node in 32 bytes. Bounds are rounded outwards on a grid over the root's box. The children of an inner
/// node lie side by side, first the one with its representative; a leaf holds VPLs one after another.
struct LightNode {
  std::array<std::uint16_t, 3> low, high;
  Octahedral axis;
  std::int16_t cos_angle;    ///< in 1 / 32767, rounded down so far that the axis' rounding is within
  std::uint16_t leaf_count;  ///< of VPLs; 0: an inner node
  float weight;
  std::uint32_t representative;  ///< index among the VPLs; drawn in proportion to their weights
  std::uint32_t next;            ///< index of the first child, or of a leaf's first VPL
};
static_assert(sizeof(LightNode) == 32);

struct LightTree {
  VplList vpls;  ///< in the tree's own order
  /// The root, a place that is not used, pairs of children by size; empty without VPLs. See
  /// light_tree_layout.h.
  LargeArray<LightNode> nodes;
  std::vector<GlossCluster> gloss;  ///< beside nodes; empty if no VPL is glossy
  Vec3 origin, step;                ///< of the grid of boxes. units: m

  bool empty() const { return nodes.empty(); }
};

struct LightTreeParams {
  std::uint64_t seed = 1;  ///< of the representatives
  int leaf_size = 1;       ///< most VPLs in a leaf
};

/// What a VPL's luminance counts as in drawing representatives: above zero for each that emits.
float weigh_vpl(const VplList& list, std::size_t index);

/// Deterministic on any number of threads. VPLs are sorted along a Morton curve whose fourth level is
/// followed by the octant of ng; nodes split where keys differ first.
LightTree make_light_tree(VplList vpls, const LightTreeParams& params);

Cluster unpack_cluster(const LightTree& tree, const LightNode& node);

}  // namespace equilux
