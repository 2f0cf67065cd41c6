// What a condition sees of a scene, as a digest: nothing else makes a layer stale.
#include "base/digest.h"
#include "stimuli/scene_json.h"

namespace equilux {
namespace {

Json to_json(Vec3 v) {
  Json json;
  json.push(double{v.x}).push(double{v.y}).push(double{v.z});
  return json;
}

Json material_content(const MaterialSpec& material) {
  Json json;
  json.set("rho_d", to_json(material.rho_d)).set("rho_s", to_json(material.rho_s));
  json.set("alpha", double{material.roughness_alpha}).set("model", static_cast<std::int64_t>(material.model));
  return json;
}

Json placement_content(const Placement& placement) {
  Json json;
  json.set("at", to_json(placement.at)).set("turn", double{placement.turn_degrees});
  json.set("tilt", double{placement.tilt_degrees}).set("scale", double{placement.scale});
  return json;
}

Json light_content(const Light& light) {
  Json json;
  if (const auto* spot = std::get_if<SpotLight>(&light.shape)) {
    json.set("position", to_json(spot->position)).set("direction", to_json(spot->direction));
    json.set("cos_inner", double{spot->cos_inner}).set("cos_outer", double{spot->cos_outer});
    json.set("intensity", to_json(spot->intensity_w_per_sr));
  } else if (const auto* rectangle = std::get_if<RectangleLight>(&light.shape)) {
    json.set("corner", to_json(rectangle->corner))
        .set("u", to_json(rectangle->u))
        .set("v", to_json(rectangle->v));
    json.set("radiance", to_json(rectangle->radiance_w_per_m2_sr));
  } else {
    json.set("environment", to_json(std::get<EnvironmentLight>(light.shape).radiance_w_per_m2_sr));
  }
  return json;
}

// What was read, so that files beside the one that is named count too.
std::string digest_file_mesh(const Scene& scene, const std::string& name, MeshDigests& known) {
  const auto found = known.find(name);
  if (found != known.end()) return found->second;
  return known[name] = digest_mesh(make_mesh(scene, name));
}

// A mesh's specification without its name; files count with what they hold, groups with what they join.
Json mesh_content(const Scene& scene, const std::string& name, MeshDigests& known) {
  const Json& spec = scene.meshes.at(name);
  Json json;
  for (const char* kind : kMeshKinds) {
    if (const Json* found = spec.find(kind)) json.set(kind, *found);
  }
  if (spec.find("file")) json.set("content", digest_file_mesh(scene, name, known));
  if (const Json* scatter = spec.find("scatter")) {
    for (const char* member : {"mesh", "over"})
      json.set(std::string("scatter_") + member, mesh_content(scene, scatter->at(member).as_string(), known));
  }
  if (const Json* group = spec.find("group")) {
    Json parts{Json::Array{}};
    for (const Json& part : group->as_array()) {
      Json row = mesh_content(scene, part.at("mesh").as_string(), known);
      row.set("placement", placement_content(make_placement(part)));
      parts.push(std::move(row));
    }
    json.set("group", std::move(parts));
  }
  return json;
}

}  // namespace

std::string digest_scene_part(const Scene& scene, const Object& object, bool with_material,
                              MeshDigests* digests) {
  MeshDigests own;
  MeshDigests& known = digests ? *digests : own;
  Json json;
  json.set("camera_position", to_json(scene.camera.position))
      .set("camera_target", to_json(scene.camera.target));
  json.set("camera_up", to_json(scene.camera.up)).set("fov", double{scene.camera.vertical_fov_degrees});
  json.set("stand", to_json(scene.stand));
  json.set("object", mesh_content(scene, mesh_of(scene, object.geometry), known));
  if (with_material) json.set("material", material_content(find_material(scene, object.material)));
  Json room{Json::Array{}};
  for (const Instance& instance : scene.instances) {
    Json row;
    row.set("mesh", mesh_content(scene, instance.mesh, known))
        .set("placement", placement_content(instance.placement));
    row.set("material", material_content(find_material(scene, instance.material)));
    room.push(std::move(row));
  }
  for (const Sculpture& sculpture : scene.sculptures) {
    Json row;
    row.set("stand", to_json(sculpture.stand)).set("turn", double{sculpture.turn_degrees});
    row.set("is_object", sculpture.name == object.geometry);
    if (sculpture.name != object.geometry) {
      row.set("mesh", mesh_content(scene, sculpture.mesh, known));
      row.set("material", material_content(find_material(scene, sculpture.material)));
    }
    room.push(std::move(row));
  }
  Json lights{Json::Array{}};
  for (const Light& light : scene.lights) {
    if (is_on(light, object.illumination)) lights.push(light_content(light));
  }
  json.set("room", std::move(room)).set("lights", std::move(lights));
  return digest_json(json);
}

}  // namespace equilux
