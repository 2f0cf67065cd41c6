// The renderer's main proof: the unclamped VPL sum and the path tracer have the same expectation.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "protocols/study.h"
#include "stimuli/scene.h"

namespace equilux {

/// Points of the object, at most: each VPL set is summed at every kProofStride-th of them, turn by turn; of
/// the VPLs that the object had a part in, few and of wide spread, other sets are made, each summed at all.
inline constexpr int kProofPoints = 8192;
inline constexpr int kProofStride = 16;

struct ProofParams {
  std::string geometry = "G0";
  Illumination illumination = Illumination::kIndirect;
  int view = 0;
  int sets = 256;  ///< independent VPL sets, for all materials together
  /// Sets of which only VPLs that the object had a part in are summed, for a material whose lobe is as high
  /// and narrow as that of MS, rho_s / alpha = 4.4; for others a part in proportion, at least 32.
  int own_sets = 256;
  std::int64_t vpl_paths = 4000;  ///< particles of each set
  int camera_paths = 256;         ///< at each point
  /// Left out: points lower than this share of the object's height above the stand. Where two surfaces touch
  /// the variance of the unclamped sum diverges.
  double contact_band = 0.3;
  std::uint64_t seed = 1;
  bool with_gap = true;  ///< else only what full emission takes is summed
};

/// Mean luminance over the points, and its standard error: for VPLs from the spread of the sets, for paths
/// from kBatches randomisations. units: W/(m^2 sr)
struct ProofEstimate {
  double mean = 0;
  double standard_error = 0;
};

struct Proof {
  ProofEstimate paths;  ///< the path tracer's
  ProofEstimate full;   ///< of unclamped VPLs with full emission
  ProofEstimate gap;    ///< what Lambertian emission of the same VPLs falls short of that by
};

/// Relative difference of a VPL estimate from the paths', which met light, with its standard error.
ProofEstimate find_relative_difference(const ProofEstimate& vpls, const ProofEstimate& paths);

/// One for each material of the object. Their errors have the sets in common. errors: InputError for what the
/// scene lacks, or where the camera sees no point outside the contact band.
std::vector<Proof> make_proofs(const Scene& scene, const std::vector<MaterialSpec>& materials,
                               const ProofParams& params);

}  // namespace equilux
