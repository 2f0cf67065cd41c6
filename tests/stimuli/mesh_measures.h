// What closed forms are compared with: area, volume and edges of a triangle mesh, summed in double.
#pragma once

#include <array>
#include <map>
#include <numbers>

#include "stimuli/mesh.h"

namespace equilux {

using Double3 = std::array<double, 3>;

inline Double3 to_double(Vec3 v) { return {v.x, v.y, v.z}; }

inline Double3 cross_of(const Double3& a, const Double3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double dot_of(const Double3& a, const Double3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Twice the area, along the face's normal.
inline Double3 face_vector(const TriangleMesh& mesh, const std::array<std::uint32_t, 3>& triangle) {
  const Double3 a = to_double(mesh.positions[triangle[0]]), b = to_double(mesh.positions[triangle[1]]),
                c = to_double(mesh.positions[triangle[2]]);
  return cross_of({b[0] - a[0], b[1] - a[1], b[2] - a[2]}, {c[0] - a[0], c[1] - a[1], c[2] - a[2]});
}

inline double area_of(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& triangle : mesh.triangles) {
    const Double3 n = face_vector(mesh, triangle);
    area += std::sqrt(dot_of(n, n)) / 2;
  }
  return area;
}

/// By the divergence theorem; positive where faces look outwards.
inline double volume_of(const TriangleMesh& mesh) {
  double volume = 0;
  for (const auto& triangle : mesh.triangles)
    volume += dot_of(to_double(mesh.positions[triangle[0]]), face_vector(mesh, triangle)) / 6;
  return volume;
}

/// True where each directed edge occurs once and its reverse once: closed, and all faces on one side.
inline bool is_closed(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++edges[{triangle[i], triangle[(i + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    const auto reverse = edges.find({edge.second, edge.first});
    if (count != 1 || reverse == edges.end() || reverse->second != 1) return false;
  }
  return !edges.empty();
}

/// units: degrees
inline double angle_between(const Double3& a, const Double3& b) {
  const Double3 c = cross_of(a, b);
  return std::atan2(std::sqrt(dot_of(c, c)), dot_of(a, b)) * 180 / std::numbers::pi;
}

/// The largest angle between a vertex's normal and the area-weighted mean of its faces'. units: degrees
inline double largest_normal_error(const TriangleMesh& mesh) {
  std::vector<Double3> sums(mesh.positions.size(), Double3{});
  for (const auto& triangle : mesh.triangles) {
    const Double3 n = face_vector(mesh, triangle);
    for (std::uint32_t vertex : triangle) {
      for (std::size_t i = 0; i < 3; ++i) sums[vertex][i] += n[i];
    }
  }
  double largest = 0;
  for (std::size_t i = 0; i < sums.size(); ++i)
    largest = std::max(largest, angle_between(sums[i], to_double(mesh.normals[i])));
  return largest;
}

}  // namespace equilux
