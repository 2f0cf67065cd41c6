// Cones against the spheres around boxes.
#include "renderer/light_reach.h"

#include <algorithm>
#include <cmath>

#include "renderer/lights.h"
#include "renderer/parallel.h"
#include "renderer/world.h"

namespace equilux {
namespace {

// Far above what rounding does to the path tracer's own test of the cone.
constexpr double kMarginRadians = 2e-3;
// Around a sphere that rounding may have made too small; far from the origin what is rounded are coordinates.
constexpr float kMarginOfRadius = 1.0002f;

float find_largest(Vec3 p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); }

Sphere make_sphere(Vec3 center, float radius) {
  return {center, kMarginOfRadius * radius + rounding_bound(find_largest(center) + radius)};
}

// Of a cell's size: rounding may put a point into the neighbouring cell.
constexpr float kMarginOfCell = 1e-3f;

Box make_cell(const Box& box, int resolution, std::size_t index) {
  const auto n = static_cast<std::size_t>(resolution);
  const Vec3 size = (box.high - box.low) * (1.0f / static_cast<float>(resolution));
  const Vec3 place{static_cast<float>(index % n), static_cast<float>(index / n % n),
                   static_cast<float>(index / n / n)};
  const Vec3 low = box.low + size * place;
  return {low - size * kMarginOfCell, low + size * (1 + kMarginOfCell)};
}

float invert(float extent) { return extent > 0 ? 1 / extent : 0; }

int cell_of(float coordinate, int resolution) {
  const float clamped = std::clamp(coordinate, 0.0f, static_cast<float>(resolution - 1));
  return static_cast<int>(clamped);
}

}  // namespace

bool may_reach(const SpotLight& spot, const Sphere& sphere) {
  const double radius = sphere.radius;
  const Vec3 d = sphere.center - spot.position;
  const double distance = length(d);
  if (!(distance > radius)) return true;
  const double cosine = std::clamp(double{dot(spot.direction, d)} / distance, -1.0, 1.0);
  const double outer = std::acos(std::clamp(double{spot.cos_outer}, -1.0, 1.0));
  return std::acos(cosine) - std::asin(radius / distance) <= outer + kMarginRadians;
}

bool may_reach(const SpotLight& spot, const Box& box) {
  return may_reach(spot, make_sphere((box.low + box.high) * 0.5f, 0.5f * length(box.high - box.low)));
}

bool may_reach(const SpotLight& spot, const TriangleMesh& mesh) {
  return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& triangle) {
    const Vec3 a = mesh.positions[triangle[0]], b = mesh.positions[triangle[1]],
               c = mesh.positions[triangle[2]];
    const Vec3 center = (a + b + c) * (1.0f / 3);
    const float radius = std::max({length(a - center), length(b - center), length(c - center)});
    return may_reach(spot, make_sphere(center, radius));
  });
}

bool may_reach(const RectangleLight& light, const Box& box) {
  const Vec3 n = rectangle_normal(light);
  const Vec3 farthest{n.x > 0 ? box.high.x : box.low.x, n.y > 0 ? box.high.y : box.low.y,
                      n.z > 0 ? box.high.z : box.low.z};
  // The rounding of the dot product grows with the distance.
  const Vec3 d = farthest - light.corner;
  return dot(n, d) > -(rectangle_epsilon(light) + rounding_bound(length(d) + length(farthest)));
}

SpotGrid::SpotGrid(const std::vector<SpotLight>& spots, const Box& box, int resolution)
    : low_(box.low), resolution_(resolution) {
  const Vec3 extent = box.high - box.low;
  scale_ = Vec3{invert(extent.x), invert(extent.y), invert(extent.z)} * static_cast<float>(resolution);
  const auto n = static_cast<std::size_t>(resolution);
  std::vector<std::vector<std::uint32_t>> cells(n * n * n);
  for_each_parallel(cells.size(), [&](std::size_t index) {
    const Box cell = make_cell(box, resolution, index);
    for (std::size_t i = 0; i < spots.size(); ++i) {
      if (may_reach(spots[i], cell)) cells[index].push_back(static_cast<std::uint32_t>(i));
    }
  });
  for (const auto& cell : cells) {
    firsts_.push_back(static_cast<std::uint32_t>(lists_.size()));
    lists_.insert(lists_.end(), cell.begin(), cell.end());
  }
  firsts_.push_back(static_cast<std::uint32_t>(lists_.size()));
}

std::span<const std::uint32_t> SpotGrid::at(Vec3 p) const {
  if (lists_.empty()) return {};
  const Vec3 place = (p - low_) * scale_;
  const auto index = static_cast<std::size_t>(
      (cell_of(place.z, resolution_) * resolution_ + cell_of(place.y, resolution_)) * resolution_ +
      cell_of(place.x, resolution_));
  return {lists_.data() + firsts_[index], firsts_[index + 1] - firsts_[index]};
}

double SpotGrid::mean_length() const {
  return firsts_.size() < 2 ? 0
                            : static_cast<double>(lists_.size()) / static_cast<double>(firsts_.size() - 1);
}

}  // namespace equilux
