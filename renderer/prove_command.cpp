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

// Per cent of nothing are not printed.
void print_dark_row(const Object& object, const Proof& proof) {
  const std::string vpls = proof.full.mean > 0 ? fmt::format("no path met light; full {:.5g} +- {:.5g}",
                                                             proof.full.mean, proof.full.standard_error)
                                               : "no indirect light";
  fmt::print("{:<14}{:>12}  {}\n", format_key(object), 0, vpls);
  std::fflush(stdout);
}

void print_row(const Object& object, const Proof& proof) {
  if (!(proof.paths.mean > 0)) return print_dark_row(object, proof);
  const auto full = find_relative_difference(proof.full, proof.paths);
  fmt::print("{:<14}{:>12.5g}{:>9.2f}{:>11.2f}{:>9.2f}{:>8.2f}{:>10.2f}{:>11.3f}{:>9.3f}\n",
             format_key(object), proof.paths.mean, 100 * proof.paths.standard_error / proof.paths.mean,
             100 * full.mean, 100 * full.standard_error, full.mean / full.standard_error,
             100 * kErrorsToSee * full.standard_error, 100 * proof.gap.mean / proof.paths.mean,
             100 * proof.gap.standard_error / proof.paths.mean);
  std::fflush(stdout);
}

int write_proof(const ProveOptions& options) {
  const Scene scene = load_scene(options.scene);
  std::vector<MaterialSpec> materials;
  for (const std::string& name : options.materials) materials.push_back(find_material(scene, name));
  ProofParams params = options.params;
  params.illumination = parse_illumination(options.illumination, "--illumination");
  fmt::print(
      "Mean luminance of the object's indirect light, path traced, and in per cent of it: the difference of "
      "C0 "
      "with\nfull emission, with its standard error over {} VPL sets and {} more of VPLs that the object had "
      "a part in;\n`sees`, the bias that this run finds with 90 % power at level 1 %; and the gap, by which "
      "Lambertian emission\nof the same VPLs falls short of full.\n\n",
      params.sets, params.own_sets);
  fmt::print("{:<14}{:>12}{:>9}{:>11}{:>9}{:>8}{:>10}{:>11}{:>9}\n", "object", "path traced", "error", "full",
             "error", "t", "sees", "gap", "error");
  for (const std::string& geometry : options.geometries) {
    params.geometry = geometry;
    const auto proofs = make_proofs(scene, materials, params);
    for (std::size_t i = 0; i < proofs.size(); ++i)
      print_row({geometry, options.materials[i], params.illumination}, proofs[i]);
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
  prove->add_option("--sets", params.sets, "Independent VPL sets (256)")->check(CLI::Range(2, 1000000));
  prove
      ->add_option(
          "--own-sets", params.own_sets,
          "Sets of which only the VPLs are summed that the object had a part in; for materials\nother "
          "than MS in proportion to rho_s / alpha (256)")
      ->check(CLI::Range(2, 1000000));
  prove->add_option("--vpl-paths", params.vpl_paths, "Particles of each set (4000)")
      ->check(CLI::Range(1, 1000000000));
  prove->add_option("--camera-paths", params.camera_paths, "Paths at each point (256)")
      ->check(CLI::Range(1, 1 << 25));
  prove
      ->add_option("--band", params.contact_band,
                   "Share of the object's height above its contact that is left out (0.3)")
      ->check(is_in_range(0, 0.99));
  prove->add_option("--seed", params.seed, "First seed (1)")->check(is_seed());
  add_machine(*prove, line);
  prove->footer("Example: equilux-render prove stimuli/scenes/proof-room.json --geometry G2 --material MR");
  prove->callback([&line, options] { line.command = [options] { return write_proof(*options); }; });
}

}  // namespace equilux
