// Light of regions of a picture, by VPL sets and by paths that know nothing of VPLs.
#pragma once

#include <string>
#include <vector>

#include "renderer/set_sums.h"

namespace equilux {

/// An error of a region's mean below this is not believed: the few paths that met nothing bright would tell
/// none at all, and what differs by so little is not seen. units: steps of 255, where they are darkest
inline constexpr double kLeastSteps = 0.01;

/// Light of one region, at the pixels that the paths saw: of the reference and of those paths.
struct RegionCheck {
  std::string name;  ///< r1c1 to r3c3 of a box in the picture, silhouettes
  RegionLight light, traced;
  double least_error = 0;  ///< of their difference. units: W/(m^2 sr), luminance

  /// Their difference over its standard error. Paths that met the light n times by their own error,
  /// (mean / error)^2, know it no better than to 1 over the root of 1 + n: those that met none, or once a
  /// little of it, tell next to no error and know nothing.
  double z() const;
};

/// Of each pixel that was seen its region: a cell of a grid over the box of the pixels with a share, or the
/// silhouettes, which have a part of it; else -1. shape of both: height x width
std::vector<int> find_regions(const HdrImage& share, const PathMap& seen);

/// `sets`: by region, of whole sets; `beside`: what adds to them; `traced`: both by paths. Pixels of the last
/// two err independently. `step`: of 255, where it is darkest. units: W/(m^2 sr), luminance
std::vector<RegionCheck> check_regions(std::vector<RegionLight> sets, const TracedLayer& beside,
                                       const TracedLayer& traced, const std::vector<int>& regions,
                                       double step);

}  // namespace equilux
