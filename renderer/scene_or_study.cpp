// Which it is, by the file's own word.
#include "renderer/scene_or_study.h"

#include "base/error.h"
#include "base/files.h"
#include "renderer/wanted.h"

namespace equilux {
namespace {

Study make_scene_study(const std::filesystem::path& path) {
  Study study;
  study.scene_path = path;
  study.width = 280;
  study.height = 210;
  study.subpixel_positions = 2;
  for (int level = 0; level < kClampLevelCount; ++level) study.clamp_levels.push_back(level);
  return study;
}

std::string list_geometries(const Scene& scene) {
  std::string list;
  for (const auto& [name, mesh] : scene.geometries) list += (list.empty() ? "" : ", ") + name;
  return list;
}

}  // namespace

SceneOrStudy load_scene_or_study(const std::filesystem::path& path) {
  const Json json = parse_json(load_text(path), path.string());
  const Json* schema = json.find("schema");
  SceneOrStudy loaded;
  loaded.is_study = schema && schema->is_string() && schema->as_string() == "equilux-study";
  loaded.study = loaded.is_study ? load_study(path) : make_scene_study(path);
  loaded.scene = load_scene(loaded.study.scene_path);
  return loaded;
}

std::vector<Condition> parse_scene_conditions(const SceneOrStudy& input,
                                              const std::vector<std::string>& keys) {
  const Scene& scene = input.scene;
  std::vector<Condition> conditions;
  for (const std::string& key : keys) {
    const Condition condition = parse_condition(key, "--condition");
    const Object& object = condition.cell.column.object;
    if (condition.cell.normalised && !input.study.normalise)
      throw InputError("--condition", "", "a level without n: only a normalised study has others", key);
    if (!scene.geometries.contains(object.geometry))
      throw InputError("--condition", "", "a geometry of the scene: " + list_geometries(scene),
                       object.geometry);
    find_material(scene, object.material);
    check_has_light(scene, object.illumination);
    conditions.push_back(condition);
  }
  return conditions;
}

}  // namespace equilux
