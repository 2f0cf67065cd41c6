// One point, extreme sets of lights: bounds against what they bound, cuts against the plain sum.
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "base/error.h"
#include "base/random.h"
#include "renderer/lightcut.h"
#include "renderer/stress.h"
#include "renderer/stress_scene.h"

namespace equilux {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr double kRatio = 0.0075;

Material make_metal(float alpha) {
  return make_material({"metal", {0.02f, 0.02f, 0.02f}, {0.33f, 0.33f, 0.33f}, alpha});
}

// A point at the origin that faces up, seen at 30 degrees; nothing stands between it and any light above.
class CutPoint {
 public:
  CutPoint() : world_(make_world(make_stress_scene(kOpenSpace), "G0", Illumination::kIndirect)) {
    point_.surface.ng = point_.surface.ns = {0, 0, 1};
    point_.v = {0.5f, 0, std::sqrt(0.75f)};
  }

  const ShadingPoint& point() const { return point_; }

  double sum(const VplList& vpls, const Material& material, double clamp) const {
    return shade_all_vpls(world_, {point_}, vpls, {material}, {clamp}, [](double) {}).radiance[0].y;
  }
  double cut(const VplList& vpls, const Material& material, double clamp, double floor = 0) const {
    const LightTree tree = make_light_tree(vpls, {1, 4});
    return shade_lightcut(world_, {point_}, tree, {material}, {clamp}, {kRatio, floor}).radiance[0].y;
  }

 private:
  World world_;
  ShadingPoint point_;
};

Vec3 draw_direction(RandomStream& random) {
  const float z = 2 * random.next_float() - 1, angle = 2 * kPi * random.next_float();
  const float r = std::sqrt(std::max(0.0f, 1 - z * z));
  return {r * std::cos(angle), r * std::sin(angle), z};
}

float draw_decades(RandomStream& random, double low, double high) {
  return static_cast<float>(std::pow(10.0, low + (high - low) * random.next_double()));
}

Vpl make_vpl(Vec3 p, Vec3 ng, float power) { return {p, 0, ng, {power, power, power}}; }

// Boxes around the point, from .1 mm to 10 m, of 64 VPLs that face anywhere.
StressRow stress_bounds(const CutPoint& point) {
  const BoundPoint frame = make_bound_point(point.point());
  std::size_t cases = 0, broken = 0, unbounded = 0;
  for (std::uint64_t trial = 0; trial < 300; ++trial) {
    RandomStream random(1, "stress.inside", trial);
    const float size = draw_decades(random, -4, 1);
    VplList list;
    for (int i = 0; i < 64; ++i)
      list.vpls.push_back(make_vpl(draw_direction(random) * (size * random.next_float()),
                                   draw_direction(random), random.next_float()));
    const LightTree tree = make_light_tree(list, {1, 64});
    const Cluster cluster = unpack_cluster(tree, tree.nodes.front());
    const BoxSight sight = sight_box(frame, cluster.low, cluster.high);
    for (const Material& material : {make_metal(0.05f), make_metal(0.001f), make_metal(1e-4f)}) {
      for (float clamp : {kInfinity, 316.0f, 10.0f, 0.01f}) {
        const float transfer = bound_transfer(bound_material(material, frame, sight), sight.least_r2, clamp);
        const double bound = double{bound_emission({}, cluster, nullptr)} * transfer;
        ++cases;
        broken += !(point.sum(list, material, clamp) <= bound);
        unbounded += std::isinf(bound) != std::isinf(clamp);
      }
    }
  }
  return make_stress_row(
      "lightcuts", "a point inside its cluster's box, .1 mm to 10 m wide; alpha .05 to 1e-4; four clamps",
      "the bound holds; infinite without a clamp only",
      fmt::format("{} of {} broken, {} infinite or not where they should", broken, cases, unbounded),
      broken == 0 && unbounded == 0);
}

// A tolerance of 0 is for sums that are 0.
StressRow expect_sum(const CutPoint& point, std::string what, const VplList& list, const Material& material,
                     double clamp, double tolerance) {
  const double sum = point.sum(list, material, clamp), cut = point.cut(list, material, clamp);
  const double error = sum == 0 ? std::abs(cut) : std::abs(cut / sum - 1);
  return make_stress_row("lightcuts", std::move(what), fmt::format("the plain sum within {:g}", tolerance),
                         fmt::format("{:.6g}, error {:.1e}", sum, error),
                         error <= tolerance && (sum > 0) == (tolerance > 0));
}

VplList make_distances() {
  VplList list;
  RandomStream random(2, "stress.distances", 0);
  for (int i = 0; i < 50000; ++i) {
    const Vec3 direction = sample_cosine(random.next_float(), random.next_float());
    list.vpls.push_back(
        make_vpl(direction * draw_decades(random, -4, 6), -direction, draw_decades(random, -6, 6)));
  }
  return list;
}

void add_spans(const CutPoint& point, std::vector<StressRow>& rows) {
  const VplList list = make_distances();
  for (double clamp : {double{kInfinity}, 10.0, 0.01})
    rows.push_back(expect_sum(
        point, fmt::format("50,000, .1 mm to 1,000 km away, powers over 12 decades, c = {:g}", clamp), list,
        make_metal(0.05f), clamp, 0.02));
}

// Where the mirror lobe of 1e-4 has its light: within some thousandths about the mirror direction.
StressRow stress_narrow_lobe(const CutPoint& point) {
  VplList list;
  RandomStream random(3, "stress.narrow", 0);
  for (int i = 0; i < 50000; ++i) {
    const Vec3 direction = normalize(Vec3{-0.5f, 0, std::sqrt(0.75f)} + draw_direction(random) * 0.003f);
    list.vpls.push_back(make_vpl(direction * (2 + random.next_float()), -direction, 1));
  }
  return expect_sum(point, "50,000 in a mirror lobe of alpha 1e-4, C0", list, make_metal(1e-4f), kInfinity,
                    0.02);
}

void add_places(const CutPoint& point, std::vector<StressRow>& rows) {
  const Material metal = make_metal(0.05f);
  const auto many = [](Vec3 p, Vec3 ng) { return VplList{LargeArray<Vpl>(50000, make_vpl(p, ng, 1)), {}}; };
  rows.push_back(
      expect_sum(point, "50,000 in one place", many({0, 0, 2}, {0, 0, -1}), metal, kInfinity, 1e-4));
  rows.push_back(expect_sum(point, "50,000 on the point", many({}, {0, 0, -1}), metal, kInfinity, 0));
  rows.push_back(
      expect_sum(point, "50,000 behind the point", many({0, 0, -2}, {0, 0, 1}), metal, kInfinity, 0));
  rows.push_back(expect_sum(point, "50,000 that face away", many({0, 0, 2}, {0, 0, 1}), metal, kInfinity, 0));
  rows.push_back(expect_sum(point, "none", {}, metal, kInfinity, 0));
  const VplList strong{LargeArray<Vpl>(50000, make_vpl({0, 0, 1e-6f}, {0, 0, -1}, 1e30f)), {}};
  rows.push_back(expect_sum(point, "50,000 of 1e30 W/sr at 1e-6 m, c = 10", strong, metal, 10, 1e-4));
  rows.push_back(expect_input_error("lightcuts", "50,000 of 1e30 W/sr at 1e-6 m, C0: beyond float",
                                    [&] { point.cut(strong, metal, kInfinity); }));
}

}  // namespace

std::vector<StressRow> stress_lightcuts() {
  const CutPoint point;
  std::vector<StressRow> rows{stress_bounds(point)};
  add_spans(point, rows);
  rows.push_back(stress_narrow_lobe(point));
  add_places(point, rows);
  return rows;
}

}  // namespace equilux
