// Light of millions of VPLs at points of the object by cuts through a light tree, all clamp levels in one.
#pragma once

#include "base/random.h"
#include "renderer/cluster_bound.h"
#include "renderer/light_tree.h"
#include "renderer/shade.h"

namespace equilux {

/// A point's total by what is displayed of it, below which nobody sees what a cut lacks. units: steps of 255,
/// where they are darkest
inline constexpr double kFloorSteps = 0.25;

/// Shadow rays for a part of a cut's members only: a member whose light, if nothing stood between, were under
/// `share` of the point's total at every level and material takes its ray with a probability in proportion to
/// the nearest miss, and counts for as much more. Every expectation stays.
struct CutRoulette {
  double share = 0;    ///< 0: all rays are traced
  StreamKey key = {};  ///< of one random start a point, by its index, where its group has one place a point
};

struct LightcutParams {
  double error_ratio = 0.0075;  ///< a cluster's bound over the point's total, at every level and material
  double floor = 0;  ///< of that total: below it nothing could be seen. units: W/(m^2 sr), luminance
  /// Light of other VPLs, which counts in the totals; null: none. shape: as the result
  const ShadedPoints* base = nullptr;
  /// False: the totals of the rule are those of `base` alone, so that the cut does not depend on the
  /// representatives and the expectation over tree seeds is exactly the sum.
  bool adaptive = true;
  /// So many points that follow one another walk the tree together, whatever their pixels, at most sixteen;
  /// 0: those of one pixel. Where `adaptive` is false each has the cut that it has alone.
  std::size_t neighbours = 0;
  CutRoulette roulette = {};                  ///< with `base`, and where `adaptive` is false
  std::function<void(double)> progress = {};  ///< told points done, from any thread
  /// Told every shadow ray, packet by packet, from any thread. Of `valid` lanes alone.
  std::function<void(const PointPacket& from, const PointPacket& to, std::uint32_t valid)> watch_rays = {};
};

/// What cuts came to. Sizes count clusters and single VPLs.
struct CutRecord {
  std::vector<std::uint32_t> sizes;  ///< of each point's cut, members without a ray included
  std::uint64_t shadow_rays = 0;
};

/// Pixels in a run of cuts that hand on their totals, and the most materials of one call.
inline constexpr std::size_t kCutBlock = 32;
inline constexpr std::size_t kMostMaterials = 16;

/// As shade_all_vpls, to within what the ratio allows: in every cluster of the cut
///   bound(level, material) <= error_ratio x max(total(level, material), floor),
/// with the totals that the cut itself gives. No cut is too large. A cluster's light is its representative's,
/// scaled by the cluster's weight over the representative's: its expectation over tree seeds is the sum, but
/// for what totals that depend on the representatives do. Points of one pixel that follow one another, up to
/// sixteen, or so many neighbours as are asked for, walk the tree together, each with a cut of its own. The
/// materials share cuts, at most kMostMaterials: light of one then depends, within the rule, on what else was
/// asked for. A pixel's first thresholds come from the pixel before it in its run of kCutBlock. Roulette
/// leaves the cut as it is, and the sum of its light in expectation. source:
/// Walter et al., "Lightcuts: a scalable approach to illumination", SIGGRAPH 2005.
ShadedPoints shade_lightcut(const World& world, const std::vector<ShadingPoint>& points,
                            const LightTree& tree, const std::vector<Material>& materials,
                            const std::vector<double>& clamps_per_m2, const LightcutParams& params,
                            CutRecord* record = nullptr);

/// The same rule for all materials in one cut, one number at a time, all rays: the oracle.
ShadedPoints shade_lightcut_scalar(const World& world, const std::vector<ShadingPoint>& points,
                                   const LightTree& tree, const std::vector<Material>& materials,
                                   const std::vector<double>& clamps_per_m2, const LightcutParams& params,
                                   CutRecord* record = nullptr);

}  // namespace equilux
