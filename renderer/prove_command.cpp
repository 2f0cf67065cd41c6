// equilux-render prove: do VPLs and the path tracer agree in this scene?
#include <cmath>
#include <fmt/format.h>

#include "base/program.h"
#include "renderer/commands.h"
#include "renderer/proof.h"

namespace equilux {
namespace {

// A bias of this many standard errors is found with 90 % power at level 1 %, two-sided: 2.58 + 1.28.
constexpr double kErrorsToSee = 3.86;

struct ProveOptions {
  std::filesystem::path scene;
  std::vector<std::string> geometries{"G0"}, materials{"MS"};
  std::string illumination = "ind";
  ProofParams params;
};

void print_row(const Object& object, const Proof& proof) {
  const auto full = find_relative_difference(proof.full, proof.paths);
  const auto lambertian = find_relative_difference(proof.lambertian, proof.paths);
  fmt::print("{:<14}{:>12.5g}{:>9.2f}{:>11.2f}{:>9.2f}{:>8.2f}{:>10.2f}{:>11.2f}{:>9.2f}\n",
             format_key(object), proof.paths.mean, 100 * proof.paths.standard_error / proof.paths.mean,
             100 * full.mean, 100 * full.standard_error, full.mean / full.standard_error,
             100 * kErrorsToSee * full.standard_error, 100 * lambertian.mean,
             100 * lambertian.standard_error);
  std::fflush(stdout);
}

int write_proof(const ProveOptions& options) {
  const Scene scene = load_scene(options.scene);
  fmt::print(
      "Mean luminance of the object's indirect light; differences of C0 from the path tracer in per cent, "
      "with\n"
      "standard errors over {} VPL sets. `sees`: the bias that this run finds with 90 % power at level 1 "
      "%.\n\n",
      kProofGroups * options.params.repeats);
  fmt::print("{:<14}{:>12}{:>9}{:>11}{:>9}{:>8}{:>10}{:>11}{:>9}\n", "object", "path traced", "error", "full",
             "error", "t", "sees", "lambertian", "error");
  for (const std::string& geometry : options.geometries) {
    for (const std::string& material : options.materials) {
      ProofParams params = options.params;
      params.with_lambertian = true;
      params.object = {geometry, material, parse_illumination(options.illumination, "--illumination")};
      print_row(params.object, make_proof(scene, find_material(scene, material), params));
    }
  }
  return kExitOk;
}

}  // namespace

void add_prove(CLI::App& app, CommandLine& line) {
  auto options = std::make_shared<ProveOptions>();
  ProofParams& params = options->params;
  CLI::App* prove =
      app.add_subcommand("prove", "Compare the unclamped VPL sum with the path tracer, both emissions");
  prove->add_option("scene", options->scene, "Scene file")->required();
  prove->add_option("--geometry", options->geometries, "Geometries of the object (G0)")->delimiter(',');
  prove->add_option("--material", options->materials, "Materials of the object (MS)")->delimiter(',');
  prove->add_option("--illumination", options->illumination, "ind or dir")
      ->check(CLI::IsMember({"ind", "dir"}));
  prove->add_option("--repeats", params.repeats, "Independent VPL sets for each of 64 groups of points (4)")
      ->check(CLI::Range(2, 1000000));
  prove->add_option("--vpl-paths", params.vpl_paths, "Particles of each set (4000)")
      ->check(CLI::Range(1, 1000000000));
  prove->add_option("--camera-paths", params.camera_paths, "Paths at each point (1000)")
      ->check(CLI::Range(1, 1000000000));
  prove
      ->add_option("--band", params.contact_band,
                   "Share of the object's height above its contact that is left out (0.3)")
      ->check(CLI::Range(0.0, 0.99));
  prove->add_option("--seed", params.seed, "First seed (1)")->check(is_seed());
  add_threads(*prove, line);
  prove->footer("Example: equilux-render prove stimuli/scenes/proof-room.json --geometry G2 --material MR");
  prove->callback([&line, options] { line.command = [options] { return write_proof(*options); }; });
}

}  // namespace equilux
