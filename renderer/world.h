// The world of one geometry, or of all sculptures, under one illumination, ready for rays.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "renderer/light_reach.h"
#include "renderer/material.h"
#include "stimuli/scene.h"

namespace equilux {

/// Index of the first object's material in Materials; those of further objects and of the room follow.
inline constexpr std::uint32_t kObjectMaterial = 0;

/// Bound on the rounding error of points on a surface whose largest coordinate this is: barycentric
/// interpolation and Embree's robust edge tests err by a few units of rounding, 32 are safe. Rays start and
/// end this far along ng; relative to the numbers involved, so a scaled scene gives the same picture.
inline float rounding_bound(float largest_coordinate) {
  return 16 * std::numeric_limits<float>::epsilon() * largest_coordinate;
}

/// A point on a surface, seen from the side from which the ray came: both normals are on that side by ng.
struct SurfacePoint {
  Vec3 p;
  Vec3 ng;            ///< geometric normal, unit
  Vec3 ns;            ///< shading normal, unit
  float epsilon = 0;  ///< bound on the rounding error of p: rays start this far along ng. units: m
  std::uint32_t material = 0;
  std::int32_t object = -1;   ///< index of the object, or -1 in the room
  std::int32_t emitter = -1;  ///< index of the rectangle light hit on its shining side, or -1

  bool is_object() const { return object >= 0; }

  Vec3 origin() const { return p + ng * epsilon; }
};

/// Sixteen points, structure of arrays.
struct alignas(64) PointPacket {
  std::array<float, 16> x{}, y{}, z{};

  void set(std::size_t lane, Vec3 p) {
    x[lane] = p.x;
    y[lane] = p.y;
    z[lane] = p.z;
  }
};

/// A shadow ray from one point to another.
struct ShadowRay {
  Vec3 from, to;
};

/// Embree's ways to ask for occlusion: ray by ray, in packets, in packets that are said to be coherent, in
/// streams of some thousand.
enum class OcclusionQuery { kOne, kEight, kSixteen, kCoherentSixteen, kStream };
inline constexpr std::array kOcclusionQueries{OcclusionQuery::kOne, OcclusionQuery::kEight,
                                              OcclusionQuery::kSixteen, OcclusionQuery::kCoherentSixteen,
                                              OcclusionQuery::kStream};

/// Sets FTZ and DAZ in this thread: denormals are zero everywhere, in SSE and in Embree alike.
void flush_denormals();

class World {
 public:
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  /// What a ray (unit direction) meets first within `length`. units: m
  std::optional<SurfacePoint> intersect(Vec3 origin, Vec3 direction,
                                        float length = std::numeric_limits<float>::infinity()) const;

  /// True if something stands on the open segment between two points that are off their surfaces already.
  bool is_occluded(Vec3 from, Vec3 to) const;

  /// True if nothing stands on the ray: it reaches the environment.
  bool is_open(Vec3 from, Vec3 direction) const;

  /// The same for the lanes in `valid`, all towards one point. Gives the lanes that are NOT occluded.
  std::uint32_t find_visible(const PointPacket& from, Vec3 to, std::uint32_t valid) const;

  /// The same, lane by lane.
  /// `coherent`: groups of them run side by side.
  std::uint32_t find_visible(const PointPacket& from, const PointPacket& to, std::uint32_t valid,
                             bool coherent) const;

  /// How many of the rays are NOT occluded, on all threads, by one way to ask: what benchmarks hold the cuts
  /// to.
  std::size_t count_visible(const std::vector<ShadowRay>& rays, OcclusionQuery query) const;

  const std::vector<SpotLight>& spots() const { return spots_; }
  /// Indices of the spots whose cones may hold a point, rising. None of the others does.
  std::span<const std::uint32_t> spots_at(Vec3 p) const { return spot_grid_.at(p); }
  const SpotGrid& spot_grid() const { return spot_grid_; }
  const std::vector<RectangleLight>& rectangles() const { return rectangles_; }
  /// Radiance that comes from where no surface is; black without an environment.
  Vec3 environment() const { return environment_; }
  /// A sphere around all surfaces.
  Vec3 center() const { return center_; }
  float radius() const { return radius_; }
  /// What VPLs light: the one object by its geometry, or every sculpture by its name.
  const std::vector<std::string>& objects() const { return objects_; }
  /// What errors name: the scene's file, and objects and illumination, such as "G0-ind".
  const std::string& scene_path() const { return scene_path_; }
  const std::string& name() const { return name_; }
  /// False only if no light can reach the object: no cone holds a part of any of its triangles, and its box
  /// lies behind every rectangle. Whatever stands between is not asked.
  bool may_be_lit(std::size_t object) const { return lit_objects_[object]; }
  const std::vector<MaterialSpec>& room_materials() const { return room_materials_; }
  std::size_t triangle_count() const;
  /// Of all that was read or generated for it, in the world's order.
  std::string digest_triangles() const;

 private:
  friend class WorldBuilder;
  World();

  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::vector<SpotLight> spots_;
  std::vector<RectangleLight> rectangles_;
  Vec3 environment_;
  Vec3 center_;
  float radius_ = 0;
  SpotGrid spot_grid_;
  std::vector<std::string> objects_;
  std::string scene_path_, name_;
  std::vector<bool> lit_objects_;
  std::vector<MaterialSpec> room_materials_;  ///< index: SurfacePoint::material - objects_.size()
};

struct WorldParams {
  bool leave_out_lights = true;  ///< else every point asks every spot, and every object counts as lit
};

/// Makes only what this geometry and illumination need: other geometries and lights that are off are left
/// out. Where the scene has sculptures, the one of this name is the object and the others belong to the room.
/// errors: InputError for a geometry that the scene lacks or a mesh that cannot be read.
World make_world(const Scene& scene, const std::string& geometry, Illumination illumination,
                 const WorldParams& params = {});

/// Every sculpture is an object, in the scene's order. errors: InputError if the scene has none.
World make_sculpture_world(const Scene& scene, Illumination illumination, const WorldParams& params = {});

/// The world's materials with the objects' in their places. shape: object_materials as world.objects()
using Materials = std::vector<Material>;
Materials make_materials(const World& world, const std::vector<MaterialSpec>& object_materials);
Materials make_materials(const World& world, const MaterialSpec& object_material);

/// For pilots that all materials of the objects share: Lambertian objects of a middling grey.
Materials make_grey_materials(const World& world);

}  // namespace equilux
