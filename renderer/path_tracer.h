// Path tracing with next-event estimation: references, background and direct light of a family.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "base/random.h"
#include "protocols/study.h"
#include "renderer/primary.h"

namespace equilux {

/// Independent randomisations from which the standard error is taken.
inline constexpr int kBatches = 16;

/// A source of numbers in [0, 1): the first of a path from a lattice with a random shift, the rest from a
/// stream. Paths of one batch share the shift, so each batch is one randomisation of a quasi-Monte Carlo
/// rule.
class PathSampler {
 public:
  explicit PathSampler(const RandomStream& stream);
  /// Begins the next path of the batch.
  void next_path();
  float next();

 private:
  static constexpr std::size_t kDimensions = 9;
  RandomStream stream_;
  std::array<double, kDimensions> point_{};
  std::size_t dimension_ = 0;
};

/// Radiance reflected at `point` towards v after being emitted directly at it: all lights, no further bounce.
Vec3 estimate_direct(const World& world, const Materials& materials, const SurfacePoint& point, Vec3 v,
                     PathSampler& sampler);

/// Radiance reflected at `point` towards v; without `with_direct` only what comes by way of other surfaces.
Vec3 estimate_reflected(const World& world, const Materials& materials, const SurfacePoint& point, Vec3 v,
                        bool with_direct, PathSampler& sampler);

/// Layers of one family, premultiplied by coverage: they add up. standard_error is that of their sum.
struct FamilyLayers {
  HdrImage background, direct, indirect, standard_error;
};

/// Paths that a count of a study comes to: rounded up to a multiple of kBatches x positions.
int round_paths(int paths, int positions);

/// `progress` is told the paths done, from any thread.
/// errors: InputError naming the stream if any radiance is not finite, with their number.
FamilyLayers trace_family(const World& world, const Materials& materials, const Primary& primary,
                          const PathCounts& paths, std::uint64_t seed, const std::string& stream_name,
                          const std::function<void(double)>& progress);

/// Work that trace_family will report. units: paths
double count_family_paths(const Primary& primary, const PathCounts& paths);

}  // namespace equilux
