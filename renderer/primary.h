// What the camera sees through each subpixel position: made once for a geometry and view, shared by all its
// layers.
#pragma once

#include <array>
#include <vector>

#include "renderer/world.h"
#include "stimuli/image.h"

namespace equilux {

/// kHidden: left out of this picture's layers.
enum class PrimaryKind : std::uint8_t { kNothing, kObject, kRoom, kHidden };

struct PrimaryHit {
  PrimaryKind kind = PrimaryKind::kNothing;
  SurfacePoint point;
  Vec3 v;  ///< towards the camera

  /// Of the room, and no light.
  bool is_room_surface() const { return kind == PrimaryKind::kRoom && point.emitter < 0; }
};

/// shape: hits is height x width x positions.
struct Primary {
  int width = 0;
  int height = 0;
  int positions = 0;
  std::vector<PrimaryHit> hits;

  const PrimaryHit& at(std::size_t pixel, int position) const {
    return hits[pixel * static_cast<std::size_t>(positions) + static_cast<std::size_t>(position)];
  }
};

/// The fixed set of subpixel positions: Hammersley points in the unit square, the centre alone for one.
std::vector<std::array<float, 2>> make_subpixel_positions(int count);

Primary trace_primary(const World& world, const Camera& camera, int width, int height, int positions);

/// What is seen of one object; all else is hidden. Layers of it are those of the whole picture: random
/// numbers belong to the place.
Primary isolate_object(const Primary& primary, std::int32_t object);

/// Share of the positions at which the object is seen. shape: height x width x 1
HdrImage make_coverage(const Primary& primary);

}  // namespace equilux
