// Particle tracing.
#include "renderer/vpl.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/memory.h"
#include "base/random.h"
#include "renderer/lights.h"
#include "renderer/parallel.h"

namespace equilux {
namespace {

constexpr std::int64_t kPilotPaths = 100000;
constexpr std::size_t kPathsPerBlock = 1024;

struct Particle {
  Vec3 origin;
  Vec3 direction;
  Vec3 weight;  // W
  bool met_object = false;
};

// Weight of what leaves over what comes, f |ns.wi| |ng.wo| / (|ng.wi| pdf): the adjoint of the path tracer's
// rule, in which light counts with the shading cosine where it comes in. The diffuse lobe is drawn about ng,
// where it leaves.
std::optional<Vec3> sample_particle(const Material& material, const SurfacePoint& point, Vec3 wi,
                                    PathSampler& sampler, Vec3& weight) {
  const float u0 = sampler.next(), u1 = sampler.next(), u2 = sampler.next();
  const Frame shading(point.ns);
  const Vec3 wi_local = shading.to_local(wi);
  Vec3 wo;
  if (u0 < material.glossy_share) {
    const auto sample = sample_glossy(material.alpha, wi_local, u1, u2);
    if (!sample) return std::nullopt;
    wo = shading.to_world(*sample);
  } else {
    wo = Frame(point.ng).to_world(sample_cosine(u1, u2));
  }
  const float cos_out = dot(point.ng, wo);
  if (!(cos_out > 0)) return std::nullopt;
  const Vec3 wo_local = shading.to_local(wo);
  float pdf = (1 - material.glossy_share) * cos_out * kInvPi;
  Vec3 f = material.rho_d * kInvPi;
  if (material.glossy_share > 0) {
    pdf += material.glossy_share * pdf_glossy(material.alpha, wi_local, wo_local);
    f += material.rho_s * eval_glossy(material, wi_local, wo_local);
  }
  if (!(pdf > 0)) return std::nullopt;
  weight = weight * f * (wi_local.z * cos_out / (dot(point.ng, wi) * pdf));
  return wo;
}

bool survives(Vec3 before, Vec3& after, PathSampler& sampler) {
  const float share = std::min(kLargestSurvival, max_component(after) / max_component(before));
  if (!(share > 0) || sampler.next() >= share) return false;
  after = after / share;
  return true;
}

struct PathParams {
  const World& world;
  const Materials& materials;
  Emission emission;
  float share;  ///< of each path in the whole: 1 / paths
};

void add_vpl(VplSet& set, const SurfacePoint& point, const Material& material, Vec3 wi,
             const Particle& particle, Emission emission) {
  const Vec3 flux = particle.weight * (dot(point.ns, wi) / dot(point.ng, wi));
  VplList& list = particle.met_object ? set.own : set.shared;
  Vpl vpl(point.p, point.epsilon, point.ng, flux * material.rho_d * kInvPi);
  const Vec3 glossy = flux * material.rho_s;
  if (emission == Emission::kFull && glossy != Vec3{}) {
    vpl.set_gloss(static_cast<std::int32_t>(list.gloss.size()));
    list.gloss.push_back({point.ns, wi, glossy, material.alpha, material.model});
  }
  if (vpl.intensity != Vec3{} || vpl.gloss() >= 0) list.vpls.push_back(vpl);
}

// True if it met an object.
bool trace_path(const PathParams& params, PathSampler sampler, VplSet& set) {
  const auto emitted = sample_emission(params.world, sampler);
  if (!emitted) return false;
  Particle particle{emitted->origin, emitted->direction, emitted->weight * params.share, false};
  while (max_component(particle.weight) > 0) {
    const auto hit = params.world.intersect(particle.origin, particle.direction);
    const Vec3 wi = -particle.direction;
    if (!hit || !(dot(hit->ns, wi) > 0)) break;
    particle.met_object = particle.met_object || hit->is_object();
    const Material& material = params.materials[hit->material];
    add_vpl(set, *hit, material, wi, particle, params.emission);
    const Vec3 before = particle.weight;
    const auto wo = sample_particle(material, *hit, wi, sampler, particle.weight);
    if (!wo || !survives(before, particle.weight, sampler)) break;
    particle.origin = hit->origin();
    particle.direction = *wo;
  }
  return particle.met_object;
}

// Where the random numbers of a set's paths come from.
class PathTracing {
 public:
  PathTracing(const PathParams& params, std::uint64_t seed, const std::string& stream_name)
      : params_(params), key_(make_stream_key(seed, stream_name)) {
    RandomStream shared(seed, stream_name + ".shift", 0);
    shift_ = draw_shift(shared);
  }

  // Compiled once: two copies may round otherwise.
  [[gnu::noinline, gnu::noclone]] bool trace(std::size_t path, VplSet& set) const {
    return trace_path(params_, PathSampler(shift_, path, RandomStream(key_, path)), set);
  }

 private:
  PathParams params_;
  StreamKey key_;
  LatticePoint shift_{};
};

void check_finite(const World& world, const VplList& list) {
  auto bad = std::count_if(list.vpls.begin(), list.vpls.end(),
                           [](const Vpl& vpl) { return !is_finite(vpl.intensity); });
  bad += std::count_if(list.gloss.begin(), list.gloss.end(),
                       [](const VplGloss& gloss) { return !is_finite(gloss.flux); });
  if (bad > 0)
    throw InputError(world.scene_path(), fmt::format("/lights ({})", world.name()),
                     "lights whose VPLs are finite", fmt::format("{} that are not", bad));
}

void check_gloss_count(std::size_t count) {
  if (count > Vpl::kMostGloss)
    throw InputError("VPLs", "full emission", fmt::format("at most {} that are glossy", Vpl::kMostGloss),
                     std::to_string(count));
}

// One part of all blocks, in their order. The blocks' own is freed on the way.
VplList join_lists(std::vector<VplSet>& blocks, VplList VplSet::*part) {
  std::vector<std::size_t> firsts, first_gloss;
  std::size_t count = 0, gloss_count = 0;
  for (const VplSet& block : blocks) {
    firsts.push_back(count);
    first_gloss.push_back(gloss_count);
    count += (block.*part).size();
    gloss_count += (block.*part).gloss.size();
  }
  check_gloss_count(gloss_count);
  VplList joined;
  joined.vpls.resize(count);
  joined.gloss.resize(gloss_count);
  for_each_parallel(blocks.size(), [&](std::size_t i) {
    VplList& list = blocks[i].*part;
    std::copy(list.gloss.begin(), list.gloss.end(),
              joined.gloss.begin() + static_cast<std::ptrdiff_t>(first_gloss[i]));
    Vpl* place = joined.vpls.data() + firsts[i];
    for (Vpl vpl : list.vpls) {
      if (vpl.gloss() >= 0) vpl.set_gloss(vpl.gloss() + static_cast<std::int32_t>(first_gloss[i]));
      *place++ = vpl;
    }
    list = {};
  });
  return joined;
}

}  // namespace

Vpl::Vpl(Vec3 place, float epsilon, Vec3 ng, Vec3 power)
    : p(place), normal(encode_octahedral(ng)), intensity(power) {
  int exponent;
  const float mantissa = std::frexp(epsilon, &exponent);
  if (mantissa == 0.5f) --exponent;
  const int most = (1 << (32 - kGlossBits)) - 1;
  const int code = epsilon > 0 ? std::clamp(exponent - kLeastExponent, 0, most) : 0;
  packed = static_cast<std::uint32_t>(code) << kGlossBits;
}

float Vpl::epsilon() const {
  constexpr std::uint32_t kBias = 127 + kLeastExponent;
  return std::bit_cast<float>(((packed >> kGlossBits) + kBias) << 23);
}

void Vpl::set_gloss(std::int32_t index) {
  EQ_CHECK(index >= -1 && index + 1 <= static_cast<std::int32_t>(kMostGloss), index);
  packed = (packed & ~kMostGloss) | static_cast<std::uint32_t>(index + 1);
}

void VplList::append(const VplList& other) {
  check_gloss_count(gloss.size() + other.gloss.size());
  const auto offset = static_cast<std::int32_t>(gloss.size());
  for (Vpl vpl : other.vpls) {
    if (vpl.gloss() >= 0) vpl.set_gloss(vpl.gloss() + offset);
    vpls.push_back(vpl);
  }
  gloss.insert(gloss.end(), other.gloss.begin(), other.gloss.end());
}

VplList join_vpls(VplSet set) {
  VplList list = std::move(set.shared);
  list.append(set.own);
  return list;
}

namespace {

// The square of a quarter of the diagonal of the box about them.
float find_nearest_r2(std::span<const SurfacePoint> points) {
  if (points.empty()) return 0;
  Vec3 low = points[0].p, high = low;
  for (const SurfacePoint& point : points) {
    low = {std::min(low.x, point.p.x), std::min(low.y, point.p.y), std::min(low.z, point.p.z)};
    high = {std::max(high.x, point.p.x), std::max(high.y, point.p.y), std::max(high.z, point.p.z)};
  }
  const Vec3 extent = (high - low) / 4;
  return dot(extent, extent);
}

// 1/m^2, of a VPL of no particular intensity.
float find_form_factor(const SurfacePoint& point, const Vpl& vpl, float nearest_r2) {
  const Vec3 d = vpl.p - point.p;
  const float r2 = dot(d, d), cosines = dot(point.ng, d) * -dot(vpl.ng(), d);
  if (!(dot(point.ng, d) > 0) || !(cosines > 0)) return 0;
  return cosines / (r2 * std::max(r2, nearest_r2));
}

}  // namespace

std::array<double, 3> measure_intensity(const VplList& list, std::span<const SurfacePoint> points) {
  const float nearest_r2 = find_nearest_r2(points);
  std::array<double, 3> sums{}, squares{};
  for (const Vpl& vpl : list.vpls) {
    double weight = 0;
    for (const SurfacePoint& point : points) {
      const double factor = find_form_factor(point, vpl, nearest_r2);
      weight += factor * factor;
    }
    const std::array<double, 3> of_vpl{vpl.intensity.x, vpl.intensity.y, vpl.intensity.z};
    for (std::size_t c = 0; c < 3; ++c) {
      sums[c] += weight * of_vpl[c];
      squares[c] += weight * of_vpl[c] * of_vpl[c];
    }
  }
  for (std::size_t c = 0; c < 3; ++c) squares[c] = sums[c] > 0 ? squares[c] / sums[c] : 0;
  return squares;
}

Vec3 emit_vpl(const VplList& list, const Vpl& vpl, Vec3 wo) {
  const float cosine = dot(vpl.ng(), wo);
  if (!(cosine > 0)) return {};
  Vec3 light = vpl.intensity * cosine;
  if (vpl.gloss() < 0) return light;
  const VplGloss& gloss = list.gloss[static_cast<std::size_t>(vpl.gloss())];
  const Frame frame(gloss.ns);
  Material material;
  material.alpha = gloss.alpha;
  material.model = gloss.model;
  const float lobe = eval_glossy(material, frame.to_local(gloss.wi), frame.to_local(wo));
  return light + gloss.flux * (lobe * cosine);
}

VplSet trace_vpls(const World& world, const Materials& materials, std::int64_t paths, std::uint64_t seed,
                  const std::string& stream_name, Emission emission) {
  EQ_CHECK(paths > 0, paths);
  if (paths > std::numeric_limits<std::uint32_t>::max())
    throw InputError("VPLs", "", "fewer than 2^32 paths", std::to_string(paths));
  const PathTracing tracing({world, materials, emission, 1.0f / static_cast<float>(paths)}, seed,
                            stream_name);
  const auto count = static_cast<std::size_t>(paths);
  std::vector<VplSet> blocks((count + kPathsPerBlock - 1) / kPathsPerBlock);
  for_each_parallel(blocks.size(), [&](std::size_t block) {
    const std::size_t last = std::min(count, (block + 1) * kPathsPerBlock);
    for (std::size_t i = block * kPathsPerBlock; i < last; ++i) {
      if (tracing.trace(i, blocks[block])) blocks[block].met.push_back(static_cast<std::uint32_t>(i));
    }
  });
  VplSet set{join_lists(blocks, &VplSet::shared), join_lists(blocks, &VplSet::own), paths};
  for (const VplSet& block : blocks) set.met.insert(set.met.end(), block.met.begin(), block.met.end());
  check_finite(world, set.shared);
  check_finite(world, set.own);
  return set;
}

VplList trace_own_vpls(const World& world, const Materials& materials, const VplSet& set, std::uint64_t seed,
                       const std::string& stream_name, Emission emission) {
  const PathTracing tracing({world, materials, emission, 1.0f / static_cast<float>(set.paths)}, seed,
                            stream_name);
  std::vector<VplSet> blocks((set.met.size() + kPathsPerBlock - 1) / kPathsPerBlock);
  for_each_parallel(blocks.size(), [&](std::size_t block) {
    const std::size_t last = std::min(set.met.size(), (block + 1) * kPathsPerBlock);
    for (std::size_t i = block * kPathsPerBlock; i < last; ++i) tracing.trace(set.met[i], blocks[block]);
    blocks[block].shared = {};
  });
  VplList own = join_lists(blocks, &VplSet::own);
  check_finite(world, own);
  return own;
}

std::optional<double> find_vpls_per_path(const World& world, std::uint64_t seed, Emission emission) {
  const VplSet pilot =
      trace_vpls(world, make_grey_materials(world), kPilotPaths, seed, "vpl-pilot", emission);
  if (pilot.count() == 0) return std::nullopt;
  return static_cast<double>(pilot.count()) / static_cast<double>(kPilotPaths);
}

std::int64_t find_path_count(const World& world, std::int64_t target, std::uint64_t seed, Emission emission) {
  const std::optional<double> per_path = find_vpls_per_path(world, seed, emission);
  if (!per_path) {
    throw InputError(world.scene_path(), fmt::format("/lights ({})", world.name()),
                     emission == Emission::kFull ? "light that reaches a surface that is not black"
                                                 : "light that reaches a surface that is partly diffuse",
                     "none");
  }
  return std::max<std::int64_t>(1, std::llround(static_cast<double>(target) / *per_path));
}

std::string tell_odd_count(std::int64_t asked, std::int64_t made) {
  if (made == 0) return fmt::format("no VPLs where {} are asked for: what light meets leaves none", asked);
  if (2 * made >= asked && made <= 2 * asked) return "";
  return fmt::format("{} VPLs where {} are asked for", made, asked);
}

std::uint64_t estimate_vpl_memory(std::int64_t count) {
  constexpr std::uint64_t kBytesPerVpl = 160;
  return kBytesPerVpl * static_cast<std::uint64_t>(count);
}

void with_vpl_memory(std::int64_t count, const std::function<void()>& body) {
  with_memory(fmt::format("{} VPLs", count), estimate_vpl_memory(count), body);
}

}  // namespace equilux
