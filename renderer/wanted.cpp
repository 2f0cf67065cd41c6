// From a study and a glob to keys and recipes.
#include "renderer/wanted.h"

#include <algorithm>
#include <fmt/format.h>
#include <fnmatch.h>

#include "base/error.h"
#include "base/json.h"
#include "stimuli/manifest.h"

namespace equilux {
namespace {

// Raised whenever an estimator changes what it makes from the same inputs: layers made before are then made
// anew.
constexpr int kPathEstimator = 9;
constexpr int kCompensatedEstimator = 7;
// How VPLs with full emission are counted.
constexpr int kFullCount = 2;
constexpr int kVplEstimator = 5;
constexpr int kLightcutEstimator = 6;

// Where the exact sum costs half as much again as cuts in the café, for the eleven levels of one material;
// the two cost the same at 1,000.
constexpr std::int64_t kMostPlainVpls = 2000;

bool matches(const std::string& key, const std::string& glob) {
  return fnmatch(glob.c_str(), key.c_str(), 0) == 0;
}

Json common_recipe(const Recipes& recipes, const Object& object, int view) {
  const Study& study = recipes.study;
  Json json;
  json.set("scene", recipes.scene_parts.at(object)).set("view", view);
  json.set("illumination", format_illumination(object.illumination));
  json.set("width", study.width).set("height", study.height).set("positions", study.subpixel_positions);
  json.set("seed", study.seed);
  return json;
}

// By which a displayed step is found.
void set_exposure(Json& recipe, const ToneMapping& tone) {
  recipe.set("tone_key", tone.key);
  recipe.set("exposure", tone.exposure == Exposure::kWhole ? "whole" : "background");
}

// By which displayed errors are found.
void set_tone(Json& recipe, const ToneMapping& tone) {
  set_exposure(recipe, tone);
  if (tone.operation == ToneOperator::kLocal)
    recipe.set("tone_operator", fmt::format("local {}", kLocalToneVersion));
}

}  // namespace

Wanted enumerate_wanted(const Study& study, const std::string& only) {
  Wanted wanted;
  std::set<Family> families;
  for (const Condition& condition : enumerate_conditions(study)) {
    if (!matches(format_key(condition), only)) continue;
    wanted.conditions.push_back(condition);
    families.insert(family_of(condition));
  }
  const auto references = enumerate_references(study);
  for (const Family& family : references) {
    if (matches(format_key(family), only) || families.contains(family)) wanted.families.push_back(family);
  }
  if (wanted.families.empty()) {
    throw InputError("--only", "",
                     fmt::format("a glob that names pictures of {}, such as {}", study.name,
                                 format_key(references.front())),
                     only);
  }
  return wanted;
}

std::set<int> needed_levels(const Condition& condition) {
  std::set<int> levels{condition.cell.clamp_level};
  if (condition.cell.normalised) levels.insert(0);
  return levels;
}

std::vector<int> traversed_levels(const Study& study) {
  std::set<int> levels(study.clamp_levels.begin(), study.clamp_levels.end());
  if (study.normalise) levels.insert(0);
  return {levels.begin(), levels.end()};
}

void check_has_light(const Scene& scene, Illumination illumination) {
  const auto shines = [&](const Light& light) { return is_on(light, illumination); };
  if (std::any_of(scene.lights.begin(), scene.lights.end(), shines)) return;
  throw InputError(scene.path.string(), "/lights",
                   fmt::format("a light that is on under {}", format_illumination(illumination)), "none");
}

Recipes make_recipes(const Study& study, const Scene& scene, const Wanted& wanted) {
  Recipes recipes{study, {}};
  MeshDigests digests;
  for (const Family& family : wanted.families) {
    const auto [part, added] = recipes.scene_parts.try_emplace(family.object);
    if (!added) continue;
    check_has_light(scene, family.object.illumination);
    part->second = digest_scene_part(scene, family.object, true, &digests);
  }
  return recipes;
}

void check_same_files(const Recipes& recipes, const Scene& scene) {
  MeshDigests digests;
  for (const auto& [object, part] : recipes.scene_parts) {
    if (digest_scene_part(scene, object, true, &digests) != part)
      throw InputError(scene.path.string(), "/meshes",
                       "files that stay as they are while a set is rendered; running it again goes on",
                       fmt::format("other files of {}-{} than at the start", object.geometry,
                                   format_illumination(object.illumination)));
  }
}

bool is_summed_plainly(std::int64_t vpl_count) { return vpl_count <= kMostPlainVpls; }

std::string digest_family_recipe(const Recipes& recipes, const Family& family) {
  const Study& study = recipes.study;
  Json json = common_recipe(recipes, family.object, family.view);
  json.set("estimator", "path").set("estimator_version", kPathEstimator);
  if (study.paths) {
    json.set("paths_indirect", study.paths->object_indirect).set("paths_direct", study.paths->object_direct);
    json.set("paths_background", study.paths->background);
  } else {
    const NoiseTarget& target = study.noise_target;
    json.set("object_mean", target.object_mean).set("object_p99", target.object_p99);
    json.set("outside_mean", target.outside_mean);
    set_tone(json, study.planned_tone);
    if (study.reference == ReferenceMethod::kCompensated)
      json.set("reference", "compensated").set("reference_version", kCompensatedEstimator);
  }
  return digest_json(json);
}

std::string digest_vpl_recipe(const Recipes& recipes, const Condition& condition) {
  const Column& column = condition.cell.column;
  Json json = common_recipe(recipes, column.object, condition.view);
  if (is_summed_plainly(column.vpl_count)) {
    json.set("estimator", "vpl-sum").set("estimator_version", kVplEstimator);
  } else {
    // The levels share the cut, and the rule's floor comes from the reference.
    json.set("estimator", "lightcut").set("estimator_version", kLightcutEstimator);
    json.set("error_ratio", kErrorRatio);
    if (recipes.study.certified) json.set("certified", true);
    Json levels{Json::Array{}};
    for (int level : traversed_levels(recipes.study)) levels.push(level);
    json.set("levels", std::move(levels));
    json.set("reference", digest_family_recipe(recipes, family_of(condition)));
    if (recipes.study.paths) set_exposure(json, recipes.study.planned_tone);
  }
  json.set("emission", recipes.study.emission == Emission::kFull ? "full" : "lambertian");
  if (recipes.study.emission == Emission::kFull) json.set("count_version", kFullCount);
  json.set("vpls", column.vpl_count).set("clamp", format_clamp(condition.cell.clamp_level));
  return digest_json(json);
}

}  // namespace equilux
