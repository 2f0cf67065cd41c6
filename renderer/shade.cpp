// What goes into the plain sum and what comes out.
#include "renderer/shade.h"

#include <algorithm>
#include <map>

#include "base/error.h"
#include "renderer/kernels.h"

namespace equilux {
namespace {

std::uint64_t morton(std::uint32_t x, std::uint32_t y) {
  std::uint64_t code = 0;
  for (unsigned bit = 0; bit < 16; ++bit) {
    code |= std::uint64_t{(x >> bit) & 1u} << (2 * bit) | std::uint64_t{(y >> bit) & 1u} << (2 * bit + 1);
  }
  return code;
}

// Pixels in the order of a Morton curve.
std::vector<std::uint32_t> order_pixels(const Primary& primary) {
  const auto width = static_cast<std::uint32_t>(primary.width),
             height = static_cast<std::uint32_t>(primary.height);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> order;
  for (std::uint32_t y = 0; y < height; ++y) {
    for (std::uint32_t x = 0; x < width; ++x) order.emplace_back(morton(x, y), y * width + x);
  }
  std::sort(order.begin(), order.end());
  std::vector<std::uint32_t> pixels;
  for (const auto& [code, pixel] : order) pixels.push_back(pixel);
  return pixels;
}

}  // namespace

std::vector<ShadingPoint> find_shading_points(const Primary& primary, std::int32_t object) {
  std::vector<ShadingPoint> points;
  for (const std::uint32_t pixel : order_pixels(primary)) {
    for (int position = 0; position < primary.positions; ++position) {
      const PrimaryHit& hit = primary.at(pixel, position);
      if (hit.kind == PrimaryKind::kObject && hit.point.object == object)
        points.push_back({pixel, hit.point, hit.v});
    }
  }
  return points;
}

std::vector<std::vector<ShadingPoint>> find_room_points(const Primary& primary, const HdrImage& coverage) {
  std::map<std::uint32_t, std::vector<ShadingPoint>> by_material;
  for (const std::uint32_t pixel : order_pixels(primary)) {
    if (coverage.values[pixel] > 0) continue;
    for (int position = 0; position < primary.positions; ++position) {
      const PrimaryHit& hit = primary.at(pixel, position);
      if (hit.is_room_surface()) by_material[hit.point.material].push_back({pixel, hit.point, hit.v});
    }
  }
  std::vector<std::vector<ShadingPoint>> points;
  for (auto& [material, some] : by_material) points.push_back(std::move(some));
  return points;
}

ShadedPoints shade_all_vpls(const World& world, const std::vector<ShadingPoint>& points, const VplList& vpls,
                            const std::vector<Material>& materials, const std::vector<double>& clamps_per_m2,
                            const std::function<void(double)>& progress, const ShadowRoulette& roulette) {
  const auto shade = current_isa() == Isa::kV4 ? &v4::shade_all_vpls : &v3::shade_all_vpls;
  return shade(world, points, vpls, materials, clamps_per_m2, progress, roulette);
}

ShadedPoints look_up(const HdrImage& image, const std::vector<ShadingPoint>& points) {
  ShadedPoints found{1, points.size(), {}};
  for (const ShadingPoint& point : points) {
    const float* p = image.pixel(point.pixel);
    found.radiance.push_back({p[0], p[1], p[2]});
  }
  return found;
}

void check_finite(const ShadedPoints& shaded) {
  const auto bad =
      std::count_if(shaded.radiance.begin(), shaded.radiance.end(), [](Vec3 v) { return !is_finite(v); });
  if (bad > 0)
    throw InputError("VPL shading", "", "finite radiance at every point",
                     fmt::format("{} that are not", bad));
}

void add_to_layer(const ShadedPoints& shaded, std::size_t material, std::size_t level,
                  const std::vector<ShadingPoint>& points, int positions, HdrImage& layer) {
  const float share = 1.0f / static_cast<float>(positions);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 radiance = shaded.radiance[shaded.index(material, level, i)] * share;
    float* pixel = layer.pixel(points[i].pixel);
    pixel[0] += radiance.x;
    pixel[1] += radiance.y;
    pixel[2] += radiance.z;
  }
}

}  // namespace equilux
