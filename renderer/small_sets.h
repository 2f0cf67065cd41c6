// Small VPL sets at some points of a subject, which tell how far larger ones err.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "renderer/set_candidates.h"

namespace equilux {

/// So many sets, at this ratio and at a coarser one, that tells how sizes and variances go with it.
inline constexpr std::size_t kSmallSets = 8;
inline constexpr double kSmallSetsRatio = 0.01, kCoarseRatio = 0.08;

/// VPLs of a small set, by the points that the camera sees of the subject.
double count_small_set_vpls(const SetTask& task);

/// Fills in the candidates' variances and cuts, of the hardest clamp from what the sets differ by, of the
/// others with what compensation's pilot foresees beyond it; gives the VPLs of a small set. errors: as
/// shade_lightcut
double trace_small_sets(const FamilyScene& scene, const SetTask& task, std::vector<SetCandidate>& candidates,
                        std::uint64_t seed, const std::string& stream_name);

}  // namespace equilux
