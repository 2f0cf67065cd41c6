// Upper bounds of the light that a cluster of VPLs may send to the eye by a point of the object. Each is
// sound against what shade_all_vpls computes for any of its VPLs, rounding included.
#pragma once

#include "renderer/light_tree.h"
#include "renderer/material.h"
#include "renderer/shade.h"

namespace equilux {

/// By how much bounds are rounded outwards.
struct BoundSlack {
  static constexpr float kRotation =
      1e-6f;  ///< of the vectors that are rotated: what a dot product of floats loses
  static constexpr float kTangent =
      1e-6f;  ///< what directions that are normalised in float lose of a tangent
  static constexpr float kRelative =
      1e-4f;  ///< what sums and products of a bound, and of what it bounds, lose
};

/// What bounds need of a shading point, made once for all clusters.
struct BoundPoint {
  Vec3 p;
  Frame shading;  ///< about ns
  Frame mirror;   ///< about v's mirror direction
  Vec3 v;         ///< towards the camera, in the shading frame
};
BoundPoint make_bound_point(const ShadingPoint& point);

/// How a point sees a box.
struct BoxSight {
  float least_r2 = 0;    ///< squared distance to the box. units: m^2
  float most_cos = 1;    ///< largest n.l, at most 1; 0 if none is above the horizon
  float least_tan2 = 0;  ///< of the half vector's angle
};
BoxSight sight_box(const BoundPoint& point, Vec3 low, Vec3 high);

/// Largest M = f cl of any channel. units: 1/sr
float bound_material(const Material& material, const BoundPoint& point, const BoxSight& sight);

/// Largest cosine at a VPL of the cluster towards the point, at most 1, 0 if all face away.
float bound_vpl_cosine(Vec3 p, const Cluster& cluster);

/// Largest luminance of the sum of the cluster's emissions towards the point, with the cosine at the VPLs.
/// `gloss` null: none is glossy. Infinite where a glossy VPL may be seen at its horizon. units: W/sr
float bound_emission(Vec3 p, const Cluster& cluster, const GlossCluster* gloss);

/// min{clamp, M / r^2}, the largest. Infinite only where the clamp is and the point lies in the box.
float bound_transfer(float most_m, float least_r2, float clamp_per_m2);

}  // namespace equilux
