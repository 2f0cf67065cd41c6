// One point, extreme lights: the plain sum against closed forms.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "base/error.h"
#include "base/random.h"
#include "renderer/shade.h"
#include "renderer/stress.h"
#include "renderer/stress_scene.h"

namespace equilux {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kAlbedo = 0.19f;
constexpr double kM = kAlbedo / std::numbers::pi;  // f cl of a Lambertian surface under a light overhead

// A point at the origin that faces up, seen from above; nothing stands between it and any light above.
class Point {
 public:
  Point() : world_(make_world(make_stress_scene(kOpenSpace), "G0", Illumination::kIndirect)) {
    point_.surface.ng = point_.surface.ns = point_.v = {0, 0, 1};
  }

  ShadedPoints shade(const VplList& vpls, double clamp) const {
    return shade_all_vpls(world_, {point_}, vpls, {material_}, {clamp}, [](double) {});
  }
  double shade_one(const Vpl& vpl, double clamp) const { return shade({{vpl}, {}}, clamp).radiance[0].y; }

 private:
  World world_;
  ShadingPoint point_;
  Material material_ = make_material({"grey", {kAlbedo, kAlbedo, kAlbedo}, {}, 0});
};

// Overhead at a height, facing down.
Vpl overhead(double height, double power) {
  const auto i = static_cast<float>(power);
  return {{0, 0, static_cast<float>(height)}, 0, {0, 0, -1}, {i, i, i}};
}

StressRow expect_value(std::string what, double expected, double got, double tolerance = 1e-5) {
  const bool holds = expected == 0 ? got == 0 : std::abs(got / expected - 1) < tolerance;
  return make_stress_row("VPL", std::move(what), fmt::format("{:.6g}", expected), fmt::format("{:.6g}", got),
                         holds);
}

StressRow stress_coincident(const Point& point, double height, const std::string& what) {
  const auto shaded = point.shade({{overhead(height, 1)}, {}}, kInfinity);
  return make_stress_row("VPL", what, "left out and counted",
                         fmt::format("radiance {:g}, {} counted", shaded.radiance[0].y, shaded.coincident),
                         shaded.radiance[0] == Vec3{} && shaded.coincident == 1);
}

void add_distances(const Point& point, std::vector<StressRow>& rows) {
  rows.push_back(stress_coincident(point, 0, "on the point"));
  rows.push_back(
      expect_value("1e-12 m from the point, C0", kM * 1e24, point.shade_one(overhead(1e-12, 1), kInfinity)));
  rows.push_back(expect_value("1e-12 m from the point, c = 10", 10, point.shade_one(overhead(1e-12, 1), 10)));
  rows.push_back(stress_coincident(point, 1e-20, "1e-20 m from the point: r^2 is below float's range"));
  rows.push_back(expect_value("behind the point", 0, point.shade_one(overhead(-1, 1), kInfinity)));
  Vpl away = overhead(1, 1);
  away.normal = encode_octahedral({0, 0, 1});
  rows.push_back(expect_value("facing away", 0, point.shade_one(away, kInfinity)));
}

void add_powers(const Point& point, std::vector<StressRow>& rows) {
  for (double power : {1e18, 1e-18})
    rows.push_back(expect_value(fmt::format("intensity {:g} W/sr at 1 m", power), kM * power,
                                point.shade_one(overhead(1, power), kInfinity)));
  rows.push_back(expect_value("intensity 1e30 W/sr at 1e-6 m, c = 10", 10 * 1e30,
                              point.shade_one(overhead(1e-6, 1e30), 10)));
  rows.push_back(expect_input_error("VPL", "intensity 1e30 W/sr at 1e-6 m, C0: 1e40 is beyond float",
                                    [&] { point.shade_one(overhead(1e-6, 1e30), kInfinity); }));
}

void add_clamps(const Point& point, std::vector<StressRow>& rows) {
  rows.push_back(expect_value("c = 0", 0, point.shade_one(overhead(1, 1), 0)));
  rows.push_back(expect_value("c = 1e-40, a denormal: 0 where denormals are flushed", 0,
                              point.shade_one(overhead(1, 1), 1e-40)));
  rows.push_back(
      expect_value("c = 1e-37, the smallest decade", 1e-37, point.shade_one(overhead(1, 1), 1e-37)));
  rows.push_back(expect_value("c infinite", kM, point.shade_one(overhead(1, 1), kInfinity)));
  rows.push_back(expect_value("c = 1e300, beyond float", kM, point.shade_one(overhead(1, 1), 1e300)));
}

// Even over a half sphere of 1 to 3 m, powers even in their logarithm over twelve decades.
LargeArray<Vpl> make_many(int millions) {
  LargeArray<Vpl> vpls(std::size_t{1000000} * static_cast<std::size_t>(millions), Vpl{});
  RandomStream random(3, "stress.many", 0);
  for (Vpl& vpl : vpls) {
    const Vec3 direction = sample_cosine(random.next_float(), random.next_float());
    const auto power = static_cast<float>(std::pow(10.0, 12 * random.next_double() - 6));
    vpl = {direction * (1 + 2 * random.next_float()), 0, -direction, {power, power, power}};
  }
  return vpls;
}

long double sum_in_long_double(const LargeArray<Vpl>& vpls) {
  long double sum = 0;
  for (const Vpl& vpl : vpls) {
    const long double x = vpl.p.x, y = vpl.p.y, z = vpl.p.z, r2 = x * x + y * y + z * z, r = std::sqrt(r2);
    const Vec3 ng = vpl.ng();
    const long double cosine = -(ng.x * x + ng.y * y + ng.z * z) / r;
    if (z > 0 && cosine > 0)
      sum += kAlbedo / std::numbers::pi_v<long double> * (z / r) / r2 * cosine * vpl.intensity.y;
  }
  return sum;
}

// Summed from the weakest, from the strongest, and as they come.
void add_many(const Point& point, int millions, std::vector<StressRow>& rows) {
  VplList list{make_many(millions), {}};
  const auto exact = static_cast<double>(sum_in_long_double(list.vpls));
  const auto weaker = [](const Vpl& a, const Vpl& b) { return a.intensity.y < b.intensity.y; };
  const auto add = [&](const char* order) {
    const double error = std::abs(point.shade(list, kInfinity).radiance[0].y / exact - 1);
    rows.push_back(
        make_stress_row("VPL", fmt::format("{} million, powers over 12 decades, {}", millions, order),
                        "within 1e-5 of long double", fmt::format("error {:.1e}", error), error < 1e-5));
  };
  add("as they come");
  std::sort(list.vpls.begin(), list.vpls.end(), weaker);
  add("weakest first");
  std::reverse(list.vpls.begin(), list.vpls.end());
  add("strongest first");
}

}  // namespace

std::vector<StressRow> stress_vpls(int millions) {
  const Point point;
  std::vector<StressRow> rows;
  add_distances(point, rows);
  add_powers(point, rows);
  add_clamps(point, rows);
  add_many(point, millions, rows);
  return rows;
}

}  // namespace equilux
