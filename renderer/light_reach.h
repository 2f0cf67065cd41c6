// Which lights may reach a place, by geometry alone: what surely is out of reach is left out.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "stimuli/scene.h"

namespace equilux {

struct Box {
  Vec3 low, high;
};

struct Sphere {
  Vec3 center;
  float radius = 0;
};

/// False only if no point of the sphere, the box or the mesh is in the spot's cone. Occluders are not asked.
bool may_reach(const SpotLight& spot, const Sphere& sphere);
bool may_reach(const SpotLight& spot, const Box& box);
bool may_reach(const SpotLight& spot, const TriangleMesh& mesh);

/// False only if the box lies behind the rectangle's plane.
bool may_reach(const RectangleLight& light, const Box& box);

/// Cells of a box, each with the spots that may reach it.
class SpotGrid {
 public:
  /// An empty one, of no spots.
  SpotGrid() = default;
  /// With `resolution` cells along each axis; 1 asks all that reach the box.
  SpotGrid(const std::vector<SpotLight>& spots, const Box& box, int resolution);

  /// Indices of spots, rising: every spot whose cone holds a p inside the box is among them.
  std::span<const std::uint32_t> at(Vec3 p) const;

  /// Of a cell. units: spots
  double mean_length() const;

 private:
  Vec3 low_, scale_;
  int resolution_ = 0;
  std::vector<std::uint32_t> firsts_;  // of each cell in lists_, and one more
  std::vector<std::uint32_t> lists_;
};

}  // namespace equilux
