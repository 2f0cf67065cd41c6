// Small VPL sets at some points of a subject, which tell how far larger ones err.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/set_candidates.h"

namespace equilux {

/// So many sets, at this ratio.
inline constexpr std::size_t kSmallSets = 8;
inline constexpr double kSmallSetsRatio = 0.01;

/// What they show beside the candidates' variances.
struct SmallSets {
  double vpls = 0;      ///< of a set
  double cut_size = 0;  ///< mean. units: clusters
};

/// VPLs of a small set, by the points that the camera sees of the subject.
double count_small_set_vpls(const SetTask& task);

/// Fills in the candidates' variances. errors: as shade_lightcut
SmallSets trace_small_sets(const FamilyScene& scene, const SetTask& task,
                           std::vector<SetCandidate>& candidates, std::uint64_t seed,
                           const std::string& stream_name);

}  // namespace equilux
