// Light of the objects as the mean of independent VPL sets: unbiased, with an error of its own.
#pragma once

#include "renderer/family.h"
#include "renderer/lightcut.h"
#include "renderer/set_sums.h"

namespace equilux {

/// Points of a set that walk its tree together: one ray a pixel, so that neighbours' run side by side.
inline constexpr std::size_t kNeighbours = 16;

/// Roulette's share of a set's cut over the cut's own ratio: of 0 to 1.2 what costs least to equal error in
/// the café.
inline constexpr double kRouletteOfRatio = 0.4;

struct VplSetsParams {
  int sets = 4;                       ///< at least 2
  std::int64_t paths = 1;             ///< particles of a set, see find_path_count
  std::vector<double> clamps_per_m2;  ///< of each object
  double error_ratio = 0.0025;        ///< of cuts
  double roulette_of_ratio = kRouletteOfRatio;
  double floor = 0;  ///< of their totals. units: W/(m^2 sr), luminance
  Emission emission = Emission::kLambertian;
  std::uint64_t seed = 1;
  std::string stream_name;
  /// Of each object, radiance by which the rule of its cuts goes, from anything but the sets; empty: a
  /// pilot's. units: W/(m^2 sr), not premultiplied
  std::vector<HdrImage> totals = {};
  /// Region of each pixel, or -1; empty: none.
  std::vector<int> regions = {};
};

/// The rule of a set's cuts. `stream_name`: of this tree's starts of the roulette
LightcutParams make_set_rule(double error_ratio, double floor, const ShadedPoints& totals, std::uint64_t seed,
                             const std::string& stream_name, double roulette_of_ratio = kRouletteOfRatio);

struct VplSets {
  int sets = 0;
  std::vector<TracedLayer>
      layers;                ///< of each object; the standard error is from the spread of a position's sets
  double mean_vpls = 0;      ///< of a set
  double mean_clusters = 0;  ///< of a point's cut
  std::uint64_t shadow_rays = 0;  ///< with the pilot's
  /// Of all objects together; the errors are from the spread of whole sets, whose pixels err alike.
  std::vector<RegionLight> regions = {};
};

/// So many sets or more: a multiple of the subpixel positions, and at least two of each, from whose
/// difference the error is known.
int count_vpl_sets(int sets, int positions);

/// What the camera sees through one subpixel position alone.
Primary take_position(const Primary& primary, int position);

/// Each set is seen through one subpixel position, all positions equally often: neighbouring samples of a set
/// err alike. The rule of the sets' cuts takes its totals from elsewhere, or from a pilot, one set more that
/// is then thrown away: no cut depends on its own representatives, so the expectation is exactly the VPL
/// sum's, clamped. With trace_compensation the sum is the path-traced layer. `progress` is told a pilot and
/// each set done. errors: InputError for lack of memory or radiance that leaves the range of float
VplSets trace_vpl_sets(const FamilyScene& scene, const VplSetsParams& params,
                       const std::function<void()>& progress);

}  // namespace equilux
