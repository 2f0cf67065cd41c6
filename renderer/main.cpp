// equilux-render: makes stimuli.
#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "base/error.h"
#include "base/files.h"
#include "base/program.h"
#include "base/version.h"
#include "renderer/parallel.h"
#include "renderer/picture.h"
#include "renderer/set.h"
#include "stimuli/exr_file.h"
#include "stimuli/png_file.h"

namespace {

using namespace equilux;
namespace fs = std::filesystem;

// Whole numbers that every file can hold; CLI11 alone would wrap or cut others.
CLI::Validator is_seed() {
  return CLI::Validator(
      [](const std::string& text) {
        const std::string largest = "9223372036854775807";
        const bool digits = !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
        const bool fits = text.size() < largest.size() || (text.size() == largest.size() && text <= largest);
        return digits && fits ? std::string() : fmt::format("expected 0 to {}, got {}", largest, text);
      },
      "SEED", "seed");
}

void add_set(CLI::App& app, std::function<int()>& command, int& threads) {
  auto params = std::make_shared<SetParams>();
  CLI::App* set =
      app.add_subcommand("set", "Render and tone-map the stimulus set of a study; goes on where it stopped");
  set->add_option("study", params->study_path, "Study file")->required();
  set->add_option("--out", params->folder, "Study folder to make or complete")->required();
  set->add_option("--only", params->only, "Glob over keys of pictures and references");
  set->add_option("--threads", threads, "Threads; 0 for all cores")->check(CLI::Range(0, 4096));
  set->footer("Example: equilux-render set protocols/pocket.json --out studies/pocket --only 'G0-MS-*'");
  set->callback([&command, params] {
    command = [params] {
      fmt::print("{}", format_summary(make_set(*params)));
      fmt::print("\n{}\n", params->folder.string());
      return kExitOk;
    };
  });
}

void add_tonemap(CLI::App& app, std::function<int()>& command) {
  auto folder = std::make_shared<fs::path>();
  auto only = std::make_shared<std::string>("*");
  CLI::App* tonemap = app.add_subcommand("tonemap", "Make the pictures of a study folder from its layers");
  tonemap->add_option("folder", *folder, "Study folder")->required();
  tonemap->add_option("--only", *only, "Glob over keys of pictures and references");
  tonemap->footer("Example: equilux-render tonemap studies/pocket");
  tonemap->callback([&command, folder, only] {
    command = [folder, only] {
      fmt::print("{}", format_summary(tonemap_set(*folder, *only)));
      return kExitOk;
    };
  });
}

struct ImageOptions {
  PictureParams params;
  std::string illumination = "ind", method = "path", vpls = "100k", clamp = "C0", view = "v0";
  int paths = 256;
  fs::path out, png;
};

PictureParams to_params(const ImageOptions& options) {
  PictureParams params = options.params;
  params.object.illumination = parse_illumination(options.illumination, "--illumination");
  params.view = options.view == "v1" ? 1 : 0;
  params.paths = {options.paths, options.paths, options.paths};
  if (options.method == "vpl") {
    params.vpl_count = parse_vpl_count(options.vpls, "--vpls");
    params.clamp_per_m2 = clamp_per_m2(parse_clamp_level(options.clamp, "--clamp"));
  }
  return params;
}

int write_image(const ImageOptions& options) {
  const PictureParams params = to_params(options);
  check_writable(options.out);
  if (!options.png.empty()) check_writable(options.png);
  const Picture picture = make_picture(params);
  ExrMetadata metadata{{"equilux_method", options.method},
                       {"equilux_seed", fmt::format("{}", params.seed)},
                       {"equilux_version", kVersion},
                       {"equilux_unit", "W/(m^2 sr)"}};
  if (params.vpl_count) metadata["equilux_clamp_per_m2"] = fmt::format("{}", params.clamp_per_m2);
  save_exr(picture.image, metadata, options.out);
  if (!options.png.empty()) save_png(picture.display, options.png);
  if (params.vpl_count) fmt::print("VPLs: {}\n", picture.vpl_count);
  fmt::print(
      "standard error of the path-traced parts, steps of 255: object mean {:.2f}, p99 {:.2f}; outside mean "
      "{:.2f}\n",
      picture.noise.object_mean, picture.noise.object_p99, picture.noise.outside_mean);
  fmt::print("{}\n", options.out.string());
  return kExitOk;
}

void add_image(CLI::App& app, std::function<int()>& command, int& threads) {
  auto options = std::make_shared<ImageOptions>();
  options->params.object = {"G0", "MS", Illumination::kIndirect};
  CLI::App* image = app.add_subcommand("image", "Render one picture of a scene to EXR");
  image->add_option("scene", options->params.scene_path, "Scene file")->required();
  image->add_option("--out", options->out, "EXR file to write")->required();
  image->add_option("--png", options->png, "PNG to write too, through the tone curve of its own background");
  image->add_option("--geometry", options->params.object.geometry, "Geometry of the object (G0)");
  image->add_option("--material", options->params.object.material, "Material of the object (MS)");
  image->add_option("--illumination", options->illumination, "ind or dir")
      ->check(CLI::IsMember({"ind", "dir"}));
  image->add_option("--view", options->view, "v0 or v1")->check(CLI::IsMember({"v0", "v1"}));
  image->add_option("--method", options->method, "path, or vpl: VPLs light the object")
      ->check(CLI::IsMember({"path", "vpl"}));
  image->add_option("--vpls", options->vpls, "Number of VPLs, such as 100k");
  image->add_option("--clamp", options->clamp, "Clamp level C0 .. C10");
  image->add_option("--width", options->params.width, "Pixels (560)")->check(CLI::Range(1, 16384));
  image->add_option("--height", options->params.height, "Pixels (420)")->check(CLI::Range(1, 16384));
  image->add_option("--positions", options->params.positions, "Subpixel positions (4)")
      ->check(CLI::Range(1, 64));
  image->add_option("--paths", options->paths, "Monte Carlo paths a pixel (256)")
      ->check(CLI::Range(1, 1000000));
  image->add_option("--seed", options->params.seed, "Seed, 0 to 9223372036854775807 (1)")->check(is_seed());
  image->add_option("--threads", threads, "Threads; 0 for all cores")->check(CLI::Range(0, 4096));
  image->footer(
      "Example: equilux-render image stimuli/scenes/cafe.json --geometry G2 --material MS --method vpl "
      "--vpls 1k "
      "--clamp C4 --out g2.exr --png g2.png");
  image->callback([&command, options] { command = [options] { return write_image(*options); }; });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Makes stimuli: path-traced references and VPL pictures of a study's conditions",
               "equilux-render");
  app.set_version_flag("--version", std::string("equilux-render ") + equilux::kVersion);
  app.require_subcommand(1);
  app.footer("Example: equilux-render set protocols/pocket.json --out studies/pocket");
  std::function<int()> command;
  int threads = 0;
  add_set(app, command, threads);
  add_image(app, command, threads);
  add_tonemap(app, command);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kExitOk : kExitUsage;
  }
  return run_program("equilux-render", [&] {
    const ThreadLimit limit(threads);
    return command();
  });
}
