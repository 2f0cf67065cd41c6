// What is told of light that was made of VPL sets.
#pragma once

#include "renderer/region_check.h"

namespace equilux {

struct SetMeasures {
  int clamp_level = 0;
  int sets = 0;
  double mean_vpls = 0;  ///< of a set
  double error_ratio = 0;
  double mean_clusters = 0;       ///< of a point's cut
  double compensation_paths = 0;  ///< of all pixels
  std::vector<RegionCheck> regions;
};

}  // namespace equilux
