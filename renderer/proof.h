// The renderer's main proof: the unclamped VPL sum and the path tracer have the same expectation.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "protocols/study.h"
#include "stimuli/scene.h"

namespace equilux {

/// Sixteen points of the object make a group, kProofGroups groups the whole. A VPL set is summed at the
/// points of one group; that of its VPLs which the object had a part in, few and of wide spread, at every
/// group.
inline constexpr int kProofGroups = 64;
inline constexpr int kProofPoints = 16 * kProofGroups;

struct ProofParams {
  Object object;
  int view = 0;
  int repeats = 4;                ///< independent VPL sets for each group
  std::int64_t vpl_paths = 4000;  ///< particles of each set
  int camera_paths = 1000;        ///< at each point
  /// Left out: points lower than this share of the object's height above the stand. Where two surfaces touch
  /// the variance of the unclamped sum diverges.
  double contact_band = 0.3;
  std::uint64_t seed = 1;
  bool with_lambertian = false;  ///< measure the gap of Lambertian emission too, on the same particles
};

/// Mean luminance over the points, and its standard error: for VPLs from the spread of the sets of each
/// group, for paths from kBatches randomisations. units: W/(m^2 sr)
struct ProofEstimate {
  double mean = 0;
  double standard_error = 0;
};

struct Proof {
  ProofEstimate paths, full, lambertian;
};

/// Relative difference of a VPL estimate from the paths', with its standard error.
ProofEstimate find_relative_difference(const ProofEstimate& vpls, const ProofEstimate& paths);

/// errors: InputError for what the scene lacks, or where the camera sees no point outside the contact band.
Proof make_proof(const Scene& scene, const MaterialSpec& material, const ProofParams& params);

}  // namespace equilux
