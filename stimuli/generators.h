// Our own shapes, named for how they are made. Up is +z; units are metres; all face outwards.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "stimuli/mesh.h"

namespace equilux {

/// A parallelogram with one corner at the origin; its front is on the side of cross(u, v).
TriangleMesh make_quad(Vec3 u, Vec3 v);

/// An axis-aligned box standing on z = 0, centred in x and y.
TriangleMesh make_box(Vec3 size);

/// A profile of (radius, height) points turned around the z axis; smooth along the profile where its bends
/// are under 35 degrees.
TriangleMesh make_lathe(const std::vector<std::array<float, 2>>& profile, int segments);

/// A round tube along a curve: Catmull-Rom through the points.
TriangleMesh make_sweep(const std::vector<Vec3>& points, float radius, int segments, int steps_per_span);

/// True if a closed outline neither meets nor touches itself and has an area.
bool is_simple_outline(const std::vector<std::array<float, 2>>& outline);

/// A closed outline in the plane z = 0, drawn up to `height`; convex or not, in either sense of rotation.
/// Its side is smooth where it bends by under 35 degrees.
TriangleMesh make_extrude(std::vector<std::array<float, 2>> outline, float height);

/// A sphere about the origin with exact normals: an icosahedron subdivided.
TriangleMesh make_sphere(float radius, int subdivisions);

/// A smooth star-shaped blob about the origin: r(d) = radius exp(amplitude n(d)), n a band of plane waves of
/// unit variance with wave numbers around `frequency` (bumps per radian times 2 pi), drawn from `seed`.
/// Normals are exact.
struct BlobParams {
  float radius = 0.45f;
  float amplitude = 0.1f;
  float frequency = 5;
  std::uint64_t seed = 1;
  int subdivisions = 6;
};
TriangleMesh make_blob(const BlobParams& params);

/// Copies of `part` on `over`, which itself is left out: at points drawn evenly by area, the part's +z along
/// the face's normal but for a lean drawn up to `lean_degrees`, turned about it and scaled at random. A
/// function of the seed: the first copies stay where they are when the count grows.
struct ScatterParams {
  int count = 100;
  std::uint64_t seed = 1;
  float smallest_scale = 1;
  float largest_scale = 1;
  float lean_degrees = 0;
};
TriangleMesh make_scatter(const TriangleMesh& part, const TriangleMesh& over, const ScatterParams& params);

}  // namespace equilux
