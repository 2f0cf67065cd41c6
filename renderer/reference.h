// References: the path-traced layers of a family, with as many paths as their noise target asks for.
#pragma once

#include <optional>

#include "renderer/allot.h"

namespace equilux {

/// Layers of one family, premultiplied by coverage: they add up. standard_error is that of their sum.
struct FamilyLayers {
  HdrImage background, direct, indirect, standard_error;
  double paths = 0;  ///< traced for them, without the pilot's
};

struct ReferenceParams {
  std::optional<PathCounts> fixed;  ///< the same at every pixel; else by a pilot for the target
  NoiseTarget target;
  Exposure exposure = Exposure::kBackground;
  double tone_key = 0.18;
  std::uint64_t seed = 1;
  std::string stream_name;  ///< the pilot's has another: it is thrown away
  PathMeasures measures;
};

/// How a study's references are traced.
ReferenceParams make_reference_params(const Study& study, const std::string& stream_name);

/// Work that trace_family is likely to report; exact where the counts are fixed. units: paths
double estimate_family_paths(const ReferenceParams& params, const Primary& primary);

/// Called from any thread: paths done, and a correction of the work foreseen.
struct FamilyProgress {
  std::function<void(double)> advance;
  std::function<void(double)> expect_more;
};

/// The paths of each pixel: fixed, or by pilots for the target. errors: as trace_layers
PathMaps allot_family(const FamilyScene& scene, const ReferenceParams& params,
                      const FamilyProgress& progress);

/// errors: as trace_layers
FamilyLayers trace_family(const FamilyScene& scene, const ReferenceParams& params,
                          const FamilyProgress& progress);

}  // namespace equilux
