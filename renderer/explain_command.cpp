// equilux-render explain: what rendering a condition leaves out, and why.
#include <algorithm>
#include <fmt/format.h>

#include "base/error.h"
#include "base/files.h"
#include "base/program.h"
#include "renderer/commands.h"
#include "renderer/layer_store.h"
#include "renderer/plan.h"
#include "renderer/scene_or_study.h"
#include "renderer/wanted.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

struct ExplainOptions {
  fs::path input, folder;
  std::vector<std::string> conditions;
};

// With which a study shares VPLs.
std::vector<std::string> list_materials(const Study& study, const Object& object) {
  std::vector<std::string> materials;
  for (const Object& other : enumerate_objects(study)) {
    if (other.geometry == object.geometry && other.illumination == object.illumination)
      materials.push_back(other.material);
  }
  return materials;
}

// Of the condition's layer and its reference's.
std::pair<std::size_t, std::size_t> count_layers(const SceneOrStudy& input, const Condition& condition,
                                                 const fs::path& folder) {
  const Family family = family_of(condition);
  const Recipes recipes = make_recipes(input.study, input.scene, {{family}, {condition}});
  LayerStore store({folder}, input.study);
  std::size_t whole =
      store.is_whole(vpl_layer_name(condition), digest_vpl_recipe(recipes, condition)) ? 1 : 0;
  const std::string recipe = digest_family_recipe(recipes, family);
  for (const char* content : kFamilyContents) whole += store.is_whole(layer_name(family, content), recipe);
  return {whole, 1 + std::size(kFamilyContents)};
}

PlanRequest make_request(const SceneOrStudy& input, const Condition& condition, const fs::path& folder) {
  PlanRequest request;
  request.source = input.name();
  request.condition = condition;
  request.width = input.study.width;
  request.height = input.study.height;
  request.positions = input.study.subpixel_positions;
  request.emission = input.study.emission;
  request.clamp_levels = std::vector{condition.cell.clamp_level};
  if (!input.is_study) return request;
  request.clamp_levels = traversed_levels(input.study);
  request.reference = input.study.paths ? ReferenceMethod::kPath : input.study.reference;
  request.materials = list_materials(input.study, condition.cell.column.object);
  if (!folder.empty()) request.layers_on_disk = count_layers(input, condition, folder);
  return request;
}

// Only a study has a folder and materials that share.
void check_study(const SceneOrStudy& input, const ExplainOptions& options,
                 const std::vector<Condition>& conditions) {
  if (!options.folder.empty() && (!input.is_study || !fs::is_directory(options.folder)))
    throw InputError("--out", options.folder.string(), "the folder of a study, and its study file",
                     input.is_study ? "no folder" : "a scene");
  if (!input.is_study) return;
  const std::vector<Condition> all = enumerate_conditions(input.study);
  for (Condition condition : conditions) {
    if (input.study.normalise) condition.cell.normalised = true;  // a key without n means the same
    if (std::find(all.begin(), all.end(), condition) == all.end())
      throw InputError("--condition", "", "a condition of the study " + input.study.name,
                       format_key(condition));
  }
}

int run_explain(const ExplainOptions& options) {
  const SceneOrStudy input = load_scene_or_study(options.input);
  const auto conditions = parse_scene_conditions(input, options.conditions);
  check_study(input, options, conditions);
  std::string between;
  for (const Condition& condition : conditions) {
    fmt::print("{}{}", between,
               format_plan(make_plan(input.scene, make_request(input, condition, options.folder))));
    between = "\n";
  }
  return kExitOk;
}

}  // namespace

void add_explain(CLI::App& app, CommandLine& line) {
  auto options = std::make_shared<ExplainOptions>();
  CLI::App* explain = app.add_subcommand(
      "explain", "Tell what rendering a condition leaves out, why that is safe, what it saves");
  explain->add_option("input", options->input, "Scene or study file")->required();
  explain->add_option("--condition", options->conditions, "Keys such as G0-LG-ind-100k-C0-v0")->required();
  explain->add_option("--out", options->folder, "Study folder, to tell which layers are on disk");
  add_machine(*explain, line);
  explain->footer("Example: equilux-render explain protocols/pocket.json --condition G0-GS-ind-100k-C4-v0");
  explain->callback([&line, options] { line.command = [options] { return run_explain(*options); }; });
}

}  // namespace equilux
