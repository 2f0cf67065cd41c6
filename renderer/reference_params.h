// What a reference is asked for.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "renderer/family.h"

namespace equilux {

struct ReferenceParams {
  ReferenceMethod method = ReferenceMethod::kPath;
  std::optional<PathCounts> fixed;  ///< the same at every pixel; else by a pilot for the target
  NoiseTarget target;
  ToneMapping tone;
  double gloss = 0.12;  ///< luminance of the object's rho_s: only foresees what sets cost
  std::uint64_t seed = 1;
  std::string stream_name;             ///< the pilot's has another: it is thrown away
  std::string background_stream_name;  ///< the same for every material of the object
  PathMeasures measures;
};

/// Called from any thread: paths done, and a correction of the work foreseen.
struct FamilyProgress {
  std::function<void(double)> advance;
  std::function<void(double)> expect_more;
};

}  // namespace equilux
