// Virtual point lights by particle tracing.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/large_array.h"
#include "protocols/study.h"
#include "renderer/octahedral.h"
#include "renderer/world.h"

namespace equilux {

/// A virtual point light in 32 bytes: millions are read at random. Its radiance towards x is intensity cos /
/// r^2 by the diffuse part of its surface; with full emission a glossy part comes on top.
struct Vpl {
  Vec3 p;
  Octahedral normal{};
  Vec3 intensity;  ///< W/sr along ng
  /// Low kGlossBits: one more than the glossy part's index; above them the exponent of epsilon over
  /// kLeastExponent.
  std::uint32_t packed = 0;

  static constexpr int kGlossBits = 25, kLeastExponent = -101;
  static constexpr std::uint32_t kMostGloss = (1u << kGlossBits) - 1;

  Vpl() = default;
  Vpl(Vec3 place, float epsilon, Vec3 ng, Vec3 power);

  /// Unit, on the side from which the particle came.
  Vec3 ng() const { return decode_octahedral(normal); }
  /// As SurfacePoint::epsilon, or the power of two above it.
  float epsilon() const;
  /// Index of the glossy part, or -1.
  std::int32_t gloss() const { return static_cast<std::int32_t>(packed & kMostGloss) - 1; }
  void set_gloss(std::int32_t index);

  /// Where shadow rays end.
  Vec3 end() const { return p + ng() * epsilon(); }
  bool operator==(const Vpl&) const = default;
};
static_assert(sizeof(Vpl) == 32);

/// The glossy emission of a VPL: flux g(wi, wo), with g of eval_glossy in the frame of the shading normal.
struct VplGloss {
  Vec3 ns;    ///< unit
  Vec3 wi;    ///< unit, towards where the particle came from
  Vec3 flux;  ///< rho_s x the particle's weight. units: W
  float alpha = 0;
  GlossModel model = GlossModel::kWardDuer;
  bool operator==(const VplGloss&) const = default;
};

struct VplList {
  LargeArray<Vpl> vpls;
  /// Of those that have it, at most Vpl::kMostGloss; empty with Lambertian emission.
  std::vector<VplGloss> gloss;

  std::size_t size() const { return vpls.size(); }
  /// errors: InputError for more glossy VPLs than can be told apart
  void append(const VplList& other);
  bool operator==(const VplList&) const = default;
};

/// The VPLs of one scene, geometry, illumination and count for one material of the object. Paths that have
/// not met the object are the same for every material: those VPLs are `shared`.
struct VplSet {
  VplList shared;
  VplList own;
  std::int64_t paths = 0;
  std::vector<std::uint32_t> met = {};  ///< paths that met an object, rising

  std::int64_t count() const { return static_cast<std::int64_t>(shared.size() + own.size()); }
};

/// Both parts of a set in one list.
VplList join_vpls(VplSet set);

/// Of VPLs near some points, which may be few: sum of squares over sum, each VPL weighed by the square of the
/// irradiance that it would bring there, unoccluded and no nearer than a quarter of the points' extent.
/// shape: channels. units: W/sr
std::array<double, 3> measure_intensity(const VplList& list, std::span<const SurfacePoint> points);

/// Emission of a VPL of the list towards a unit direction, times the cosine at it. units: W/sr
Vec3 emit_vpl(const VplList& list, const Vpl& vpl, Vec3 wo);

/// VPLs per path of a pilot of 1e5 paths with another stream and a grey Lambertian object. One number for all
/// materials. Empty if no path leaves a VPL.
std::optional<double> find_vpls_per_path(const World& world, std::uint64_t seed,
                                         Emission emission = Emission::kLambertian);

/// Number of paths that gives about `target` VPLs: target / find_vpls_per_path, rounded, at least 1. errors:
/// InputError if no path leaves a VPL.
std::int64_t find_path_count(const World& world, std::int64_t target, std::uint64_t seed,
                             Emission emission = Emission::kLambertian);

/// A warning where less than half or more than twice as many VPLs were made as were asked for: the pilot's
/// object is diffuse, whatever the object's material is. Else empty.
std::string tell_odd_count(std::int64_t asked, std::int64_t made);

/// Of about `count` VPLs and their tree, at the peak (docs/performance.md). units: bytes
std::uint64_t estimate_vpl_memory(std::int64_t count);

/// Runs what traces about `count` VPLs and builds their tree, if there is memory for that. errors: InputError
void with_vpl_memory(std::int64_t count, const std::function<void()>& body);

/// Traces `paths` particles from the lights; at every surface that they meet they leave a VPL, if it sends
/// light on. All are kept. The particles do not depend on `emission`. errors: InputError for VPLs that are
/// not finite, and for more glossy ones than Vpl::kMostGloss
VplSet trace_vpls(const World& world, const Materials& materials, std::int64_t paths, std::uint64_t seed,
                  const std::string& stream_name, Emission emission = Emission::kLambertian);

/// The `own` part of trace_vpls for other materials of the objects, from the paths of a set that met one: the
/// same as tracing all again. errors: as trace_vpls
VplList trace_own_vpls(const World& world, const Materials& materials, const VplSet& set, std::uint64_t seed,
                       const std::string& stream_name, Emission emission = Emission::kLambertian);

}  // namespace equilux
