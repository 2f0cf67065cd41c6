// Outlines drawn up to solids: mouldings, boards, leaves.
#include <algorithm>

#include "base/error.h"
#include "stimuli/generators.h"
#include "stimuli/outline.h"

namespace equilux {
namespace {

constexpr float kCosSmooth = 0.82f;  // of 35 degrees

bool is_between(const Point2& p, const Point2& a, const Point2& b) {
  return std::min(a[0], b[0]) <= p[0] && p[0] <= std::max(a[0], b[0]) && std::min(a[1], b[1]) <= p[1] &&
         p[1] <= std::max(a[1], b[1]);
}

bool meet(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const double abc = turn_of(a, b, c), abd = turn_of(a, b, d), cda = turn_of(c, d, a), cdb = turn_of(c, d, b);
  if (abc * abd < 0 && cda * cdb < 0) return true;
  return (abc == 0 && is_between(c, a, b)) || (abd == 0 && is_between(d, a, b)) ||
         (cda == 0 && is_between(a, c, d)) || (cdb == 0 && is_between(b, c, d));
}

Point2 edge_normal(const Point2& from, const Point2& to) {
  const float dx = to[0] - from[0], dy = to[1] - from[1], size = std::hypot(dx, dy);
  return {dy / size, -dx / size};
}

Vec3 joint_normal(const Point2& own, const Point2& other) {
  const bool smooth = own[0] * other[0] + own[1] * other[1] > kCosSmooth;
  return smooth ? normalize({own[0] + other[0], own[1] + other[1], 0}) : Vec3{own[0], own[1], 0};
}

void add_sides(TriangleMesh& mesh, const std::vector<Point2>& outline, float height) {
  const std::size_t n = outline.size();
  const auto normal = [&](std::size_t i) { return edge_normal(outline[i % n], outline[(i + 1) % n]); };
  for (std::size_t i = 0; i < n; ++i) {
    const Point2 &a = outline[i], &b = outline[(i + 1) % n];
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(),
                          {{a[0], a[1], 0}, {b[0], b[1], 0}, {b[0], b[1], height}, {a[0], a[1], height}});
    const Vec3 at_a = joint_normal(normal(i), normal(i + n - 1)),
               at_b = joint_normal(normal(i), normal(i + 1));
    mesh.normals.insert(mesh.normals.end(), {at_a, at_b, at_b, at_a});
    mesh.triangles.insert(mesh.triangles.end(),
                          {{first, first + 1, first + 2}, {first, first + 2, first + 3}});
  }
}

void add_cap(TriangleMesh& mesh, const std::vector<Point2>& outline, const Triangles& triangles, float z,
             bool upwards) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const Point2& p : outline) {
    mesh.positions.push_back({p[0], p[1], z});
    mesh.normals.push_back({0, 0, upwards ? 1.0f : -1.0f});
  }
  for (const auto& [a, b, c] : triangles) {
    if (upwards) {
      mesh.triangles.push_back({first + a, first + b, first + c});
    } else {
      mesh.triangles.push_back({first + a, first + c, first + b});
    }
  }
}

}  // namespace

bool is_simple_outline(const std::vector<Point2>& outline) {
  const std::size_t n = outline.size();
  if (n < 3 || signed_area(outline) == 0) return false;
  for (std::size_t i = 0; i < n; ++i) {
    if (outline[i] == outline[(i + 1) % n]) return false;
    for (std::size_t j = i + 2; j < n; ++j) {
      const bool neighbours = i == 0 && j == n - 1;
      if (!neighbours && meet(outline[i], outline[i + 1], outline[j], outline[(j + 1) % n])) return false;
    }
  }
  return true;
}

TriangleMesh make_extrude(std::vector<Point2> outline, float height) {
  EQ_CHECK(is_simple_outline(outline) && height > 0, outline.size(), height);
  if (signed_area(outline) < 0) std::reverse(outline.begin(), outline.end());
  const auto triangles = triangulate(outline);
  EQ_CHECK(triangles, outline.size());
  TriangleMesh mesh;
  add_sides(mesh, outline, height);
  add_cap(mesh, outline, *triangles, 0, false);
  add_cap(mesh, outline, *triangles, height, true);
  return mesh;
}

}  // namespace equilux
