// From a mesh's specification in a scene to its triangles.
#include "base/error.h"
#include "base/files.h"
#include "stimuli/generators.h"
#include "stimuli/scene_json.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

float to_float(const Json& json) { return static_cast<float>(json.as_double()); }

TriangleMesh make_lathe(const Json& spec) {
  std::vector<std::array<float, 2>> profile;
  for (const Json& point : spec.at("profile").as_array())
    profile.push_back({to_float(point.at(0)), to_float(point.at(1))});
  return equilux::make_lathe(profile, static_cast<int>(spec.at("segments").as_int()));
}

TriangleMesh make_sweep(const Json& spec) {
  std::vector<Vec3> points;
  for (const Json& point : spec.at("points").as_array()) points.push_back(to_vec(point));
  return equilux::make_sweep(points, to_float(spec.at("radius")),
                             static_cast<int>(spec.at("segments").as_int()),
                             static_cast<int>(spec.at("steps").as_int()));
}

TriangleMesh make_blob(const Json& spec) {
  return equilux::make_blob({to_float(spec.at("radius")), to_float(spec.at("amplitude")),
                             to_float(spec.at("frequency")),
                             static_cast<std::uint64_t>(spec.at("seed").as_int()),
                             static_cast<int>(spec.at("subdivisions").as_int())});
}

fs::path make_mesh_path(const Scene& scene, const Json& spec) {
  return scene.path.parent_path() / spec.at("path").as_string();
}

// The command that brings a file, after a semicolon; empty if the scene names none.
std::string fetch_words(const Json& spec) {
  const Json* fetch = spec.find("fetch");
  return fetch ? "; " + fetch->as_string() : "";
}

// Scales a mesh so that its farthest vertex is `radius` from the middle of its box, which goes to the origin.
void fit_to_radius(TriangleMesh& mesh, float radius) {
  Vec3 low = mesh.positions.front(), high = low;
  for (Vec3 p : mesh.positions) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Vec3 middle = low * 0.5f + high * 0.5f;
  float farthest = 0;
  for (Vec3 p : mesh.positions) farthest = std::max(farthest, length(p - middle));
  for (Vec3& p : mesh.positions) p = (p - middle) * (radius / farthest);
}

TriangleMesh load_scene_mesh(const Scene& scene, const std::string& name, const Json& spec,
                             MeshRepairs* repairs) {
  TriangleMesh mesh = load_mesh(find_mesh_file(scene, name), repairs);
  const Json* up = spec.find("up");
  if (up && up->as_string() == "y") mesh = place_mesh(std::move(mesh), {{}, 0, 90, 1});
  if (const Json* radius = spec.find("radius")) fit_to_radius(mesh, to_float(*radius));
  return mesh;
}

TriangleMesh make_extrude(const Json& spec) {
  std::vector<std::array<float, 2>> outline;
  for (const Json& point : spec.at("outline").as_array())
    outline.push_back({to_float(point.at(0)), to_float(point.at(1))});
  return equilux::make_extrude(std::move(outline), to_float(spec.at("height")));
}

// Generated meshes are bounded when the scene is read; those of files only here.
void check_sum(const Scene& scene, std::size_t triangles) {
  if (triangles > kMaxTriangles) {
    throw InputError(scene.path.string(), "/meshes",
                     fmt::format("at most {} triangles in a mesh", kMaxTriangles),
                     fmt::format("{}", triangles));
  }
}

TriangleMesh make_scatter(const Scene& scene, const Json& spec) {
  ScatterParams params;
  params.count = static_cast<int>(spec.at("count").as_int());
  params.seed = static_cast<std::uint64_t>(spec.at("seed").as_int());
  if (const Json* scale = spec.find("scale")) {
    params.smallest_scale = to_float(scale->at(0));
    params.largest_scale = to_float(scale->at(1));
  }
  if (const Json* lean = spec.find("lean_degrees")) params.lean_degrees = to_float(*lean);
  const TriangleMesh part = make_mesh(scene, spec.at("mesh").as_string());
  check_sum(scene, part.triangles.size() * static_cast<std::size_t>(params.count));
  return equilux::make_scatter(part, make_mesh(scene, spec.at("over").as_string()), params);
}

TriangleMesh make_group(const Scene& scene, const Json& spec, MeshRepairs* repairs) {
  TriangleMesh mesh;
  for (const Json& part : spec.as_array()) {
    append_mesh(mesh,
                place_mesh(make_mesh(scene, part.at("mesh").as_string(), repairs), make_placement(part)));
    check_sum(scene, mesh.triangles.size());
  }
  return mesh;
}

}  // namespace

std::filesystem::path find_mesh_file(const Scene& scene, const std::string& mesh) {
  const Json& spec = scene.meshes.at(mesh).at("file");
  auto path = make_mesh_path(scene, spec);
  if (path_exists(path)) return path;
  throw InputError(scene.path.string(), fmt::format("mesh \"{}\"", mesh),
                   fmt::format("the file {}", path.string()), "none" + fetch_words(spec));
}

std::string find_missing_file(const Scene& scene, const std::string& mesh) {
  const Json& spec = scene.meshes.at(mesh);
  if (const Json* file = spec.find("file")) {
    const auto path = make_mesh_path(scene, *file);
    return path_exists(path) ? "" : fmt::format("no file {}{}", path.string(), fetch_words(*file));
  }
  std::string missing;
  if (const Json* scatter = spec.find("scatter")) {
    missing = find_missing_file(scene, scatter->at("mesh").as_string());
    if (missing.empty()) missing = find_missing_file(scene, scatter->at("over").as_string());
  }
  const Json* group = spec.find("group");
  for (std::size_t i = 0; missing.empty() && group && i < group->as_array().size(); ++i)
    missing = find_missing_file(scene, group->at(i).at("mesh").as_string());
  return missing;
}

namespace {

TriangleMesh make_any_mesh(const Scene& scene, const std::string& name, MeshRepairs* repairs) {
  const Json& spec = scene.meshes.at(name);
  if (const Json* quad = spec.find("quad")) return make_quad(to_vec(quad->at("u")), to_vec(quad->at("v")));
  if (const Json* box = spec.find("box")) return make_box(to_vec(box->at("size")));
  if (const Json* lathe = spec.find("lathe")) return make_lathe(*lathe);
  if (const Json* sweep = spec.find("sweep")) return make_sweep(*sweep);
  if (const Json* extrude = spec.find("extrude")) return make_extrude(*extrude);
  if (const Json* scatter = spec.find("scatter")) return make_scatter(scene, *scatter);
  if (const Json* sphere = spec.find("sphere")) {
    return make_sphere(to_float(sphere->at("radius")), static_cast<int>(sphere->at("subdivisions").as_int()));
  }
  if (const Json* blob = spec.find("blob")) return make_blob(*blob);
  if (const Json* file = spec.find("file")) return load_scene_mesh(scene, name, *file, repairs);
  return make_group(scene, spec.at("group"), repairs);
}

bool has_area(const TriangleMesh& mesh) {
  return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& triangle) {
    const Vec3 a = mesh.positions[triangle[0]];
    return spans_area(mesh.positions[triangle[1]] - a, mesh.positions[triangle[2]] - a);
  });
}

}  // namespace

TriangleMesh make_mesh(const Scene& scene, const std::string& name, MeshRepairs* repairs) {
  TriangleMesh mesh = make_any_mesh(scene, name, repairs);
  if (!has_area(mesh)) {
    throw InputError(scene.path.string(), fmt::format("mesh \"{}\"", name), "a mesh with an area in float",
                     fmt::format("{} triangles of none", mesh.triangles.size()));
  }
  return mesh;
}

}  // namespace equilux
