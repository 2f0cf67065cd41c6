// The plain sum over all VPLs, sixteen shading points at a time.
#include <algorithm>
#include <array>
#include <atomic>

#include "base/error.h"
#include "base/random.h"
#include "renderer/kernels.h"
#include "renderer/lane_lobe.h"
#include "renderer/parallel.h"

// After all other headers.
// clang-format off
#include "renderer/isa_begin.h"
// clang-format on

namespace equilux::EQ_ISA {
namespace {

constexpr std::size_t kBlock = 256;  // VPLs summed in float before they go to double

// Sixteen points with all that does not depend on the VPL.
struct PointGroup {
  Floats3 p, ng, ns, s, t, v;
  Floats cos_v;
  PointPacket origins;
  std::uint32_t valid = 0;
  std::uint64_t index = 0;  // among all groups
};

PointGroup make_group(const ShadingPoint* points, std::size_t count, std::uint64_t index) {
  PointGroup group;
  group.index = index;
  Lane3 p, ng, ns, s, t, v;
  alignas(64) std::array<float, kLanes> cos_v;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const ShadingPoint& point = points[std::min(lane, count - 1)];
    const Frame frame(point.surface.ns);
    p.set(lane, point.surface.p);
    ng.set(lane, point.surface.ng);
    ns.set(lane, frame.n);
    s.set(lane, frame.s);
    t.set(lane, frame.t);
    v.set(lane, point.v);
    cos_v[lane] = dot(frame.n, point.v);
    group.origins.set(lane, point.surface.origin());
    if (lane < count) group.valid |= 1u << lane;
  }
  group.p = load(p);
  group.ng = load(ng);
  group.ns = load(ns);
  group.s = load(s);
  group.t = load(t);
  group.v = load(v);
  group.cos_v = load(cos_v.data());
  return group;
}

// A VPL as the sixteen points see it. Lanes that do not see it hold what changes nothing: zero emission.
struct Sight {
  Floats cos_l, r2;
  HalfVector half;
  Floats3 light;  // emission towards the points x cosine at the VPL
};

// Emission of the glossy part towards sixteen directions wo (unit), x the cosine at the VPL.
EQ_INLINE Floats3 emit_gloss(const VplGloss& gloss, const Floats3& wo, const Floats& cos_vpl) {
  const Frame frame(gloss.ns);
  const Vec3 wi = frame.to_local(gloss.wi);
  const Floats cos_out = dot(splat(frame.n), wo);
  const HalfVector half =
      make_half_vector(dot(splat(frame.s), wo) + wi.x, dot(splat(frame.t), wo) + wi.y, cos_out + wi.z);
  const Floats lobe = eval_lobe(gloss.model, gloss.alpha, broadcast(wi.z), cos_out, half);
  if (!(wi.z > 0)) return splat({});
  return splat(gloss.flux) * select(cos_out > 0.0f, lobe * (cos_vpl / cos_out), zeros());
}

// Whatever lies between is not asked for yet. Gives the lanes that face the VPL and are faced by it.
EQ_INLINE std::uint32_t face_vpl(const PointGroup& group, const VplList& list, std::size_t index,
                                 Sight& sight, std::uint64_t& coincident) {
  const Vpl& vpl = list.vpls[index];
  const Floats3 d = splat(vpl.p) - group.p;
  sight.r2 = dot(d, d);
  const Floats inverse = 1.0f / sqrt(sight.r2);
  const Floats3 l = d * inverse;
  sight.cos_l = dot(group.ns, l);
  const Floats cos_vpl = -dot(splat(vpl.ng()), l);
  const Mask lit = (sight.r2 > 0.0f) & (sight.cos_l > 0.0f) & (dot(group.ng, l) > 0.0f) & (cos_vpl > 0.0f);
  const std::uint32_t wanted = lane_mask(lit) & group.valid;
  if (wanted != group.valid) [[unlikely]]
    coincident += static_cast<std::uint64_t>(std::popcount(lane_mask(zeros() >= sight.r2) & group.valid));
  if (wanted == 0) return 0;
  const Floats3 h = group.v + l;
  sight.half = make_half_vector(dot(group.s, h), dot(group.t, h), dot(group.ns, h));
  sight.light = splat(vpl.intensity) * cos_vpl;
  if (vpl.gloss() >= 0) {
    const Floats3 wo{-l.x, -l.y, -l.z};
    sight.light = sight.light + emit_gloss(list.gloss[static_cast<std::size_t>(vpl.gloss())], wo, cos_vpl);
  }
  return wanted;
}

// A lane that does not see the VPL may hold anything, NaN too: it is masked, not multiplied.
EQ_INLINE void mask_sight(std::uint32_t lanes, Sight& sight) {
  const Mask seen = from_lane_mask(lanes);
  sight.light = select(seen, sight.light, splat({}));
  sight.cos_l = select(seen, sight.cos_l, zeros());
  sight.half = {select(seen, sight.half.z, broadcast(1)), select(seen, sight.half.tan2, zeros())};
  sight.r2 = select(seen, sight.r2, broadcast(1));
}

// M = f cl, channel by channel.
EQ_INLINE Floats3 eval_m(const Material& material, const PointGroup& group, const Sight& sight) {
  const Floats diffuse = sight.cos_l * kInvPi;
  const Floats3 m = splat(material.rho_d) * diffuse;
  if (material.glossy_share == 0) return m;
  const Floats lobe = eval_lobe(material.model, material.alpha, group.cos_v, sight.cos_l, sight.half);
  const Mask facing = (group.cos_v > 0.0f) & (sight.cos_l > 0.0f);
  return m + splat(material.rho_s) * select(facing, lobe, zeros());
}

// Running sums of one group: material x level, in float within a block of VPLs and in double over blocks.
class Accumulator {
 public:
  Accumulator(std::size_t materials, const std::vector<double>& clamps)
      : levels_(clamps.size()),
        clamps_(clamps),
        block_(materials * levels_, splat({})),
        total_(materials * levels_) {}

  EQ_INLINE void add(std::size_t material, const Floats3& m, const Sight& sight) {
    const Floats largest = max_component(m);
    const Floats peak = largest / sight.r2;  // infinite where it leaves float: the clamp still bounds it
    const Floats share = select(largest > 0.0f, 1.0f / largest, zeros());
    const Floats3 light{m.x * share * sight.light.x, m.y * share * sight.light.y,
                        m.z * share * sight.light.z};
    Floats3* sums = &block_[material * levels_];
    for (std::size_t level = 0; level < levels_; ++level) {
      const Floats clamped = min(peak, broadcast(static_cast<float>(clamps_[level])));
      sums[level].x += light.x * clamped;
      sums[level].y += light.y * clamped;
      sums[level].z += light.z * clamped;
    }
  }

  void close_block() {
    for (std::size_t i = 0; i < block_.size(); ++i) {
      const auto x = to_array(block_[i].x), y = to_array(block_[i].y), z = to_array(block_[i].z);
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        total_[i][lane][0] += x[lane];
        total_[i][lane][1] += y[lane];
        total_[i][lane][2] += z[lane];
      }
      block_[i] = splat({});
    }
  }

  void add(const Accumulator& other) {
    for (std::size_t i = 0; i < total_.size(); ++i) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        for (std::size_t channel = 0; channel < 3; ++channel)
          total_[i][lane][channel] += other.total_[i][lane][channel];
      }
    }
  }

  Vec3 total(std::size_t material, std::size_t level, std::size_t lane) const {
    const auto& sum = total_[material * levels_ + level][lane];
    return {static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
  }

 private:
  std::size_t levels_;
  const std::vector<double>& clamps_;
  std::vector<Floats3> block_;
  std::vector<std::array<std::array<double, 3>, kLanes>> total_;
};

// Largest radiance of any lane, material and channel over the material's threshold, unclamped and unshadowed.
// Over a threshold of 0 all light is certain.
float find_peak(const std::vector<Material>& materials, const std::vector<double>& thresholds,
                const PointGroup& group, const Sight& sight) {
  Floats peak = zeros();
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const Floats3 m = eval_m(materials[i], group, sight);
    const Floats largest = max(m.x * sight.light.x, max(m.y * sight.light.y, m.z * sight.light.z));
    const Floats limit = sight.r2 * static_cast<float>(thresholds[i]);
    peak = max(peak, select(limit > 0.0f, largest / limit, select(largest > 0.0f, broadcast(1), zeros())));
  }
  const auto lanes = to_array(peak);
  return *std::max_element(lanes.begin(), lanes.end());
}

// The materials that light is summed for, and how.
struct ShadeJob {
  const World& world;
  const VplList& list;
  const std::vector<Material>& materials;
  const ShadowRoulette& roulette;
  StreamKey key;
};

// Decides whether the rays of a pair are traced, and weighs it for those that are not.
bool survives(const ShadeJob& job, const PointGroup& group, std::size_t index, Sight& sight) {
  const float share = find_peak(job.materials, job.roulette.thresholds, group, sight);
  if (share >= 1) return true;
  RandomStream random(job.key, group.index * job.list.size() + index);
  if (random.next_float() >= share) return false;
  const float weight = 1 / share;
  sight.light = sight.light * broadcast(weight);
  return true;
}

struct PairCounts {
  std::uint64_t coincident = 0, rays = 0;
};

// Of the VPLs from `from` to `to`.
PairCounts sum_vpls(const ShadeJob& job, const PointGroup& group, std::size_t from, std::size_t to,
                    Accumulator& accumulator) {
  PairCounts counts;
  const auto sum_vpl = [&](std::size_t i) {
    Sight sight;
    const std::uint32_t wanted = face_vpl(group, job.list, i, sight, counts.coincident);
    if (wanted == 0) return;
    if (!job.roulette.thresholds.empty()) {
      mask_sight(wanted, sight);
      if (!survives(job, group, i, sight)) return;
    }
    const Vpl& vpl = job.list.vpls[i];
    counts.rays += static_cast<std::uint64_t>(std::popcount(wanted));
    const std::uint32_t visible = job.world.find_visible(group.origins, vpl.end(), wanted);
    if (visible == 0) return;
    mask_sight(visible, sight);
    for (std::size_t m = 0; m < job.materials.size(); ++m)
      accumulator.add(m, eval_m(job.materials[m], group, sight), sight);
  };
  for (std::size_t first = from; first < to; first += kBlock) {
    const std::size_t last = std::min(to, first + kBlock);
    for (std::size_t i = first; i < last; ++i) sum_vpl(i);
    accumulator.close_block();
  }
  return counts;
}

// Parts of the list that are summed side by side, where there are too few groups to share out.
std::size_t count_parts(std::size_t groups, std::size_t vpls) {
  constexpr std::size_t kEnough = 64, kSmallest = 64 * kBlock;
  return groups >= kEnough
             ? 1
             : std::clamp<std::size_t>(vpls / kSmallest, 1, kEnough / std::max<std::size_t>(groups, 1));
}

// A group's light, from the list in parts.
class GroupSums {
 public:
  GroupSums(const ShadeJob& job, const std::vector<double>& clamps, PointGroup group, std::size_t parts)
      : job_(job), group_(group), parts_(parts, Accumulator(job.materials.size(), clamps)), counts_(parts) {}

  void sum(std::size_t part) {
    const std::size_t size = job_.list.size(), count = parts_.size();
    counts_[part] = sum_vpls(job_, group_, size * part / count, size * (part + 1) / count, parts_[part]);
  }

  PairCounts join() {
    for (std::size_t i = 1; i < parts_.size(); ++i) {
      parts_[0].add(parts_[i]);
      counts_[0].coincident += counts_[i].coincident;
      counts_[0].rays += counts_[i].rays;
    }
    return counts_[0];
  }

  void write_light(std::size_t first, std::size_t count, ShadedPoints& shaded) const {
    for (std::size_t m = 0; m < job_.materials.size(); ++m) {
      for (std::size_t level = 0; level < shaded.levels; ++level) {
        for (std::size_t lane = 0; lane < count; ++lane)
          shaded.radiance[shaded.index(m, level, first + lane)] = parts_[0].total(m, level, lane);
      }
    }
  }

 private:
  const ShadeJob& job_;
  PointGroup group_;
  std::vector<Accumulator> parts_;
  std::vector<PairCounts> counts_;
};

}  // namespace

ShadedPoints shade_all_vpls(const World& world, const std::vector<ShadingPoint>& points, const VplList& vpls,
                            const std::vector<Material>& materials, const std::vector<double>& clamps_per_m2,
                            const std::function<void(double)>& progress, const ShadowRoulette& roulette) {
  for (double clamp : clamps_per_m2) EQ_CHECK(clamp >= 0, clamp);
  EQ_CHECK(roulette.thresholds.empty() || roulette.thresholds.size() == materials.size());
  ShadedPoints shaded{clamps_per_m2.size(), points.size(), {}, 0};
  std::atomic<std::uint64_t> coincident = 0, rays = 0;
  const ShadeJob job{world, vpls, materials, roulette, make_stream_key(roulette.seed, "shadow-roulette")};
  shaded.radiance.resize(materials.size() * shaded.levels * shaded.points);
  const std::size_t groups = (points.size() + kLanes - 1) / kLanes, parts = count_parts(groups, vpls.size());
  for_each_parallel(groups, [&](std::size_t index) {
    const std::size_t first = index * kLanes, count = std::min(kLanes, points.size() - first);
    GroupSums sums(job, clamps_per_m2, make_group(&points[first], count, index), parts);
    for_each_parallel(parts, [&](std::size_t part) {
      sums.sum(part);
      progress(static_cast<double>(count) * static_cast<double>(vpls.size()) / static_cast<double>(parts));
    });
    const PairCounts counts = sums.join();
    coincident += counts.coincident;
    rays += counts.rays;
    sums.write_light(first, count, shaded);
  });
  shaded.coincident = coincident;
  shaded.rays = rays;
  check_finite(shaded);
  return shaded;
}

}  // namespace equilux::EQ_ISA

#include "renderer/isa_end.h"
