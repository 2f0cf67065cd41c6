// equilux-render describe: what is in a scene, how its objects are shaped, and what reaches them.
#include <fmt/format.h>

#include "base/program.h"
#include "renderer/commands.h"
#include "renderer/describe.h"

namespace equilux {
namespace {

struct DescribeOptions {
  std::filesystem::path scene;
  DescribeParams params;
};

int write_description(const DescribeOptions& options) {
  fmt::print("{}", format_description(describe_scene(load_scene(options.scene), options.params)));
  return kExitOk;
}

}  // namespace

void add_describe(CLI::App& app, CommandLine& line) {
  auto options = std::make_shared<DescribeOptions>();
  DescribeParams& params = options->params;
  CLI::App* describe = app.add_subcommand(
      "describe", "Say what a scene holds: counts, shapes, which lights reach the object, clamp distances");
  describe->add_option("scene", options->scene, "Scene file")->required();
  describe->add_option("--geometry", params.geometries, "Geometries of the object (all)")->delimiter(',');
  describe
      ->add_option("--material", params.materials,
                   "Materials for the clamp levels (the study's, or else the scene's glossy ones)")
      ->delimiter(',');
  describe->add_option("--points", params.points, "Points of each object that rays are sent from (4096)")
      ->check(CLI::Range(1, 10000000));
  describe->add_option("--seed", params.seed, "Seed (1)")->check(is_seed());
  add_machine(*describe, line);
  describe->footer("Example: equilux-render describe stimuli/scenes/cafe.json --geometry G0,G3");
  describe->callback([&line, options] { line.command = [options] { return write_description(*options); }; });
}

}  // namespace equilux
