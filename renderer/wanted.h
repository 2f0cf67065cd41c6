// What a study (or the part of it that a glob names) needs: pictures, and the layers under them.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "protocols/study.h"
#include "stimuli/layers.h"
#include "stimuli/scene.h"

namespace equilux {

/// Pictures to make. A condition brings its family along, since the tone curve is the reference's.
struct Wanted {
  std::vector<Family> families;
  std::vector<Condition> conditions;
  bool empty() const { return families.empty() && conditions.empty(); }
};

/// errors: InputError if the glob names nothing.
Wanted enumerate_wanted(const Study& study, const std::string& only);

/// Clamp levels whose layers these pictures need: their own, and C0 where they are normalised.
std::set<int> needed_levels(const Condition& condition);

/// Levels of one traversal: the study's, and C0 where it is normalised; the weakest clamp first.
std::vector<int> traversed_levels(const Study& study);

/// What layers are made from: scene part, size, positions, seed, parameters of the estimator. Never the
/// program's version.
struct Recipes {
  const Study& study;
  std::map<Object, std::string> scene_parts;
};

/// errors: InputError where the illumination leaves no light on
void check_has_light(const Scene& scene, Illumination illumination);

/// Reads every mesh file that these objects need, once. errors: InputError for what the scene lacks.
Recipes make_recipes(const Study& study, const Scene& scene, const Wanted& wanted);

/// That the mesh files are still those of the recipes. errors: InputError; as make_recipes
void check_same_files(const Recipes& recipes, const Scene& scene);

std::string digest_family_recipe(const Recipes& recipes, const Family& family);
std::string digest_vpl_recipe(const Recipes& recipes, const Condition& condition);

/// Few VPLs are summed one by one, exactly; more go by lightcuts, whose work hardly grows with their number.
bool is_summed_plainly(std::int64_t vpl_count);

/// Of the study's lightcuts.
inline constexpr double kErrorRatio = 0.0075;

}  // namespace equilux
