// What a scene is, in numbers: what is in it, how its objects are shaped, which lights reach them, and how
// far each clamp level reaches.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "renderer/object_rays.h"
#include "stimuli/bumpiness.h"

namespace equilux {

/// Pixels of the pictures that coverage and mirror rays are taken from: the study's.
inline constexpr int kDescribeWidth = 560, kDescribeHeight = 420;

struct DescribeParams {
  std::vector<std::string> geometries{};  ///< none for all of the scene
  std::vector<std::string> materials{};  ///< none for the study's that the scene has, or else its glossy ones
  int points = 4096;                     ///< of each object, even by area
  std::uint64_t seed = 1;
};

struct LightCounts {
  std::size_t spots = 0, rectangles = 0, environments = 0;
};

struct SceneCounts {
  std::size_t instances = 0, room_triangles = 0, materials = 0;
  std::array<LightCounts, 2> lights{};  ///< by illumination
};

struct GeometryDescription {
  std::string name{};
  std::string missing{};  ///< what is, of its files; then the rest is empty
  std::size_t triangles = 0;
  MeshRepairs repairs{};
  Bumpiness bumpiness{};
  std::array<Share, kViewCount> coverage{};  ///< of the pixels
  Share self_occlusion{}, self_mirroring{};  ///< the latter in v0
  std::array<DirectLight, 2> direct{};       ///< by illumination
  std::vector<MirrorRay> mirror_rays{};      ///< in v0
};

/// How far the clamp levels reach with a material: r_c at normal incidence. units: m
struct ClampReach {
  std::string material{};
  std::array<double, kClampLevelCount> distance_m{};
};

/// What the clamp levels take of a material's reflections on an object.
struct ClampBite {
  std::string geometry{}, material{};            ///< empty where there is none
  std::array<Share, kClampLevelCount> bitten{};  ///< positions whose mirror ray ends within r_c at its angle
  std::array<double, 5> length_quantiles_m{};  ///< of the mirror rays, at kLengthShares; infinite in the open
  std::size_t rays = 0;                        ///< that leave the surface
};
inline constexpr std::array<double, 5> kLengthShares{.01, .1, .5, .9, .99};

struct Description {
  std::string name{};
  SceneCounts counts{};
  std::array<std::vector<std::string>, 2>
      lights{};  ///< JSON pointers in DirectLight's order, by illumination
  std::vector<GeometryDescription> geometries{};
  std::vector<ClampReach> reaches{};
  ClampBite bite{};
};

/// The peak of f cl in the mirror direction at this cosine, largest channel: what a clamp level is held
/// against. units: 1/sr
double find_mirror_peak(const Material& material, double cosine);

/// Distance within which a clamp level cuts what has this peak, sqrt(peak / c): 0 for C0. units: m
double find_clamp_distance(double peak, int clamp_level);

/// A geometry whose file is missing is described as that. errors: InputError for what the scene lacks or
/// cannot be read.
Description describe_scene(const Scene& scene, const DescribeParams& params);

/// Tables in plain text.
std::string format_description(const Description& description);

}  // namespace equilux
