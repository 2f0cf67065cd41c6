// From a scene to a script for Blender.
#include "renderer/export.h"

#include <fmt/format.h>
#include <map>

#include "base/version.h"

namespace equilux {

extern const char kBlenderFunctions[];

namespace {

// A name as a Python literal, whatever is in it; bytes above ASCII stay, as Python's sources are UTF-8.
std::string quote(const std::string& text) {
  std::string quoted = "\"";
  for (const char character : text) {
    if (character == '"' || character == '\\') {
      quoted += std::string("\\") + character;
    } else if (static_cast<unsigned char>(character) < 0x20) {
      quoted += fmt::format("\\x{:02x}", static_cast<int>(character));
    } else {
      quoted += character;
    }
  }
  return quoted + "\"";
}

std::string format_tuple(Vec3 v) { return fmt::format("({}, {}, {})", v.x, v.y, v.z); }

std::string format_rows(const std::vector<Vec3>& values) {
  std::string rows;
  for (Vec3 v : values) fmt::format_to(std::back_inserter(rows), "{} {} {}\n", v.x, v.y, v.z);
  return rows;
}

std::string format_mesh(const DiffuseScene::Mesh& mesh) {
  std::string triangles;
  for (const auto& triangle : mesh.mesh.triangles) {
    fmt::format_to(std::back_inserter(triangles), "{}\n", fmt::join(triangle, " "));
  }
  const std::string normals =
      mesh.mesh.normals.empty() ? "" : ", \"\"\"\n" + format_rows(mesh.mesh.normals) + "\"\"\"";
  return fmt::format("meshes.append(mesh({}, \"\"\"\n{}\"\"\", \"\"\"\n{}\"\"\"{}))\n", quote(mesh.name),
                     format_rows(mesh.mesh.positions), triangles, normals);
}

std::string format_surface(const DiffuseScene::Surface& surface) {
  const Placement& placement = surface.placement;
  return fmt::format("place(meshes[{}], materials[{}], {}, {}, {}, {})\n", surface.mesh, surface.material,
                     format_tuple(placement.at), placement.turn_degrees, placement.tilt_degrees,
                     placement.scale);
}

std::string format_spot(const SpotLight& spot) {
  return fmt::format("spot({}, {}, {}, {}, {})\n", format_tuple(spot.position), format_tuple(spot.direction),
                     spot.cos_inner, spot.cos_outer, format_tuple(spot.intensity_w_per_sr));
}

std::string format_rectangle(const RectangleLight& light) {
  return fmt::format("rectangle({}, {}, {}, {})\n", format_tuple(light.corner), format_tuple(light.u),
                     format_tuple(light.v), format_tuple(light.radiance_w_per_m2_sr));
}

std::string format_camera(const DiffuseScene& scene) {
  const Camera& camera = scene.camera;
  return fmt::format("camera({}, {}, {}, {}, {}, {})\n", format_tuple(camera.position),
                     format_tuple(camera.target), format_tuple(camera.up), camera.vertical_fov_degrees,
                     scene.width, scene.height);
}

std::string format_header(const DiffuseScene& scene) {
  const auto glossy = find_glossy_materials(scene);
  std::string header = fmt::format("# {}\n", quote(scene.title));
  header +=
      fmt::format("# Written by equilux-render {} for Blender 3.4. To render it with Cycles:\n", kVersion);
  header += "#   blender -b --python-exit-code 1 --python FILE -- --samples 256 --seed 1 --out picture.exr\n";
  header += "# Every surface is Lambertian. ";
  if (glossy.empty()) return header + "No material had a glossy part.\n";
  std::vector<std::string> names;
  for (const std::string& name : glossy) names.push_back(quote(name));
  return header + fmt::format("Left out is the glossy part of {}.\n", fmt::join(names, ", "));
}

// Gives each name one index, in the order of first use.
class Indices {
 public:
  std::pair<std::size_t, bool> find(const std::string& name) {
    const auto [found, added] = indices_.try_emplace(name, next_);
    next_ += added ? 1 : 0;
    return {found->second, added};
  }
  explicit Indices(std::size_t first) : next_(first) {}

 private:
  std::map<std::string, std::size_t> indices_;
  std::size_t next_;
};

void add_lights(const Scene& scene, Illumination illumination, DiffuseScene& diffuse) {
  for (const Light& light : scene.lights) {
    if (!is_on(light, illumination)) continue;
    if (const auto* spot = std::get_if<SpotLight>(&light.shape)) {
      diffuse.spots.push_back(*spot);
    } else if (const auto* environment = std::get_if<EnvironmentLight>(&light.shape)) {
      diffuse.environment = environment->radiance_w_per_m2_sr;
    } else {
      diffuse.rectangles.push_back(std::get<RectangleLight>(light.shape));
    }
  }
}

// Each has a mesh of its own, in the world already.
void add_other_sculptures(const Scene& scene, const std::string& object, Indices& materials, Indices& meshes,
                          DiffuseScene& diffuse) {
  for (const Sculpture& sculpture : scene.sculptures) {
    if (sculpture.name == object) continue;
    const auto [material, new_material] = materials.find(sculpture.material);
    if (new_material) diffuse.materials.push_back(find_material(scene, sculpture.material));
    const std::size_t mesh = meshes.find("sculpture " + sculpture.name).first;
    diffuse.meshes.push_back({"sculpture " + sculpture.name, make_object(scene, sculpture.name)});
    diffuse.surfaces.push_back({mesh, material, {}});
  }
}

}  // namespace

DiffuseScene make_diffuse_scene(const Scene& scene, const ExportParams& params) {
  DiffuseScene diffuse;
  diffuse.title = fmt::format("{}: {}, v{}", scene.name, format_key(params.object), params.view);
  diffuse.camera = make_view_camera(scene, params.view);
  diffuse.width = params.width;
  diffuse.height = params.height;
  diffuse.materials.push_back(find_material(scene, params.object.material));
  diffuse.meshes.push_back({"object", make_object(scene, params.object.geometry)});
  diffuse.surfaces.push_back({0, 0, {}});
  Indices materials(0), meshes(1);
  materials.find(params.object.material);
  add_other_sculptures(scene, params.object.geometry, materials, meshes, diffuse);
  for (const Instance& instance : scene.instances) {
    const auto [material, new_material] = materials.find(instance.material);
    if (new_material) diffuse.materials.push_back(find_material(scene, instance.material));
    const auto [mesh, new_mesh] = meshes.find(instance.mesh);
    if (new_mesh) diffuse.meshes.push_back({instance.mesh, make_mesh(scene, instance.mesh)});
    diffuse.surfaces.push_back({mesh, material, instance.placement});
  }
  add_lights(scene, params.object.illumination, diffuse);
  return diffuse;
}

std::vector<std::string> find_glossy_materials(const DiffuseScene& scene) {
  std::vector<std::string> names;
  for (const MaterialSpec& material : scene.materials) {
    if (max_component(material.rho_s) > 0) names.push_back(material.name);
  }
  return names;
}

std::size_t count_triangles(const DiffuseScene& scene) {
  std::size_t count = 0;
  for (const auto& surface : scene.surfaces) count += scene.meshes[surface.mesh].mesh.triangles.size();
  return count;
}

std::string format_blender_script(const DiffuseScene& scene) {
  std::string script = format_header(scene) + kBlenderFunctions +
                       fmt::format("\n\nstart({})\nmaterials = [\n", format_tuple(scene.environment));
  for (const MaterialSpec& material : scene.materials) {
    script += fmt::format("    material({}, {}),\n", quote(material.name), format_tuple(material.rho_d));
  }
  script += "]\nmeshes = []\n";
  for (const auto& mesh : scene.meshes) script += format_mesh(mesh);
  for (const auto& surface : scene.surfaces) script += format_surface(surface);
  for (const SpotLight& light : scene.spots) script += format_spot(light);
  for (const RectangleLight& light : scene.rectangles) script += format_rectangle(light);
  return script + format_camera(scene) + "render()\n";
}

}  // namespace equilux
