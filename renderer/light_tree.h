// A binary tree over VPLs: each node bounds the VPLs below it and names one that stands for them all.
#pragma once

#include <cstdint>
#include <vector>

#include "renderer/vpl.h"

namespace equilux {

/// Bounds of a set of VPLs. Every VPL lies in the box and its ng in the cone about `axis`; those with a glossy
/// part mirror within the cone about `mirror`.
struct Cluster {
  Vec3 low, high;              ///< units: m
  Vec3 axis;                   ///< unit
  float cos_angle = 1;         ///< of the cone's half angle; -1: all directions
  float luminance = 0;         ///< sum of the VPLs' diffuse intensities. units: W/sr
  float gloss_luminance = 0;   ///< sum of their peaks by the glossy part, luminance. units: W/sr
  float gloss_alpha = 0;       ///< the largest
  Vec3 mirror;                 ///< unit
  float mirror_cos_angle = 1;  ///< -1: all directions
  std::uint32_t representative = 0;  ///< index in LightTree::vpls
  float share = 1;  ///< probability with which the representative was drawn: its light stands for 1 / share
};

/// A node's children are `left` and `right`; a leaf has left == right == kNoChild and one VPL.
inline constexpr std::uint32_t kNoChild = ~0u;
struct LightNode {
  Cluster cluster;
  std::uint32_t left = kNoChild, right = kNoChild;
  bool is_leaf() const { return left == kNoChild; }
};

struct LightTree {
  VplList vpls;  ///< in the order of the tree
  std::vector<LightNode> nodes;
  std::uint32_t root = 0;
  bool empty() const { return nodes.empty(); }
};

}  // namespace equilux
