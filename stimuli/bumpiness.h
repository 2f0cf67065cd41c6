// How bumpy a shape is: its normals against its radii, and its radius by spherical harmonics.
#pragma once

#include <array>
#include <cstddef>

#include "stimuli/mesh.h"

namespace equilux {

/// Octaves of degree: 1, 2-3, 4-7, 8-15, 16-31.
inline constexpr std::size_t kBumpBands = 5;

struct Bumpiness {
  /// Centroid of the volume: of a mesh with holes, as if cones to its area's centroid closed them. Of a
  /// sheet, which has no volume, its area's. units: m
  Vec3 center_m;
  double mean_radius_m = 0;  ///< of the outermost surface, over all directions from the centre
  double max_radius_m = 0;   ///< of the farthest vertex
  /// Angle between the shading normal and the radius from the centre, rms over the area.
  double rms_angle_degrees = 0;
  /// rms over all directions of the part of ln r, of the outermost surface, that is of these degrees.
  std::array<double, kBumpBands> rms_log_radius{};
  double open_share =
      0;  ///< of all directions from the centre, where no surface is; the spectrum's mean there
};

/// Does not depend on where the mesh stands, how large it is and how it is turned. A mesh without normals has
/// its faces'; one turned inside out counts as turned back.
/// source: spectrum by Gauss-Legendre quadrature, 128 x 256 directions.
Bumpiness measure_bumpiness(const TriangleMesh& mesh);

/// Volume by the divergence theorem, holes closed as for Bumpiness; negative where faces look inwards.
/// units: m^3
double measure_volume(const TriangleMesh& mesh);

}  // namespace equilux
