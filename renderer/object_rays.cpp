// Sampling of the object's area; shadow, cosine and mirror rays.
#include "renderer/object_rays.h"

#include <algorithm>
#include <numeric>

#include "base/error.h"
#include "base/random.h"
#include "renderer/lights.h"
#include "renderer/material.h"
#include "renderer/parallel.h"
#include "stimuli/bumpiness.h"

namespace equilux {
namespace {

constexpr std::size_t kBlock = 256;

Vec3 face_vector(const TriangleMesh& mesh, std::size_t triangle) {
  const auto [a, b, c] = mesh.triangles[triangle];
  return cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
}

std::vector<double> sum_areas(const TriangleMesh& mesh) {
  std::vector<double> sums;
  double sum = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    sums.push_back(sum += double(length(face_vector(mesh, i))));
  return sums;
}

AreaPoint sample_triangle(const TriangleMesh& mesh, std::size_t triangle, float u1, float u2) {
  const auto [i, j, k] = mesh.triangles[triangle];
  const Vec3 a = mesh.positions[i], b = mesh.positions[j], c = mesh.positions[k];
  const float root = std::sqrt(u1);
  float largest = 0;
  for (Vec3 p : {a, b, c}) largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  return {a * (1 - root) + b * (root * (1 - u2)) + c * (root * u2), normalize(face_vector(mesh, triangle)),
          rounding_bound(largest)};
}

// The point's origin on the side of a direction.
Vec3 origin_towards(const AreaPoint& point, Vec3 direction) {
  return point.p + point.ng * (dot(point.ng, direction) < 0 ? -point.epsilon : point.epsilon);
}

bool meets_object(const std::optional<SurfacePoint>& hit) { return hit && hit->is_object(); }

bool is_lit_by_spot(const World& world, const AreaPoint& point, const SpotLight& spot) {
  const Vec3 d = spot.position - point.p;
  return eval_spot(spot, -normalize(d)) != Vec3{} &&
         !world.is_occluded(origin_towards(point, d), spot.position);
}

bool is_lit_by_rectangle(const World& world, const AreaPoint& point, const RectangleLight& light,
                         RandomStream& random) {
  constexpr int kSide = 4;
  static_assert(kSide * kSide == kRaysPerPoint);
  if (light.radiance_w_per_m2_sr == Vec3{}) return false;
  for (int i = 0; i < kRaysPerPoint; ++i) {
    const int row = i / kSide, column = i % kSide;
    const float u = (static_cast<float>(row) + random.next_float()) / kSide,
                v = (static_cast<float>(column) + random.next_float()) / kSide;
    const Vec3 p = light.corner + light.u * u + light.v * v;
    const Vec3 end = p + rectangle_normal(light) * rectangle_epsilon(light);
    if (pdf_rectangle(light, point.p, p) > 0 && !world.is_occluded(origin_towards(point, p - point.p), end))
      return true;
  }
  return false;
}

bool is_lit_by_environment(const World& world, const AreaPoint& point, RandomStream& random) {
  for (int i = 0; i < kRaysPerPoint; ++i) {
    const float z = 1 - 2 * random.next_float(), phi = 2 * kPi * random.next_float();
    const float r = std::sqrt(std::max(0.0f, 1 - z * z));
    const Vec3 d{r * std::cos(phi), r * std::sin(phi), z};
    if (world.is_open(origin_towards(point, d), d)) return true;
  }
  return false;
}

// One flag for each light.
void count_lit(const World& world, const AreaPoint& point, RandomStream random,
               std::vector<std::int64_t>& lit) {
  auto count = lit.begin();
  for (const SpotLight& spot : world.spots()) *count++ += is_lit_by_spot(world, point, spot);
  for (const RectangleLight& light : world.rectangles())
    *count++ += is_lit_by_rectangle(world, point, light, random);
  if (count != lit.end()) *count += is_lit_by_environment(world, point, random);
}

std::int64_t count_self_hits(const World& world, const AreaPoint& point, RandomStream random) {
  const Frame frame(point.ng);
  std::int64_t hits = 0;
  for (int i = 0; i < kRaysPerPoint; ++i) {
    const float u1 = (static_cast<float>(i) + random.next_float()) / kRaysPerPoint, u2 = random.next_float();
    hits += meets_object(
        world.intersect(point.p + point.ng * point.epsilon, frame.to_world(sample_cosine(u1, u2))));
  }
  return hits;
}

// Sums of `width` counts over all points; `body` adds one point's. The same on any number of threads.
template <typename Body>
std::vector<std::int64_t> sum_counts(std::size_t points, std::size_t width, const Body& body) {
  std::vector<std::vector<std::int64_t>> blocks((points + kBlock - 1) / kBlock);
  for_each_parallel(blocks.size(), [&](std::size_t block) {
    blocks[block].resize(width);
    for (std::size_t i = block * kBlock; i < std::min(points, (block + 1) * kBlock); ++i)
      body(i, blocks[block]);
  });
  std::vector<std::int64_t> sums(width);
  for (const auto& block : blocks) {
    for (std::size_t i = 0; i < width; ++i) sums[i] += block[i];
  }
  return sums;
}

MirrorRay trace_mirror_ray(const World& world, const PrimaryHit& hit) {
  const SurfacePoint& point = hit.point;
  const float cosine = dot(point.ns, hit.v);
  const Vec3 l = point.ns * (2 * cosine) - hit.v;
  if (!(cosine > 0) || !(dot(point.ng, l) > 0)) return {cosine};
  const auto met = world.intersect(point.origin(), l);
  return {cosine, met ? length(met->p - point.p) : std::numeric_limits<float>::infinity(), meets_object(met)};
}

}  // namespace

std::vector<AreaPoint> sample_area(const TriangleMesh& mesh, int count, std::uint64_t seed) {
  const std::vector<double> sums = sum_areas(mesh);
  const StreamKey key = make_stream_key(seed, "object_rays.area");
  const bool is_inside_out = measure_volume(mesh) < 0;
  std::vector<AreaPoint> points;
  for (int i = 0; i < count; ++i) {
    RandomStream random(key, static_cast<std::uint64_t>(i));
    const double at = (i + random.next_double()) / count * sums.back();
    const auto found = std::upper_bound(sums.begin(), sums.end() - 1, at) - sums.begin();
    const float u1 = random.next_float(), u2 = random.next_float();
    points.push_back(sample_triangle(mesh, static_cast<std::size_t>(found), u1, u2));
    if (is_inside_out) points.back().ng = -points.back().ng;
  }
  return points;
}

std::int64_t DirectLight::lit_count() const {
  return std::accumulate(lit.begin(), lit.end(), std::int64_t{0});
}

std::size_t DirectLight::brightest() const {
  return static_cast<std::size_t>(std::max_element(lit.begin(), lit.end()) - lit.begin());
}

DirectLight find_direct_light(const World& world, const std::vector<AreaPoint>& points, std::uint64_t seed) {
  const std::size_t lights =
      world.spots().size() + world.rectangles().size() + (world.environment() != Vec3{} ? 1 : 0);
  const StreamKey key = make_stream_key(seed, "object_rays.lights");
  return {std::ssize(points),
          sum_counts(points.size(), lights, [&](std::size_t i, std::vector<std::int64_t>& lit) {
            count_lit(world, points[i], RandomStream(key, i), lit);
          })};
}

Share find_self_occlusion(const World& world, const std::vector<AreaPoint>& points, std::uint64_t seed) {
  const StreamKey key = make_stream_key(seed, "object_rays.occlusion");
  const auto hits = sum_counts(points.size(), 1, [&](std::size_t i, std::vector<std::int64_t>& count) {
    count[0] += count_self_hits(world, points[i], RandomStream(key, i));
  });
  return {hits[0], std::ssize(points) * kRaysPerPoint};
}

std::vector<MirrorRay> trace_mirror_rays(const World& world, const Primary& primary) {
  std::vector<const PrimaryHit*> seen;
  for (const PrimaryHit& hit : primary.hits) {
    if (hit.kind == PrimaryKind::kObject) seen.push_back(&hit);
  }
  std::vector<MirrorRay> rays(seen.size());
  for_each_parallel((rays.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
    for (std::size_t i = block * kBlock; i < std::min(rays.size(), (block + 1) * kBlock); ++i)
      rays[i] = trace_mirror_ray(world, *seen[i]);
  });
  return rays;
}

Share find_self_mirroring(const std::vector<MirrorRay>& rays) {
  Share share{0, std::ssize(rays)};
  for (const MirrorRay& ray : rays) share.count += ray.meets_object;
  return share;
}

}  // namespace equilux
