// equilux-render image: one picture of a scene.
#include <fmt/format.h>

#include "base/files.h"
#include "base/program.h"
#include "base/version.h"
#include "renderer/commands.h"
#include "renderer/picture.h"
#include "stimuli/exr_file.h"
#include "stimuli/png_file.h"

namespace equilux {
namespace {

struct ImageOptions {
  PictureParams params;
  std::string illumination = "ind", method = "path", vpls = "100k", clamp = "C0", view = "v0",
              emission = "lambertian";
  int paths = 256;
  std::vector<double> noise_target;
  std::filesystem::path out, png, error_png;
};

CLI::Validator is_vpls() {
  return CLI::Validator(
      [](const std::string& text) {
        return is_vpl_count(text) ? std::string()
                                  : fmt::format("expected a count such as 1k, 100k or 5M, got {}", text);
      },
      "COUNT", "vpls");
}

CLI::Validator is_clamp() {
  std::vector<std::string> levels;
  for (int level = 0; level < kClampLevelCount; ++level) levels.push_back(format_clamp(level));
  return CLI::IsMember(levels);
}

PictureParams to_params(const ImageOptions& options) {
  PictureParams params = options.params;
  params.object.illumination = parse_illumination(options.illumination, "--illumination");
  params.view = options.view == "v1" ? 1 : 0;
  params.paths = {options.paths, options.paths, options.paths};
  if (!options.noise_target.empty()) {
    const auto& target = options.noise_target;
    params.noise_target = NoiseTarget{target[0], target[1], target[2]};
  }
  if (options.method == "vpl") {
    params.emission = options.emission == "full" ? Emission::kFull : Emission::kLambertian;
    params.vpl_count = parse_vpl_count(options.vpls, "--vpls");
    params.clamp_per_m2 = clamp_per_m2(parse_clamp_level(options.clamp, "--clamp"));
  }
  return params;
}

int write_image(const ImageOptions& options) {
  const PictureParams params = to_params(options);
  check_writable(options.out);
  for (const auto& path : {options.png, options.error_png}) {
    if (!path.empty()) check_writable(path);
  }
  const Picture picture = make_picture(params);
  ExrMetadata metadata{{"equilux_method", options.method},
                       {"equilux_seed", fmt::format("{}", params.seed)},
                       {"equilux_version", kVersion},
                       {"equilux_unit", "W/(m^2 sr)"}};
  if (params.vpl_count) metadata["equilux_clamp_per_m2"] = fmt::format("{}", params.clamp_per_m2);
  save_exr(picture.image, metadata, options.out);
  if (!options.png.empty()) save_png(picture.display, options.png);
  if (!options.error_png.empty()) save_png(picture.noise_display, options.error_png);
  if (params.vpl_count) fmt::print("VPLs: {}\n", picture.vpl_count);
  fmt::print(
      "standard error of the path-traced parts, steps of 255: object mean {:.2f}, p99 {:.2f}; outside mean "
      "{:.2f}\n",
      picture.noise.object_mean, picture.noise.object_p99, picture.noise.outside_mean);
  fmt::print("paths a pixel: {:.0f}\n",
             picture.paths / (static_cast<double>(params.width) * static_cast<double>(params.height)));
  fmt::print("{}\n", options.out.string());
  return kExitOk;
}

}  // namespace

void add_image(CLI::App& app, CommandLine& line) {
  auto options = std::make_shared<ImageOptions>();
  options->params.object = {"G0", "MS", Illumination::kIndirect};
  CLI::App* image = app.add_subcommand("image", "Render one picture of a scene to EXR");
  image->add_option("scene", options->params.scene_path, "Scene file")->required();
  image->add_option("--out", options->out, "EXR file to write")->required();
  image->add_option("--png", options->png, "PNG to write too, through the tone curve of its own background");
  image->add_option("--error-png", options->error_png,
                    "PNG of the path-traced parts' standard error, 51 grey levels a displayed step");
  image->add_option("--geometry", options->params.object.geometry, "Geometry of the object (G0)");
  image->add_option("--material", options->params.object.material, "Material of the object (MS)");
  image->add_option("--illumination", options->illumination, "ind or dir")
      ->check(CLI::IsMember({"ind", "dir"}));
  image->add_option("--view", options->view, "v0 or v1")->check(CLI::IsMember({"v0", "v1"}));
  image->add_option("--method", options->method, "path, or vpl: VPLs light the object")
      ->check(CLI::IsMember({"path", "vpl"}));
  const std::vector<CLI::Option*> of_vpls = {
      image->add_option("--vpls", options->vpls, "Number of VPLs (100k)")->check(is_vpls()),
      image->add_option("--clamp", options->clamp, "Clamp level (C0, none)")->check(is_clamp()),
      image->add_option("--emission", options->emission, "Of VPLs: lambertian, the diffuse part, or full")
          ->check(CLI::IsMember({"lambertian", "full"}))};
  image->add_option("--width", options->params.width, "Pixels (560)")->check(CLI::Range(1, 16384));
  image->add_option("--height", options->params.height, "Pixels (420)")->check(CLI::Range(1, 16384));
  image->add_option("--positions", options->params.positions, "Subpixel positions (4)")
      ->check(CLI::Range(1, 64));
  image->add_option("--paths", options->paths, "Monte Carlo paths a pixel (256)")
      ->check(CLI::Range(1, 1000000));
  image
      ->add_option(
          "--noise-target", options->noise_target,
          "In place of --paths: standard error in steps of 255, object mean, object p99, outside mean")
      ->expected(3)
      ->check(CLI::Range(0.01, 255.0));
  image->add_option("--seed", options->params.seed, "Seed, 0 to 9223372036854775807 (1)")->check(is_seed());
  add_threads(*image, line);
  image->footer(
      "Example: equilux-render image stimuli/scenes/cafe.json --geometry G2 --material MS --method vpl "
      "--vpls 1k "
      "--clamp C4 --out g2.exr --png g2.png");
  image->callback([&line, options, of_vpls] {
    for (const CLI::Option* option : of_vpls) {
      if (options->method == "path" && option->count() > 0) {
        throw CLI::ValidationError(option->get_name(), "only VPL pictures have it; give --method vpl");
      }
    }
    line.command = [options] { return write_image(*options); };
  });
}

}  // namespace equilux
