// Quadrature over a mesh's area and over the directions from its centre.
#include "stimuli/bumpiness.h"

#include <bit>
#include <numbers>
#include <vector>

#include "base/error.h"

namespace equilux {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kRows = 128, kColumns = 256, kDegrees = 1u << kBumpBands;

struct Double3 {
  double x = 0, y = 0, z = 0;
};

Double3 to_double(Vec3 v) { return {v.x, v.y, v.z}; }
Double3 operator+(Double3 a, Double3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Double3 operator-(Double3 a, Double3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Double3 operator*(Double3 a, double s) { return {a.x * s, a.y * s, a.z * s}; }
double dot(Double3 a, Double3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Double3 cross(Double3 a, Double3 b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double length(Double3 a) { return std::sqrt(dot(a, a)); }
double angle_between(Double3 a, Double3 b) { return std::atan2(length(cross(a, b)), dot(a, b)); }

struct Corners {
  Double3 a, b, c;
};

Corners corners_of(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& triangle, Double3 from) {
  const auto at = [&](std::size_t i) { return to_double(mesh.positions[triangle[i]]) - from; };
  return {at(0), at(1), at(2)};
}

/// A sum of places with its weight.
struct Centroid {
  Double3 sum;
  double weight = 0;
  Double3 mean() const { return sum * (1 / weight); }
};

Centroid find_area_centroid(const TriangleMesh& mesh) {
  Centroid centroid;
  for (const auto& triangle : mesh.triangles) {
    const auto [a, b, c] = corners_of(mesh, triangle, {});
    const double area = length(cross(b - a, c - a)) / 2;
    centroid.sum = centroid.sum + (a + b + c) * (area / 3);
    centroid.weight += area;
  }
  return centroid;
}

// Of the tetrahedra between the triangles and a point.
Centroid find_volume_centroid(const TriangleMesh& mesh, Double3 from) {
  Centroid centroid;
  for (const auto& triangle : mesh.triangles) {
    const auto [a, b, c] = corners_of(mesh, triangle, from);
    const double volume = dot(a, cross(b, c)) / 6;
    centroid.sum = centroid.sum + (a + b + c) * (volume / 4) + from * volume;
    centroid.weight += volume;
  }
  return centroid;
}

struct Center {
  Double3 at;
  bool is_inside_out = false;
};

// Less volume than this share of that of the sphere of its area makes a sheet.
constexpr double kSheetVolume = 1e-3;

Center find_center(const TriangleMesh& mesh) {
  const Centroid area = find_area_centroid(mesh), volume = find_volume_centroid(mesh, area.mean());
  const double sphere = std::pow(area.weight, 1.5) / (6 * std::sqrt(kPi));
  if (std::abs(volume.weight) < kSheetVolume * sphere) return {area.mean()};
  return {volume.mean(), volume.weight < 0};
}

// Squared angle, mean over a triangle by the three-point rule of degree two.
double mean_squared_angle(const Corners& at, const Corners& normals) {
  double sum = 0;
  for (const auto& [u, v, w] : {std::array{4., 1., 1.}, {1., 4., 1.}, {1., 1., 4.}}) {
    const Double3 p = at.a * u + at.b * v + at.c * w, n = normals.a * u + normals.b * v + normals.c * w;
    sum += std::pow(angle_between(n, p), 2);
  }
  return sum / 3;
}

Corners normals_of(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& triangle, Double3 face) {
  if (mesh.normals.empty()) return {face, face, face};
  const auto at = [&](std::size_t i) { return to_double(mesh.normals[triangle[i]]); };
  return {at(0), at(1), at(2)};
}

// units: degrees
double measure_rms_angle(const TriangleMesh& mesh, const Center& center) {
  double sum = 0, area = 0;
  const double side = center.is_inside_out ? -1 : 1;
  for (const auto& triangle : mesh.triangles) {
    const Corners at = corners_of(mesh, triangle, center.at);
    const Double3 face = cross(at.b - at.a, at.c - at.a);
    auto [a, b, c] = normals_of(mesh, triangle, face);
    sum += mean_squared_angle(at, {a * side, b * side, c * side}) * length(face);
    area += length(face);
  }
  return std::sqrt(sum / area) * 180 / kPi;
}

// Nodes and weights of Gauss and Legendre on [-1, 1] by Newton's method.
struct GaussLegendre {
  std::vector<double> nodes, weights;
};

GaussLegendre make_gauss_legendre(unsigned count) {
  GaussLegendre rule;
  for (unsigned i = 0; i < count; ++i) {
    double x = std::cos(kPi * (i + .75) / (count + .5)), slope = 0;
    for (int step = 0; step < 10; ++step) {
      slope = count * (std::legendre(count - 1, x) - x * std::legendre(count, x)) / (1 - x * x);
      x -= std::legendre(count, x) / slope;
    }
    rule.nodes.push_back(x);
    rule.weights.push_back(2 / ((1 - x * x) * slope * slope));
  }
  return rule;
}

/// Distance of the outermost surface in each direction, zero where there is none. shape: kRows x kColumns
struct RadiusMap {
  const GaussLegendre& rule;
  std::vector<double> radii = std::vector<double>(kRows * kColumns);

  Double3 direction(std::size_t row, std::size_t column) const {
    const double z = rule.nodes[row], s = std::sqrt(1 - z * z), phi = 2 * kPi * double(column) / kColumns;
    return {s * std::cos(phi), s * std::sin(phi), z};
  }
};

// Distance along d from the origin to the triangle, 0 if it misses; edges belong to both their triangles.
double find_distance(const Corners& t, Double3 normal, Double3 d) {
  constexpr double kEdge = -1e-9;
  const double u = dot(d, cross(t.b, t.c)), v = dot(d, cross(t.c, t.a)), w = dot(d, cross(t.a, t.b));
  const double sum = u + v + w;
  if (!(std::abs(sum) > 0) || u / sum < kEdge || v / sum < kEdge || w / sum < kEdge) return 0;
  return std::max(0.0, dot(normal, t.a) / sum);
}

/// Directions around one: all that a triangle can be met in.
struct Cap {
  Double3 axis;
  double angle = kPi;
};

// A triangle near the centre, or around it, can be anywhere.
Cap find_cap(const Corners& t) {
  constexpr double kWidest = 1.4;
  const Double3 axis = t.a * (1 / length(t.a)) + t.b * (1 / length(t.b)) + t.c * (1 / length(t.c));
  const double angle =
      std::max({angle_between(axis, t.a), angle_between(axis, t.b), angle_between(axis, t.c)}) + 1e-6;
  return angle < kWidest ? Cap{axis, angle} : Cap{};
}

void add_row(RadiusMap& map, std::size_t row, const Cap& cap, const Corners& t, Double3 normal) {
  const double polar = std::atan2(std::hypot(cap.axis.x, cap.axis.y), cap.axis.z);
  const double sine = std::sin(cap.angle) / std::sin(polar);
  const bool has_pole = polar <= cap.angle || kPi - polar <= cap.angle || !(sine < 1);
  const double half = has_pole ? kColumns / 2. : std::asin(sine) / (2 * kPi) * kColumns + 1;
  const double middle = std::atan2(cap.axis.y, cap.axis.x) / (2 * kPi) * kColumns + kColumns;
  const auto first = static_cast<std::size_t>(std::max(0.0, middle - half));
  const auto count = std::min<std::size_t>(kColumns, static_cast<std::size_t>(2 * half) + 2);
  for (std::size_t i = first; i < first + count; ++i) {
    double& radius = map.radii[row * kColumns + i % kColumns];
    radius = std::max(radius, find_distance(t, normal, map.direction(row, i % kColumns)));
  }
}

void add_triangle(RadiusMap& map, const Corners& t) {
  const Double3 normal = cross(t.b - t.a, t.c - t.a);
  const Cap cap = find_cap(t);
  const double polar = std::atan2(std::hypot(cap.axis.x, cap.axis.y), cap.axis.z);
  for (std::size_t row = 0; row < kRows; ++row) {
    const double away = std::abs(std::acos(map.rule.nodes[row]) - polar);
    if (away <= cap.angle) add_row(map, row, cap, t, normal);
  }
}

/// ln r on the map's directions about its mean, and what else they give.
struct LogRadii {
  std::vector<double> values;  ///< zero in the open
  double mean_radius = 0, open_share = 0;
};

LogRadii find_log_radii(const RadiusMap& map) {
  LogRadii logs{map.radii};
  double weight = 0, sum = 0, radius_sum = 0;
  for (std::size_t i = 0; i < map.radii.size(); ++i) {
    const double share = map.rule.weights[i / kColumns] / (2 * kColumns);
    if (!(map.radii[i] > 0)) {
      logs.open_share += share;
      continue;
    }
    weight += share;
    sum += share * std::log(map.radii[i]);
    radius_sum += share * map.radii[i];
  }
  for (double& value : logs.values) value = value > 0 ? std::log(value) - sum / weight : 0;
  logs.mean_radius = weight > 0 ? radius_sum / weight : 0;
  return logs;
}

/// Of one order m: sums over phi for each row.
struct Waves {
  std::vector<double> cosines = std::vector<double>(kRows), sines = cosines;
};

Waves sum_waves(const std::vector<double>& values, std::size_t order) {
  Waves waves;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double phi = 2 * kPi * double(order * (i % kColumns) % kColumns) / kColumns;
    waves.cosines[i / kColumns] += values[i] * std::cos(phi) * (2 * kPi / kColumns);
    waves.sines[i / kColumns] += values[i] * std::sin(phi) * (2 * kPi / kColumns);
  }
  return waves;
}

// Squares of the coefficients at +m and -m of the real harmonics of one degree.
double find_power(const Waves& waves, unsigned degree, unsigned order, const GaussLegendre& rule) {
  double cosine = 0, sine = 0;
  for (std::size_t row = 0; row < kRows; ++row) {
    const double y = std::sph_legendre(degree, order, std::acos(rule.nodes[row])) * rule.weights[row];
    cosine += y * waves.cosines[row];
    sine += y * waves.sines[row];
  }
  return (cosine * cosine + sine * sine) * (order == 0 ? 1 : 2);
}

std::array<double, kBumpBands> measure_spectrum(const std::vector<double>& values,
                                                const GaussLegendre& rule) {
  std::array<double, kBumpBands> bands{};
  for (unsigned order = 0; order < kDegrees; ++order) {
    const Waves waves = sum_waves(values, order);
    for (unsigned degree = std::max(1u, order); degree < kDegrees; ++degree)
      bands[std::bit_width(degree) - 1u] += find_power(waves, degree, order, rule) / (4 * kPi);
  }
  for (double& band : bands) band = std::sqrt(band);
  return bands;
}

Vec3 to_vec(Double3 v) { return {float(v.x), float(v.y), float(v.z)}; }

}  // namespace

Bumpiness measure_bumpiness(const TriangleMesh& mesh) {
  EQ_CHECK(!mesh.triangles.empty());
  const Center center = find_center(mesh);
  Bumpiness bumpiness{to_vec(center.at)};
  for (Vec3 p : mesh.positions)
    bumpiness.max_radius_m = std::max(bumpiness.max_radius_m, length(to_double(p) - center.at));
  bumpiness.rms_angle_degrees = measure_rms_angle(mesh, center);
  const GaussLegendre rule = make_gauss_legendre(kRows);
  RadiusMap map{rule};
  for (const auto& triangle : mesh.triangles) add_triangle(map, corners_of(mesh, triangle, center.at));
  const LogRadii logs = find_log_radii(map);
  bumpiness.mean_radius_m = logs.mean_radius;
  bumpiness.open_share = logs.open_share;
  bumpiness.rms_log_radius = measure_spectrum(logs.values, rule);
  return bumpiness;
}

double measure_volume(const TriangleMesh& mesh) {
  return find_volume_centroid(mesh, find_area_centroid(mesh).mean()).weight;
}

}  // namespace equilux
