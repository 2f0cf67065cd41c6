// The room's indirect light as the mean of independent VPL sets, beside objects of several materials.
#pragma once

#include "renderer/family.h"
#include "renderer/set_sums.h"

namespace equilux {

struct RoomSetsParams {
  int sets = 8;            ///< see count_vpl_sets
  std::int64_t paths = 1;  ///< particles of a set, see find_path_count
  double clamp_per_m2 = 0;
  double error_ratio = 0.01;  ///< of cuts
  double floor = 0;           ///< of their totals. units: W/(m^2 sr), luminance
  std::uint64_t seed = 1;
  std::string stream_name;
  /// Radiance by which the rule of the cuts goes, from anything but the sets. shape: height x width x 3
  const HdrImage& totals;
  const std::vector<int>& regions;  ///< of each pixel, or -1; empty: none
};

/// Beside an object of one material.
struct RoomSets {
  TracedLayer layer;  ///< the standard error is from the spread of a position's sets
  int sets = 0;
  double mean_vpls = 0;      ///< of a set
  double mean_clusters = 0;  ///< of a point's cuts
  std::vector<RegionLight> regions;
};

/// Of pixels that no object covers any of. As trace_vpl_sets with fixed totals, but that VPLs whose paths
/// never met the object have a tree and cuts for all materials: beside each it is as by itself, bit for bit.
/// VPLs emit by the diffuse part. With trace_room_compensation the sum is the room's path-traced light but
/// for trace_room_direct. `progress` is told each set done. shape: by material. errors: as trace_vpl_sets
std::vector<RoomSets> trace_room_sets(const RoomScene& scene, const RoomSetsParams& params,
                                      const std::function<void()>& progress);

}  // namespace equilux
