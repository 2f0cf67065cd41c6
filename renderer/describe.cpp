// The numbers of a scene.
#include "renderer/describe.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

namespace equilux {
namespace {

constexpr Illumination kIlluminations[] = {Illumination::kIndirect, Illumination::kDirectAndIndirect};
constexpr const char* kStudyMaterials[] = {"MS", "MR", "BS", "BR", "GS", "LG"};

LightCounts count_lights(const Scene& scene, Illumination illumination) {
  LightCounts counts;
  for (const Light& light : scene.lights) {
    if (!is_on(light, illumination)) continue;
    counts.spots += std::holds_alternative<SpotLight>(light.shape);
    counts.rectangles += std::holds_alternative<RectangleLight>(light.shape);
    counts.environments += std::holds_alternative<EnvironmentLight>(light.shape);
  }
  return counts;
}

std::size_t count_room_triangles(const Scene& scene) {
  std::map<std::string, std::size_t> known;
  std::size_t count = 0;
  for (const Instance& instance : scene.instances) {
    const auto [found, added] = known.try_emplace(instance.mesh, 0);
    if (added) found->second = make_mesh(scene, instance.mesh).triangles.size();
    count += found->second;
  }
  return count;
}

SceneCounts count_scene(const Scene& scene) {
  return {scene.instances.size(),
          count_room_triangles(scene),
          scene.materials.size(),
          {count_lights(scene, kIlluminations[0]), count_lights(scene, kIlluminations[1])}};
}

// As World orders them.
std::vector<std::string> name_lights(const Scene& scene, Illumination illumination) {
  std::array<std::vector<std::string>, 3> kinds;
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    if (is_on(scene.lights[i], illumination))
      kinds[scene.lights[i].shape.index()].push_back(fmt::format("/lights/{}", i));
  }
  std::vector<std::string> names;
  for (const auto& kind : kinds) names.insert(names.end(), kind.begin(), kind.end());
  return names;
}

// Short names first: G0 .. G3 before Bunny and Dragon.
std::vector<std::string> choose_geometries(const Scene& scene, const DescribeParams& params) {
  if (!params.geometries.empty()) return params.geometries;
  std::vector<std::string> names;
  for (const auto& [name, mesh] : scene.geometries) names.push_back(name);
  std::stable_sort(names.begin(), names.end(),
                   [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return names;
}

bool is_glossy(const MaterialSpec& material) { return max_component(material.rho_s) > 0; }

std::vector<MaterialSpec> choose_materials(const Scene& scene, const DescribeParams& params) {
  std::vector<MaterialSpec> chosen;
  for (const std::string& name : params.materials) chosen.push_back(find_material(scene, name));
  for (const char* name : kStudyMaterials) {
    for (const MaterialSpec& material : scene.materials)
      if (params.materials.empty() && material.name == name) chosen.push_back(material);
  }
  for (const MaterialSpec& material : scene.materials)
    if (chosen.empty() && is_glossy(material)) chosen.push_back(material);
  return chosen;
}

Share find_coverage(const Primary& primary) {
  Share share{0, std::ssize(primary.hits)};
  for (const PrimaryHit& hit : primary.hits) share.count += hit.kind == PrimaryKind::kObject;
  return share;
}

void describe_views(const Scene& scene, const World& world, GeometryDescription& geometry) {
  for (int view = 0; view < kViewCount; ++view) {
    const Primary primary =
        trace_primary(world, make_view_camera(scene, view), kDescribeWidth, kDescribeHeight, 1);
    geometry.coverage[static_cast<std::size_t>(view)] = find_coverage(primary);
    if (view == 0) geometry.mirror_rays = trace_mirror_rays(world, primary);
  }
  geometry.self_mirroring = find_self_mirroring(geometry.mirror_rays);
}

GeometryDescription describe_geometry(const Scene& scene, const std::string& name,
                                      const DescribeParams& params) {
  GeometryDescription geometry{name};
  const auto mesh_name = scene.geometries.find(name);
  if (mesh_name != scene.geometries.end()) geometry.missing = find_missing_file(scene, mesh_name->second);
  if (!geometry.missing.empty()) return geometry;
  const TriangleMesh mesh = make_object(scene, name, &geometry.repairs);
  geometry.triangles = mesh.triangles.size();
  geometry.bumpiness = measure_bumpiness(mesh);
  const auto points = sample_area(mesh, params.points, params.seed);
  for (std::size_t i = 0; i < std::size(kIlluminations); ++i) {
    const World world = make_world(scene, name, kIlluminations[i]);
    geometry.direct[i] = find_direct_light(world, points, params.seed);
    if (i > 0) continue;
    geometry.self_occlusion = find_self_occlusion(world, points, params.seed);
    describe_views(scene, world, geometry);
  }
  return geometry;
}

ClampReach find_reach(const MaterialSpec& material) {
  ClampReach reach{material.name};
  const double peak = find_mirror_peak(make_material(material), 1);
  for (int level = 0; level < kClampLevelCount; ++level)
    reach.distance_m[static_cast<std::size_t>(level)] = find_clamp_distance(peak, level);
  return reach;
}

// Of nearest rank.
std::array<double, 5> find_quantiles(std::vector<float> lengths) {
  std::array<double, 5> quantiles{};
  std::sort(lengths.begin(), lengths.end());
  const auto count = static_cast<double>(lengths.size());
  for (std::size_t i = 0; i < quantiles.size() && !lengths.empty(); ++i)
    quantiles[i] = double(lengths[static_cast<std::size_t>(std::ceil(kLengthShares[i] * count)) - 1]);
  return quantiles;
}

void count_bites(const MirrorRay& ray, const Material& material, ClampBite& bite) {
  const double peak = ray.length_m < 0 ? 0 : find_mirror_peak(material, double(ray.cosine));
  for (int level = 0; level < kClampLevelCount; ++level) {
    Share& share = bite.bitten[static_cast<std::size_t>(level)];
    ++share.total;
    share.count += ray.length_m >= 0 && double(ray.length_m) < find_clamp_distance(peak, level);
  }
}

ClampBite find_bite(const GeometryDescription& geometry, const MaterialSpec& spec) {
  ClampBite bite{geometry.name, spec.name};
  const Material material = make_material(spec);
  std::vector<float> lengths;
  for (const MirrorRay& ray : geometry.mirror_rays) {
    count_bites(ray, material, bite);
    if (ray.length_m >= 0) lengths.push_back(ray.length_m);
  }
  bite.rays = lengths.size();
  bite.length_quantiles_m = find_quantiles(std::move(lengths));
  return bite;
}

// For the first geometry that is there and the first glossy material.
ClampBite find_first_bite(const std::vector<GeometryDescription>& geometries,
                          const std::vector<MaterialSpec>& materials) {
  const auto geometry = std::find_if(geometries.begin(), geometries.end(),
                                     [](const auto& each) { return each.missing.empty(); });
  const auto material = std::find_if(materials.begin(), materials.end(), is_glossy);
  if (geometry == geometries.end() || material == materials.end()) return {};
  return find_bite(*geometry, *material);
}

}  // namespace

double find_mirror_peak(const Material& material, double cosine) {
  const auto z = static_cast<float>(cosine);
  const float x = std::sqrt(std::max(0.0f, 1 - z * z));
  return double(max_component(eval_brdf(material, {x, 0, z}, {-x, 0, z}))) * cosine;
}

double find_clamp_distance(double peak, int clamp_level) {
  return std::sqrt(peak / clamp_per_m2(clamp_level));
}

Description describe_scene(const Scene& scene, const DescribeParams& params) {
  const auto materials = choose_materials(scene, params);
  Description description{scene.name,
                          count_scene(scene),
                          {name_lights(scene, kIlluminations[0]), name_lights(scene, kIlluminations[1])}};
  for (const std::string& name : choose_geometries(scene, params))
    description.geometries.push_back(describe_geometry(scene, name, params));
  for (const MaterialSpec& material : materials) description.reaches.push_back(find_reach(material));
  description.bite = find_first_bite(description.geometries, materials);
  return description;
}

}  // namespace equilux
