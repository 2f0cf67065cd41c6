// The one file that knows Embree.
#include "renderer/world.h"

#include <algorithm>
#include <atomic>
#include <embree3/rtcore.h>
#include <immintrin.h>
#include <limits>
#include <map>
#include <pmmintrin.h>

#include "base/digest.h"
#include "base/error.h"
#include "renderer/isa.h"
#include "renderer/parallel.h"

namespace equilux {
namespace {

struct Part {
  TriangleMesh mesh;
  std::uint32_t material = 0;
  std::int32_t object = -1;
  std::int32_t emitter = -1;
};

RTCDevice shared_device() {
  static const RTCDevice device = [] {
    const char* most = current_isa() == Isa::kV4 ? "avx512" : "avx2";
    RTCDevice made = rtcNewDevice(fmt::format("set_affinity=0,max_isa={}", most).c_str());
    EQ_CHECK(made != nullptr, static_cast<int>(rtcGetDeviceError(nullptr)));
    return made;
  }();
  return device;
}

void check_device(RTCDevice device) {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  EQ_CHECK(error == RTC_ERROR_NONE, static_cast<int>(error));
}

void attach_part(RTCDevice device, RTCScene scene, const Part& part) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), part.mesh.positions.size()));
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t),
                              part.mesh.triangles.size()));
  check_device(device);
  for (Vec3 p : part.mesh.positions) {
    *vertices++ = p.x;
    *vertices++ = p.y;
    *vertices++ = p.z;
  }
  for (const auto& triangle : part.mesh.triangles)
    indices = std::copy(triangle.begin(), triangle.end(), indices);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  check_device(device);
}

Box find_box(const TriangleMesh& mesh) {
  Box box{mesh.positions.front(), mesh.positions.front()};
  for (const Vec3 p : mesh.positions) {
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y), std::min(box.low.z, p.z)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y), std::max(box.high.z, p.z)};
  }
  return box;
}

Part make_emitter_part(const RectangleLight& light, std::int32_t index, std::uint32_t material) {
  Part part;
  part.mesh = {
      {light.corner, light.corner + light.u, light.corner + light.u + light.v, light.corner + light.v},
      {},
      {{0, 1, 2}, {0, 2, 3}}};
  part.material = material;
  part.emitter = index;
  return part;
}

Vec3 interpolate(const std::vector<Vec3>& values, const std::array<std::uint32_t, 3>& triangle, float u,
                 float v) {
  return values[triangle[0]] * (1 - u - v) + values[triangle[1]] * u + values[triangle[2]] * v;
}

float largest_coordinate(const std::vector<Vec3>& positions, const std::array<std::uint32_t, 3>& triangle) {
  float largest = 0;
  for (std::uint32_t i : triangle) {
    const Vec3 p = positions[i];
    largest = std::max({largest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  }
  return largest;
}

SurfacePoint make_surface_point(const Part& part, std::uint32_t primitive, float u, float v, Vec3 direction) {
  const auto& triangle = part.mesh.triangles[primitive];
  const auto& positions = part.mesh.positions;
  SurfacePoint point;
  point.p = interpolate(positions, triangle, u, v);
  point.epsilon = rounding_bound(largest_coordinate(positions, triangle));
  point.ng = normalize(cross(positions[triangle[1]] - positions[triangle[0]],
                             positions[triangle[2]] - positions[triangle[0]]));
  const bool front = dot(point.ng, direction) < 0;
  point.ns = part.mesh.normals.empty() ? point.ng : normalize(interpolate(part.mesh.normals, triangle, u, v));
  if (point.ns == Vec3{}) point.ns = point.ng;
  if (!front) point.ng = -point.ng;
  if (dot(point.ns, point.ng) < 0) point.ns = -point.ns;
  point.material = part.material;
  point.object = part.object;
  point.emitter = front ? part.emitter : -1;
  return point;
}

// True if something stands at from + t d, 0 < t < end.
bool is_hit_before(RTCScene scene, Vec3 from, Vec3 d, float end) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray{};
  ray.org_x = from.x;
  ray.org_y = from.y;
  ray.org_z = from.z;
  ray.dir_x = d.x;
  ray.dir_y = d.y;
  ray.dir_z = d.z;
  ray.tfar = end;
  ray.mask = ~0u;
  rtcOccluded1(scene, &context, &ray);
  return ray.tfar < 0;
}

}  // namespace

struct World::Impl {
  RTCScene scene = nullptr;
  std::vector<Part> parts;
  ~Impl() {
    if (scene) rtcReleaseScene(scene);
  }
};

World::World() : impl_(std::make_unique<Impl>()) {}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

void flush_denormals() {
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
}

// Puts parts and lights into a world, then commits it.
class WorldBuilder {
 public:
  explicit WorldBuilder(const WorldParams& params) : params_(params) {}

  void add_object(const Scene& scene, const std::string& geometry) {
    const auto index = static_cast<std::uint32_t>(world_.objects_.size());
    parts().push_back({make_object(scene, geometry), index, static_cast<std::int32_t>(index), -1});
    world_.objects_.push_back(geometry);
  }

  // After all objects: their materials come first.
  void add_room(TriangleMesh mesh, const MaterialSpec& material) {
    const auto next = static_cast<std::uint32_t>(world_.objects_.size() + world_.room_materials_.size());
    const auto [found, added] = indices_.try_emplace(material.name, next);
    if (added) world_.room_materials_.push_back(material);
    parts().push_back({std::move(mesh), found->second, -1, -1});
  }

  void add_instances(const Scene& scene) {
    std::map<std::string, TriangleMesh> meshes;
    std::size_t triangles = 0;
    for (const Instance& instance : scene.instances) {
      const auto [mesh, added] = meshes.try_emplace(instance.mesh);
      if (added) mesh->second = make_mesh(scene, instance.mesh);
      triangles += mesh->second.triangles.size();
      if (triangles > kMaxTriangles) {
        throw InputError(scene.path.string(), "/instances",
                         fmt::format("at most {} triangles in all", kMaxTriangles), "more");
      }
      add_room(place_mesh(mesh->second, instance.placement), find_material(scene, instance.material));
    }
  }

  void add_lights(const Scene& scene, Illumination illumination) {
    world_.room_materials_.push_back({"emitter", {}, {}, 0});
    const auto black = static_cast<std::uint32_t>(world_.objects_.size() + world_.room_materials_.size()) - 1;
    for (const Light& light : scene.lights) {
      if (!is_on(light, illumination)) continue;
      if (const auto* spot = std::get_if<SpotLight>(&light.shape)) {
        world_.spots_.push_back(*spot);
      } else if (const auto* environment = std::get_if<EnvironmentLight>(&light.shape)) {
        world_.environment_ = environment->radiance_w_per_m2_sr;
      } else {
        world_.rectangles_.push_back(std::get<RectangleLight>(light.shape));
        parts().push_back(make_emitter_part(world_.rectangles_.back(),
                                            static_cast<std::int32_t>(world_.rectangles_.size()) - 1, black));
      }
    }
  }

  // After all objects.
  void set_name(const Scene& scene, Illumination illumination) {
    world_.scene_path_ = scene.path.string();
    world_.name_ = fmt::format("{}-{}", fmt::join(world_.objects_, "+"), format_illumination(illumination));
  }

  World commit() {
    const RTCDevice device = shared_device();
    RTCScene& scene = world_.impl_->scene;
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    for (const Part& part : parts()) attach_part(device, scene, part);
    rtcCommitScene(scene);
    check_device(device);
    RTCBounds bounds;
    rtcGetSceneBounds(scene, &bounds);
    const Vec3 low{bounds.lower_x, bounds.lower_y, bounds.lower_z},
        high{bounds.upper_x, bounds.upper_y, bounds.upper_z};
    world_.center_ = low * 0.5f + high * 0.5f;
    // A little larger than the box's own, so that rounding leaves no surface outside.
    world_.radius_ = 0.5001f * length(high - low);
    find_reach({low, high});
    return std::move(world_);
  }

 private:
  std::vector<Part>& parts() { return world_.impl_->parts; }

  void find_reach(const Box& box) {
    constexpr std::size_t kMany = 256;  // spots, of which a fine grid would take long
    const SpotLight everywhere{{}, {0, 0, 1}, -1, -1, {}};
    world_.spot_grid_ = params_.leave_out_lights
                            ? SpotGrid(world_.spots_, box, world_.spots_.size() > kMany ? 8 : 16)
                            : SpotGrid(std::vector(world_.spots_.size(), everywhere), box, 1);
    // The objects' parts come first.
    for (std::size_t object = 0; object < world_.objects_.size(); ++object)
      world_.lit_objects_.push_back(!params_.leave_out_lights || is_reached(parts()[object].mesh));
  }

  bool is_reached(const TriangleMesh& object) const {
    const Box box = find_box(object);
    return world_.environment_ != Vec3{} ||
           std::any_of(
               world_.spots_.begin(), world_.spots_.end(),
               [&](const SpotLight& spot) { return may_reach(spot, box) && may_reach(spot, object); }) ||
           std::any_of(world_.rectangles_.begin(), world_.rectangles_.end(),
                       [&](const RectangleLight& light) { return may_reach(light, box); });
  }

  WorldParams params_;
  World world_;
  std::map<std::string, std::uint32_t> indices_;
};

World make_world(const Scene& scene, const std::string& geometry, Illumination illumination,
                 const WorldParams& params) {
  WorldBuilder builder(params);
  builder.add_object(scene, geometry);
  builder.add_instances(scene);
  for (const Sculpture& sculpture : scene.sculptures) {
    if (sculpture.name != geometry)
      builder.add_room(make_object(scene, sculpture.name), find_material(scene, sculpture.material));
  }
  builder.add_lights(scene, illumination);
  builder.set_name(scene, illumination);
  return builder.commit();
}

World make_sculpture_world(const Scene& scene, Illumination illumination, const WorldParams& params) {
  if (scene.sculptures.empty())
    throw InputError(scene.path.string(), "/", "a scene with sculptures", "one with an object");
  WorldBuilder builder(params);
  for (const Sculpture& sculpture : scene.sculptures) builder.add_object(scene, sculpture.name);
  builder.add_instances(scene);
  builder.add_lights(scene, illumination);
  builder.set_name(scene, illumination);
  return builder.commit();
}

std::size_t World::triangle_count() const {
  std::size_t count = 0;
  for (const Part& part : impl_->parts) count += part.mesh.triangles.size();
  return count;
}

std::string World::digest_triangles() const {
  std::string digests;
  for (const Part& part : impl_->parts) digests += digest_mesh(part.mesh);
  return digest_text(digests);
}

std::optional<SurfacePoint> World::intersect(Vec3 origin, Vec3 direction, float length) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray{};
  ray.ray.org_x = origin.x;
  ray.ray.org_y = origin.y;
  ray.ray.org_z = origin.z;
  ray.ray.dir_x = direction.x;
  ray.ray.dir_y = direction.y;
  ray.ray.dir_z = direction.z;
  ray.ray.tfar = length;
  ray.ray.mask = ~0u;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->scene, &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return make_surface_point(impl_->parts[ray.hit.geomID], ray.hit.primID, ray.hit.u, ray.hit.v, direction);
}

bool World::is_occluded(Vec3 from, Vec3 to) const { return is_hit_before(impl_->scene, from, to - from, 1); }

bool World::is_open(Vec3 from, Vec3 direction) const {
  return !is_hit_before(impl_->scene, from, direction, std::numeric_limits<float>::infinity());
}

namespace {

std::uint32_t find_unoccluded(RTCScene scene, RTCRay16& ray, std::uint32_t valid,
                              RTCIntersectContextFlags flags) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = flags;
  alignas(64) std::array<int, 16> lanes;
  for (unsigned i = 0; i < 16; ++i) {
    lanes[i] = (valid >> i) & 1u ? -1 : 0;
    ray.tnear[i] = 0;
    ray.tfar[i] = 1;
    ray.time[i] = 0;
    ray.mask[i] = ~0u;
    ray.flags[i] = 0;
    ray.id[i] = i;
  }
  rtcOccluded16(lanes.data(), scene, &context, &ray);
  std::uint32_t visible = 0;
  for (unsigned i = 0; i < 16; ++i) visible |= (ray.tfar[i] >= 0 ? 1u : 0u) << i;
  return visible & valid;
}

}  // namespace

std::uint32_t World::find_visible(const PointPacket& from, Vec3 to, std::uint32_t valid) const {
  RTCRay16 ray;
  for (unsigned i = 0; i < 16; ++i) {
    ray.org_x[i] = from.x[i];
    ray.org_y[i] = from.y[i];
    ray.org_z[i] = from.z[i];
    ray.dir_x[i] = to.x - from.x[i];
    ray.dir_y[i] = to.y - from.y[i];
    ray.dir_z[i] = to.z - from.z[i];
  }
  // Neighbours to one point: as coherent rays 10 % faster, measured.
  return find_unoccluded(impl_->scene, ray, valid, RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
}

std::uint32_t World::find_visible(const PointPacket& from, const PointPacket& to, std::uint32_t valid,
                                  bool coherent) const {
  RTCRay16 ray;
  for (unsigned i = 0; i < 16; ++i) {
    ray.org_x[i] = from.x[i];
    ray.org_y[i] = from.y[i];
    ray.org_z[i] = from.z[i];
    ray.dir_x[i] = to.x[i] - from.x[i];
    ray.dir_y[i] = to.y[i] - from.y[i];
    ray.dir_z[i] = to.z[i] - from.z[i];
  }
  return find_unoccluded(
      impl_->scene, ray, valid,
      coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
}

namespace {

template <typename Packet>
void set_ray(Packet& packet, std::size_t lane, const ShadowRay& shadow) {
  packet.org_x[lane] = shadow.from.x;
  packet.org_y[lane] = shadow.from.y;
  packet.org_z[lane] = shadow.from.z;
  packet.dir_x[lane] = shadow.to.x - shadow.from.x;
  packet.dir_y[lane] = shadow.to.y - shadow.from.y;
  packet.dir_z[lane] = shadow.to.z - shadow.from.z;
  packet.tnear[lane] = 0;
  packet.tfar[lane] = 1;
  packet.time[lane] = 0;
  packet.mask[lane] = ~0u;
  packet.flags[lane] = 0;
  packet.id[lane] = 0;
}

template <std::size_t kWidth, typename Packet, typename Occluded>
std::size_t count_in_packets(const ShadowRay* rays, std::size_t count, RTCIntersectContextFlags flags,
                             const Occluded& occluded) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = flags;
  std::size_t visible = 0;
  for (std::size_t first = 0; first < count; first += kWidth) {
    alignas(64) std::array<int, kWidth> valid{};
    Packet packet;
    const std::size_t lanes = std::min(kWidth, count - first);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      valid[lane] = -1;
      set_ray(packet, lane, rays[first + lane]);
    }
    occluded(valid.data(), &context, &packet);
    for (std::size_t lane = 0; lane < lanes; ++lane) visible += packet.tfar[lane] >= 0;
  }
  return visible;
}

std::size_t count_in_stream(RTCScene scene, const ShadowRay* rays, std::size_t count) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  std::vector<RTCRay> stream(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 d = rays[i].to - rays[i].from;
    stream[i] = {rays[i].from.x, rays[i].from.y, rays[i].from.z, 0, d.x, d.y, d.z, 0, 1, ~0u, 0, 0};
  }
  rtcOccluded1M(scene, &context, stream.data(), static_cast<unsigned>(count), sizeof(RTCRay));
  return static_cast<std::size_t>(
      std::count_if(stream.begin(), stream.end(), [](const RTCRay& ray) { return ray.tfar >= 0; }));
}

std::size_t count_in_block(RTCScene scene, const ShadowRay* rays, std::size_t count, OcclusionQuery query) {
  const auto sixteen = [&](RTCIntersectContextFlags flags) {
    return count_in_packets<16, RTCRay16>(
        rays, count, flags,
        [&](const int* valid, auto* context, auto* packet) { rtcOccluded16(valid, scene, context, packet); });
  };
  switch (query) {
    case OcclusionQuery::kOne:
      return static_cast<std::size_t>(std::count_if(rays, rays + count, [&](const ShadowRay& ray) {
        return !is_hit_before(scene, ray.from, ray.to - ray.from, 1);
      }));
    case OcclusionQuery::kEight:
      return count_in_packets<8, RTCRay8>(rays, count, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT,
                                          [&](const int* valid, auto* context, auto* packet) {
                                            rtcOccluded8(valid, scene, context, packet);
                                          });
    case OcclusionQuery::kSixteen:
      return sixteen(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
    case OcclusionQuery::kCoherentSixteen:
      return sixteen(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
    case OcclusionQuery::kStream:
      break;
  }
  return count_in_stream(scene, rays, count);
}

}  // namespace

std::size_t World::count_visible(const std::vector<ShadowRay>& rays, OcclusionQuery query) const {
  constexpr std::size_t kBlock = 4096;
  std::atomic<std::size_t> visible = 0;
  for_each_parallel((rays.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
    const std::size_t first = block * kBlock;
    visible += count_in_block(impl_->scene, &rays[first], std::min(kBlock, rays.size() - first), query);
  });
  return visible;
}

Materials make_materials(const World& world, const std::vector<MaterialSpec>& object_materials) {
  EQ_CHECK(object_materials.size() == world.objects().size(), object_materials.size(),
           world.objects().size());
  Materials materials;
  for (const MaterialSpec& spec : object_materials) materials.push_back(make_material(spec));
  for (const MaterialSpec& spec : world.room_materials()) materials.push_back(make_material(spec));
  return materials;
}

Materials make_materials(const World& world, const MaterialSpec& object_material) {
  return make_materials(world, std::vector{object_material});
}

Materials make_grey_materials(const World& world) {
  constexpr float kGrey = 0.19f;
  const MaterialSpec grey{"pilot", {kGrey, kGrey, kGrey}, {}, 0};
  return make_materials(world, std::vector(world.objects().size(), grey));
}

}  // namespace equilux
