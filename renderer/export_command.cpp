// equilux-render export: a scene for another renderer.
#include <fmt/format.h>

#include "base/files.h"
#include "base/program.h"
#include "renderer/commands.h"
#include "renderer/export.h"

namespace equilux {
namespace {

struct ExportOptions {
  std::filesystem::path scene_path, out;
  ExportParams params;
  std::string illumination = "ind", view = "v0";
};

int write_export(const ExportOptions& options) {
  ExportParams params = options.params;
  params.object.illumination = parse_illumination(options.illumination, "--illumination");
  params.view = options.view == "v1" ? 1 : 0;
  check_writable(options.out);
  const Scene source = load_scene(options.scene_path);
  if (params.object.material.empty())
    params.object.material = default_material(source, params.object.geometry);
  const DiffuseScene scene = make_diffuse_scene(source, params);
  save_text(options.out, format_blender_script(scene));
  fmt::print("{}: {} surfaces of {} meshes with {} triangles, {} spots, {} rectangle lights\n", scene.title,
             scene.surfaces.size(), scene.meshes.size(), count_triangles(scene), scene.spots.size(),
             scene.rectangles.size());
  if (scene.environment != Vec3{}) fmt::print("and an environment\n");
  const auto glossy = find_glossy_materials(scene);
  if (!glossy.empty()) fmt::print("left out, glossy part of: {}\n", fmt::join(glossy, ", "));
  fmt::print("{}\n", options.out.string());
  return kExitOk;
}

}  // namespace

void add_export(CLI::App& app, CommandLine& line) {
  auto options = std::make_shared<ExportOptions>();
  options->params.object = {"G0", "", Illumination::kIndirect};
  CLI::App* command =
      app.add_subcommand("export", "Write the diffuse version of a scene as a Python script for Blender");
  command->add_option("scene", options->scene_path, "Scene file")->required();
  command->add_option("--out", options->out, "Python file to write")->required();
  command->add_option("--geometry", options->params.object.geometry, "Geometry of the object (G0)");
  command->add_option("--material", options->params.object.material,
                      "Material whose diffuse part the object has (MS; a sculpture's own)");
  command->add_option("--illumination", options->illumination, "ind or dir")
      ->check(CLI::IsMember({"ind", "dir"}));
  command->add_option("--view", options->view, "v0 or v1")->check(CLI::IsMember({"v0", "v1"}));
  command->add_option("--width", options->params.width, "Pixels (560)")->check(CLI::Range(1, 16384));
  command->add_option("--height", options->params.height, "Pixels (420)")->check(CLI::Range(1, 16384));
  command->footer(
      "Example: equilux-render export stimuli/scenes/cafe.json --geometry G2 --material LG --out g2.py\n"
      "Then:    blender -b --python-exit-code 1 --python g2.py -- --samples 256 --seed 1 --out g2.exr");
  command->callback([&line, options] { line.command = [options] { return write_export(*options); }; });
}

}  // namespace equilux
