// The plain sum over all VPLs, sixteen shading points at a time.
#include "renderer/shade.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "base/error.h"
#include "renderer/parallel.h"

namespace equilux {
namespace {

constexpr std::size_t kLanes = 16;
constexpr std::size_t kBlock = 256;  // VPLs summed in float before they go to double

using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));
using Ints = int __attribute__((vector_size(kLanes * sizeof(int))));

#define EQ_INLINE inline __attribute__((always_inline))

EQ_INLINE Floats broadcast(float value) { return Floats{} + value; }

EQ_INLINE Floats min(Floats a, Floats b) { return a < b ? a : b; }
EQ_INLINE Floats max(Floats a, Floats b) { return a > b ? a : b; }

EQ_INLINE Floats sqrt(Floats a) {
  Floats root;
  for (std::size_t i = 0; i < kLanes; ++i) root[i] = std::sqrt(a[i]);
  return root;
}

// exp(x) for x <= 0, relative error under 3e-7; 0 below -87, where float has only denormals left.
EQ_INLINE Floats exp_of_negative(Floats x) {
  const Floats clamped = max(x, broadcast(-87.0f));
  const Ints n = __builtin_convertvector(clamped * 1.44269504f - 0.5f, Ints);
  const Floats nf = __builtin_convertvector(n, Floats);
  const Floats f = (clamped - nf * 0.693359375f) - nf * -2.12194440e-4f;
  const Floats poly =
      1.0f + f * (1.0f + f * (0.5f + f * (1.6666667e-1f +
                                          f * (4.1666668e-2f + f * (8.3333333e-3f + f * 1.3888889e-3f)))));
  const Ints bits = (n + 127) << 23;
  return x < -87.0f ? Floats{} : poly * std::bit_cast<Floats>(bits);
}

struct Floats3 {
  Floats x, y, z;
};
EQ_INLINE Floats dot(const Floats3& a, const Floats3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
EQ_INLINE Floats3 splat(Vec3 v) { return {broadcast(v.x), broadcast(v.y), broadcast(v.z)}; }
void set_lane(Floats3& target, std::size_t lane, Vec3 v) {
  target.x[lane] = v.x;
  target.y[lane] = v.y;
  target.z[lane] = v.z;
}

// Sixteen points with all that does not depend on the VPL.
struct PointGroup {
  Floats3 p, ng, ns, s, t, v;
  Floats cos_v;
  PointPacket origins;
  std::uint32_t valid = 0;
};

PointGroup make_group(const ShadingPoint* points, std::size_t count) {
  PointGroup group;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const ShadingPoint& point = points[std::min(lane, count - 1)];
    const Frame frame(point.surface.ns);
    set_lane(group.p, lane, point.surface.p);
    set_lane(group.ng, lane, point.surface.ng);
    set_lane(group.ns, lane, frame.n);
    set_lane(group.s, lane, frame.s);
    set_lane(group.t, lane, frame.t);
    set_lane(group.v, lane, point.v);
    group.cos_v[lane] = dot(frame.n, point.v);
    const Vec3 origin = point.surface.origin();
    group.origins.x[lane] = origin.x;
    group.origins.y[lane] = origin.y;
    group.origins.z[lane] = origin.z;
    if (lane < count) group.valid |= 1u << lane;
  }
  return group;
}

// A VPL as the sixteen points see it.
struct Sight {
  Floats cos_l, tan2, r2, form;  // form: cosine at the VPL / r^2, 0 where the VPL is not seen
};

EQ_INLINE std::uint32_t lane_mask(const Ints& lanes) {
  std::uint32_t mask = 0;
  for (std::size_t i = 0; i < kLanes; ++i) mask |= static_cast<std::uint32_t>(lanes[i] & 1) << i;
  return mask;
}

EQ_INLINE Floats from_mask(std::uint32_t mask) {
  Floats ones{};
  for (std::size_t i = 0; i < kLanes; ++i) ones[i] = (mask >> i) & 1u ? 1.0f : 0.0f;
  return ones;
}

EQ_INLINE bool see_vpl(const World& world, const PointGroup& group, const Vpl& vpl, Sight& sight) {
  const Floats3 d{vpl.p.x - group.p.x, vpl.p.y - group.p.y, vpl.p.z - group.p.z};
  sight.r2 = dot(d, d);
  const Floats inverse = 1.0f / sqrt(sight.r2);
  const Floats3 l{d.x * inverse, d.y * inverse, d.z * inverse};
  sight.cos_l = dot(group.ns, l);
  const Floats cos_vpl = -dot(splat(vpl.ng), l);
  const Ints lit = (sight.r2 > 0.0f) & (sight.cos_l > 0.0f) & (dot(group.ng, l) > 0.0f) & (cos_vpl > 0.0f);
  const std::uint32_t wanted = lane_mask(lit) & group.valid;
  if (wanted == 0) return false;
  const std::uint32_t visible = world.find_visible(group.origins, vpl.p + vpl.ng * vpl.epsilon, wanted);
  if (visible == 0) return false;
  const Floats3 h{group.v.x + l.x, group.v.y + l.y, group.v.z + l.z};
  const Floats hx = dot(group.s, h), hy = dot(group.t, h), hz = dot(group.ns, h);
  sight.tan2 = (hx * hx + hy * hy) / (hz * hz);
  // A lane that does not see the VPL may hold anything, NaN too: it is masked, not multiplied.
  const Ints seen = from_mask(visible) > 0.0f;
  sight.form = seen ? cos_vpl / sight.r2 : Floats{};
  sight.cos_l = seen ? sight.cos_l : Floats{};
  sight.tan2 = seen ? sight.tan2 : Floats{};
  sight.r2 = seen ? sight.r2 : broadcast(1.0f);
  return true;
}

// M = f cl, channel by channel: the light's cosine cancels in the glossy part of Ward-Duer.
EQ_INLINE Floats3 eval_m(const Material& material, const PointGroup& group, const Sight& sight) {
  const Floats diffuse = sight.cos_l * kInvPi;
  Floats3 m{material.rho_d.x * diffuse, material.rho_d.y * diffuse, material.rho_d.z * diffuse};
  if (material.glossy_share == 0) return m;
  const float a2 = material.alpha * material.alpha;
  const Floats lobe = exp_of_negative(sight.tan2 * (-1.0f / a2)) / (4 * kPi * a2 * group.cos_v);
  const Ints facing = (group.cos_v > 0.0f) & (sight.cos_l > 0.0f);
  const Floats glossy = facing ? lobe : Floats{};
  m.x += material.rho_s.x * glossy;
  m.y += material.rho_s.y * glossy;
  m.z += material.rho_s.z * glossy;
  return m;
}

// Running sums of one group: material x level, in float within a block of VPLs and in double over blocks.
class Accumulator {
 public:
  Accumulator(std::size_t materials, const std::vector<double>& clamps)
      : levels_(clamps.size()), clamps_(clamps), block_(materials * levels_), total_(materials * levels_) {}

  EQ_INLINE void add(std::size_t material, const Floats3& m, const Sight& sight, Vec3 intensity) {
    const Floats largest = max(m.x, max(m.y, m.z));
    const Floats reach = sight.r2 / largest;  // infinite where M is 0
    const Floats3 term{m.x * sight.form * intensity.x, m.y * sight.form * intensity.y,
                       m.z * sight.form * intensity.z};
    Floats3* sums = &block_[material * levels_];
    for (std::size_t level = 0; level < levels_; ++level) {
      const auto clamp = static_cast<float>(clamps_[level]);
      const Floats scale = min(clamp * reach, broadcast(1.0f));
      sums[level].x += term.x * scale;
      sums[level].y += term.y * scale;
      sums[level].z += term.z * scale;
    }
  }

  void close_block() {
    for (std::size_t i = 0; i < block_.size(); ++i) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        total_[i][lane][0] += block_[i].x[lane];
        total_[i][lane][1] += block_[i].y[lane];
        total_[i][lane][2] += block_[i].z[lane];
      }
      block_[i] = Floats3{};
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

void sum_vpls(const World& world, const PointGroup& group, const std::vector<Vpl>& vpls,
              const std::vector<Material>& materials, Accumulator& accumulator) {
  for (std::size_t first = 0; first < vpls.size(); first += kBlock) {
    const std::size_t last = std::min(vpls.size(), first + kBlock);
    for (std::size_t i = first; i < last; ++i) {
      Sight sight;
      if (!see_vpl(world, group, vpls[i], sight)) continue;
      for (std::size_t m = 0; m < materials.size(); ++m) {
        accumulator.add(m, eval_m(materials[m], group, sight), sight, vpls[i].intensity);
      }
    }
    accumulator.close_block();
  }
}

std::uint64_t morton(std::uint32_t x, std::uint32_t y) {
  std::uint64_t code = 0;
  for (unsigned bit = 0; bit < 16; ++bit) {
    code |= std::uint64_t{(x >> bit) & 1u} << (2 * bit) | std::uint64_t{(y >> bit) & 1u} << (2 * bit + 1);
  }
  return code;
}

}  // namespace

std::vector<ShadingPoint> find_shading_points(const Primary& primary) {
  const auto width = static_cast<std::uint32_t>(primary.width),
             height = static_cast<std::uint32_t>(primary.height);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) order.emplace_back(morton(x, y), y * width + x);
  }
  std::sort(order.begin(), order.end());
  std::vector<ShadingPoint> points;
  for (const auto& [code, pixel] : order) {
    for (int position = 0; position < primary.positions; ++position) {
      const PrimaryHit& hit = primary.at(pixel, position);
      if (hit.kind == PrimaryKind::kObject) points.push_back({pixel, hit.point, hit.v});
    }
  }
  return points;
}

ShadedPoints shade_all_vpls(const World& world, const std::vector<ShadingPoint>& points,
                            const std::vector<Vpl>& vpls, const std::vector<Material>& materials,
                            const std::vector<double>& clamps_per_m2,
                            const std::function<void(double)>& progress) {
  for (double clamp : clamps_per_m2) EQ_CHECK(clamp > 0, clamp);
  ShadedPoints shaded{clamps_per_m2.size(), points.size(), {}};
  shaded.radiance.resize(materials.size() * shaded.levels * shaded.points);
  for_each_parallel((points.size() + kLanes - 1) / kLanes, [&](std::size_t index) {
    const std::size_t first = index * kLanes, count = std::min(kLanes, points.size() - first);
    const PointGroup group = make_group(&points[first], count);
    Accumulator accumulator(materials.size(), clamps_per_m2);
    sum_vpls(world, group, vpls, materials, accumulator);
    for (std::size_t m = 0; m < materials.size(); ++m) {
      for (std::size_t level = 0; level < shaded.levels; ++level) {
        for (std::size_t lane = 0; lane < count; ++lane) {
          shaded.radiance[shaded.index(m, level, first + lane)] = accumulator.total(m, level, lane);
        }
      }
    }
    progress(static_cast<double>(count) * static_cast<double>(vpls.size()));
  });
  const auto bad =
      std::count_if(shaded.radiance.begin(), shaded.radiance.end(), [](Vec3 v) { return !is_finite(v); });
  EQ_CHECK(bad == 0, bad);
  return shaded;
}

void add_to_layer(const ShadedPoints& shaded, std::size_t material, std::size_t level,
                  const std::vector<ShadingPoint>& points, int positions, HdrImage& layer) {
  const float share = 1.0f / static_cast<float>(positions);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 radiance = shaded.radiance[shaded.index(material, level, i)] * share;
    float* pixel = layer.pixel(points[i].pixel);
    pixel[0] += radiance.x;
    pixel[1] += radiance.y;
    pixel[2] += radiance.z;
  }
}

}  // namespace equilux
