// Quads, boxes, lathes, sweeps, spheres, blobs and what is scattered over them.
#include "stimuli/generators.h"

#include <map>
#include <numbers>

#include "base/error.h"
#include "base/random.h"

namespace equilux {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;

// Two triangles for each cell of a grid of vertices of the given width; columns wrap around if `closed`.
void add_grid_triangles(TriangleMesh& mesh, std::uint32_t first, int rows, int columns, bool closed) {
  const auto at = [&](int row, int column) {
    return first + static_cast<std::uint32_t>(row * columns + column % columns);
  };
  for (int row = 0; row + 1 < rows; ++row) {
    for (int column = 0; column + (closed ? 0 : 1) < columns; ++column) {
      const auto a = at(row, column), b = at(row, column + 1), c = at(row + 1, column + 1),
                 d = at(row + 1, column);
      if (mesh.positions[a] != mesh.positions[b]) mesh.triangles.push_back({a, b, c});
      if (mesh.positions[c] != mesh.positions[d]) mesh.triangles.push_back({a, c, d});
    }
  }
}

using Point2 = std::array<float, 2>;

Point2 segment_normal(const Point2& from, const Point2& to) {
  const float dr = to[0] - from[0], dz = to[1] - from[1];
  const float size = std::hypot(dr, dz);
  return {dz / size, -dr / size};
}

// One band of a lathe between two neighbouring profile points, with the normals (in the profile's plane) at
// both.
void add_band(TriangleMesh& mesh, const Point2& from, const Point2& to, const Point2& normal_from,
              const Point2& normal_to, int segments) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const auto& [point, normal] : {std::pair(from, normal_from), std::pair(to, normal_to)}) {
    for (int i = 0; i < segments; ++i) {
      const float angle = 2 * kPi * static_cast<float>(i) / static_cast<float>(segments);
      const float c = std::cos(angle), s = std::sin(angle);
      mesh.positions.push_back({point[0] * c, point[0] * s, point[1]});
      mesh.normals.push_back(normalize({normal[0] * c, normal[0] * s, normal[1]}));
    }
  }
  add_grid_triangles(mesh, first, 2, segments, true);
}

Vec3 catmull_rom(const std::vector<Vec3>& points, std::size_t span, float t) {
  const auto at = [&](std::ptrdiff_t i) {
    return points[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i, 0, std::ssize(points) - 1))];
  };
  const auto i = static_cast<std::ptrdiff_t>(span);
  const Vec3 a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
  return 0.5f * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * (t * t) +
                 (3 * b - a - 3 * c + d) * (t * t * t));
}

struct Icosphere {
  std::vector<Vec3> directions;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

Icosphere make_icosahedron() {
  const float g = std::numbers::phi_v<float>;
  Icosphere sphere;
  for (Vec3 v : {Vec3{-1, g, 0},
                 {1, g, 0},
                 {-1, -g, 0},
                 {1, -g, 0},
                 {0, -1, g},
                 {0, 1, g},
                 {0, -1, -g},
                 {0, 1, -g},
                 {g, 0, -1},
                 {g, 0, 1},
                 {-g, 0, -1},
                 {-g, 0, 1}}) {
    sphere.directions.push_back(normalize(v));
  }
  sphere.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  return sphere;
}

Icosphere subdivide(const Icosphere& coarse) {
  Icosphere fine{coarse.directions, {}};
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t a, std::uint32_t b) {
    const auto [found, added] =
        middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(fine.directions.size()));
    if (added) fine.directions.push_back(normalize(fine.directions[a] + fine.directions[b]));
    return found->second;
  };
  for (const auto& [a, b, c] : coarse.triangles) {
    const auto ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    fine.triangles.insert(fine.triangles.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
  }
  return fine;
}

Icosphere make_icosphere(int subdivisions) {
  EQ_CHECK(subdivisions >= 0 && subdivisions <= 8, subdivisions);
  Icosphere sphere = make_icosahedron();
  for (int i = 0; i < subdivisions; ++i) sphere = subdivide(sphere);
  return sphere;
}

// A band of plane waves on the sphere, of unit variance over its phases.
class WaveNoise {
 public:
  WaveNoise(std::uint64_t seed, float frequency) {
    RandomStream random(seed, "blob", 0);
    for (int i = 0; i < kWaves; ++i) {
      const double z = 2 * random.next_double() - 1, angle = 2 * std::numbers::pi * random.next_double();
      const double r = std::sqrt(1 - z * z), size = frequency * (0.6 + 0.8 * random.next_double());
      waves_.push_back({{size * r * std::cos(angle), size * r * std::sin(angle), size * z},
                        2 * std::numbers::pi * random.next_double()});
    }
  }

  struct Sample {
    double value;
    std::array<double, 3> gradient;
  };
  Sample eval(Vec3 d) const {
    Sample sample{0, {0, 0, 0}};
    const double scale = std::sqrt(2.0 / kWaves);
    for (const Wave& wave : waves_) {
      const double phase = wave.k[0] * d.x + wave.k[1] * d.y + wave.k[2] * d.z + wave.phase;
      sample.value += scale * std::cos(phase);
      for (std::size_t j = 0; j < 3; ++j) sample.gradient[j] -= scale * std::sin(phase) * wave.k[j];
    }
    return sample;
  }

 private:
  static constexpr int kWaves = 48;
  struct Wave {
    std::array<double, 3> k;
    double phase;
  };
  std::vector<Wave> waves_;
};

// Triangles of a mesh by area.
class FaceDistribution {
 public:
  explicit FaceDistribution(const TriangleMesh& mesh) : mesh_(mesh) {
    double sum = 0;
    for (const auto& triangle : mesh.triangles) sums_.push_back(sum += area_of(triangle));
    EQ_CHECK(sum > 0, mesh.triangles.size());
  }

  struct Sample {
    Vec3 p, normal;
  };
  Sample draw(RandomStream& random) const {
    const auto found = std::upper_bound(sums_.begin(), sums_.end(), random.next_double() * sums_.back());
    const auto i = static_cast<std::size_t>(std::min(found, sums_.end() - 1) - sums_.begin());
    const auto& [a, b, c] = mesh_.triangles[i];
    const float root = std::sqrt(random.next_float()), v = random.next_float();
    const Vec3 p = mesh_.positions[a] * (1 - root) + mesh_.positions[b] * (root * (1 - v)) +
                   mesh_.positions[c] * (root * v);
    return {p, normal_of(mesh_.triangles[i])};
  }

 private:
  Vec3 normal_of(const std::array<std::uint32_t, 3>& triangle) const {
    const Vec3 a = mesh_.positions[triangle[0]];
    return normalize(
        cross(normalize(mesh_.positions[triangle[1]] - a), normalize(mesh_.positions[triangle[2]] - a)));
  }

  // In double: the square of an edge of a tenth of a nanometre leaves float.
  double area_of(const std::array<std::uint32_t, 3>& triangle) const {
    const Vec3 a = mesh_.positions[triangle[0]];
    const Vec3 u = mesh_.positions[triangle[1]] - a, v = mesh_.positions[triangle[2]] - a;
    const double x = double{u.y} * v.z - double{u.z} * v.y, y = double{u.z} * v.x - double{u.x} * v.z,
                 z = double{u.x} * v.y - double{u.y} * v.x;
    return std::sqrt(x * x + y * y + z * z);
  }

  const TriangleMesh& mesh_;
  std::vector<double> sums_;
};

// +z along `normal`, leaning by `lean`, both turned by angles drawn from `random`. units: radians
Frame draw_frame(Vec3 normal, float lean, RandomStream& random) {
  const float towards = 2 * kPi * random.next_float(), spin = 2 * kPi * random.next_float();
  const float by = lean * random.next_float();
  Frame frame(Frame(normal).to_world(
      {std::sin(by) * std::cos(towards), std::sin(by) * std::sin(towards), std::cos(by)}));
  const Vec3 s = frame.s * std::cos(spin) + frame.t * std::sin(spin);
  frame.t = cross(frame.n, s);
  frame.s = s;
  return frame;
}

}  // namespace

TriangleMesh make_quad(Vec3 u, Vec3 v) { return {{{0, 0, 0}, u, u + v, v}, {}, {{0, 1, 2}, {0, 2, 3}}}; }

TriangleMesh make_box(Vec3 size) {
  const float x = size.x / 2, y = size.y / 2, z = size.z;
  return {{{-x, -y, 0}, {x, -y, 0}, {x, y, 0}, {-x, y, 0}, {-x, -y, z}, {x, -y, z}, {x, y, z}, {-x, y, z}},
          {},
          {{0, 2, 1},
           {0, 3, 2},
           {4, 5, 6},
           {4, 6, 7},
           {0, 1, 5},
           {0, 5, 4},
           {1, 2, 6},
           {1, 6, 5},
           {2, 3, 7},
           {2, 7, 6},
           {3, 0, 4},
           {3, 4, 7}}};
}

TriangleMesh make_lathe(const std::vector<Point2>& profile, int segments) {
  EQ_CHECK(profile.size() >= 2 && segments >= 3, profile.size(), segments);
  std::vector<Point2> normals;
  for (std::size_t i = 0; i + 1 < profile.size(); ++i)
    normals.push_back(segment_normal(profile[i], profile[i + 1]));
  const auto joint = [&](std::size_t i, std::size_t other) -> Point2 {
    const Point2 &a = normals[i], &b = normals[other];
    const bool smooth = a[0] * b[0] + a[1] * b[1] > 0.82f;
    return smooth ? Point2{a[0] + b[0], a[1] + b[1]} : a;
  };
  TriangleMesh mesh;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    add_band(mesh, profile[i], profile[i + 1], joint(i, i > 0 ? i - 1 : i),
             joint(i, i + 1 < normals.size() ? i + 1 : i), segments);
  }
  return mesh;
}

TriangleMesh make_sweep(const std::vector<Vec3>& points, float radius, int segments, int steps_per_span) {
  EQ_CHECK(points.size() >= 2 && segments >= 3 && steps_per_span >= 1, points.size(), segments,
           steps_per_span);
  std::vector<Vec3> curve;
  for (std::size_t span = 0; span + 1 < points.size(); ++span) {
    for (int step = 0; step < steps_per_span; ++step) {
      curve.push_back(
          catmull_rom(points, span, static_cast<float>(step) / static_cast<float>(steps_per_span)));
    }
  }
  curve.push_back(points.back());
  TriangleMesh mesh;
  Vec3 side = Frame(normalize(curve[1] - curve[0])).s;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Vec3 tangent = normalize(curve[std::min(i + 1, curve.size() - 1)] - curve[i > 0 ? i - 1 : 0]);
    side = normalize(side - tangent * dot(side, tangent));
    const Vec3 up = cross(tangent, side);
    for (int j = 0; j < segments; ++j) {
      const float angle = 2 * kPi * static_cast<float>(j) / static_cast<float>(segments);
      const Vec3 normal = side * std::cos(angle) + up * std::sin(angle);
      mesh.positions.push_back(curve[i] + normal * radius);
      mesh.normals.push_back(normal);
    }
  }
  add_grid_triangles(mesh, 0, static_cast<int>(curve.size()), segments, true);
  return mesh;
}

TriangleMesh make_sphere(float radius, int subdivisions) {
  const Icosphere sphere = make_icosphere(subdivisions);
  TriangleMesh mesh;
  mesh.normals = sphere.directions;
  mesh.triangles = sphere.triangles;
  for (Vec3 direction : sphere.directions) mesh.positions.push_back(direction * radius);
  return mesh;
}

TriangleMesh make_blob(const BlobParams& params) {
  const Icosphere sphere = make_icosphere(params.subdivisions);
  const WaveNoise noise(params.seed, params.frequency);
  TriangleMesh mesh;
  mesh.triangles = sphere.triangles;
  for (Vec3 d : sphere.directions) {
    const auto [value, gradient] = noise.eval(d);
    const double r = params.radius * std::exp(params.amplitude * value);
    mesh.positions.push_back(d * static_cast<float>(r));
    // For a star-shaped surface p = r(d) d the normal is along r d - grad r, grad tangential to the unit
    // sphere.
    const Vec3 slope = Vec3{static_cast<float>(gradient[0]), static_cast<float>(gradient[1]),
                            static_cast<float>(gradient[2])} *
                       params.amplitude;
    mesh.normals.push_back(normalize(d - (slope - d * dot(slope, d))));
  }
  return mesh;
}

TriangleMesh make_scatter(const TriangleMesh& part, const TriangleMesh& over, const ScatterParams& params) {
  const FaceDistribution faces(over);
  TriangleMesh mesh;
  for (int i = 0; i < params.count; ++i) {
    RandomStream random(params.seed, "scatter", static_cast<std::uint64_t>(i));
    const auto [p, normal] = faces.draw(random);
    const Frame frame = draw_frame(normal, params.lean_degrees * kPi / 180, random);
    const float scale =
        params.smallest_scale + (params.largest_scale - params.smallest_scale) * random.next_float();
    TriangleMesh copy = part;
    for (Vec3& q : copy.positions) q = frame.to_world(q * scale) + p;
    for (Vec3& n : copy.normals) n = frame.to_world(n);
    append_mesh(mesh, copy);
  }
  return mesh;
}

}  // namespace equilux
