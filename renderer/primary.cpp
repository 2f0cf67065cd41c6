// Camera rays.
#include "renderer/primary.h"

#include <numbers>

#include "renderer/parallel.h"

namespace equilux {
namespace {

float reversed_bits(std::uint32_t value) {
  std::uint32_t reversed = 0;
  for (int i = 0; i < 32; ++i) reversed |= ((value >> i) & 1u) << (31 - i);
  return static_cast<float>(reversed) * 0x1p-32f;
}

struct CameraFrame {
  Vec3 forward, right, up;
  float half_height;
};

CameraFrame make_frame(const Camera& camera) {
  const Vec3 forward = normalize(camera.target - camera.position);
  const Vec3 right = normalize(cross(forward, camera.up));
  return {forward, right, cross(right, forward),
          std::tan(camera.vertical_fov_degrees * std::numbers::pi_v<float> / 360)};
}

PrimaryHit trace_one(const World& world, Vec3 origin, Vec3 direction) {
  const auto point = world.intersect(origin, direction);
  if (!point) return {};
  return {point->is_object() ? PrimaryKind::kObject : PrimaryKind::kRoom, *point, -direction};
}

}  // namespace

std::vector<std::array<float, 2>> make_subpixel_positions(int count) {
  std::vector<std::array<float, 2>> positions;
  const auto n = static_cast<float>(count);
  for (int i = 0; i < count; ++i) {
    positions.push_back(
        {(static_cast<float>(i) + 0.5f) / n, reversed_bits(static_cast<std::uint32_t>(i)) + 0.5f / n});
  }
  // Where count is no power of two the second coordinate's cells differ in size; they stay within the pixel
  // all the same.
  for (auto& position : positions) position[1] = std::min(position[1], 1 - 0.5f / n);
  return positions;
}

Primary trace_primary(const World& world, const Camera& camera, int width, int height, int positions) {
  const CameraFrame frame = make_frame(camera);
  const auto offsets = make_subpixel_positions(positions);
  Primary primary{width, height, positions, {}};
  primary.hits.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * offsets.size());
  for_each_parallel(static_cast<std::size_t>(height), [&](std::size_t y) {
    PrimaryHit* hit = &primary.hits[y * static_cast<std::size_t>(width) * offsets.size()];
    for (int x = 0; x < width; ++x) {
      for (const auto& offset : offsets) {
        const float sx = (2 * (static_cast<float>(x) + offset[0]) - static_cast<float>(width)) /
                         static_cast<float>(height);
        const float sy = 1 - 2 * (static_cast<float>(y) + offset[1]) / static_cast<float>(height);
        const Vec3 direction = normalize(frame.forward + frame.right * (sx * frame.half_height) +
                                         frame.up * (sy * frame.half_height));
        *hit++ = trace_one(world, camera.position, direction);
      }
    }
  });
  return primary;
}

Primary isolate_object(const Primary& primary, std::int32_t object) {
  Primary alone = primary;
  for (PrimaryHit& hit : alone.hits) {
    if (hit.kind != PrimaryKind::kObject || hit.point.object != object) hit.kind = PrimaryKind::kHidden;
  }
  return alone;
}

HdrImage make_coverage(const Primary& primary) {
  HdrImage coverage(primary.width, primary.height, 1);
  for (std::size_t pixel = 0; pixel < coverage.pixel_count(); ++pixel) {
    int seen = 0;
    for (int i = 0; i < primary.positions; ++i) seen += primary.at(pixel, i).kind == PrimaryKind::kObject;
    coverage.values[pixel] = static_cast<float>(seen) / static_cast<float>(primary.positions);
  }
  return coverage;
}

}  // namespace equilux
