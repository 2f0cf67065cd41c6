// equilux-render image: one picture of a scene.
#include <fmt/format.h>
#include <set>

#include "base/error.h"
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
  std::string illumination = "ind", method = "path", vpls = "100k", view = "v0", emission = "lambertian";
  std::vector<std::string> clamps{"C0"};
  int paths = 256;
  std::vector<double> noise_target;
  std::vector<float> camera;
  float fov_degrees = 40;
  std::filesystem::path out, png, error_png, layers;
};

// C4 for all objects, Vase=C4 for one.
struct ClampChoice {
  std::string object;  ///< empty: all
  std::string level;
};

ClampChoice split_clamp(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) return {"", text};
  return {text.substr(0, equals), text.substr(equals + 1)};
}

CLI::Validator is_object_clamp() {
  return CLI::Validator(
      [](const std::string& text) {
        const ClampChoice choice = split_clamp(text);
        if (text.starts_with('=')) return fmt::format("expected an object before the =, got {}", text);
        for (int level = 0; level < kClampLevelCount; ++level) {
          if (choice.level == format_clamp(level)) return std::string();
        }
        return fmt::format("expected a level, C0 to C{}, or OBJECT=LEVEL, got {}", kClampLevelCount - 1,
                           text);
      },
      "LEVEL|OBJECT=LEVEL", "clamp");
}

void set_clamps(const std::vector<std::string>& texts, PictureParams& params) {
  for (const std::string& text : texts) {
    const auto [object, level] = split_clamp(text);
    const double clamp = clamp_per_m2(parse_clamp_level(level, "--clamp"));
    if (object.empty()) {
      params.clamp_per_m2 = clamp;
    } else {
      params.clamps_by_object[object] = clamp;
    }
  }
}

Camera make_camera(const std::vector<float>& numbers, float fov_degrees) {
  const Camera camera{
      {numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]}, {0, 0, 1}, fov_degrees};
  const Vec3 forward = normalize(camera.target - camera.position);
  if (!(length(cross(forward, camera.up)) >= 1e-4f))
    throw InputError("--camera", "", "a target that is not above, below or at the position", "one");
  return camera;
}

PictureParams to_params(const ImageOptions& options) {
  PictureParams params = options.params;
  params.illumination = parse_illumination(options.illumination, "--illumination");
  params.view = options.view == "v1" ? 1 : 0;
  params.paths = {options.paths, options.paths, options.paths};
  if (!options.noise_target.empty()) {
    const auto& target = options.noise_target;
    params.noise_target = NoiseTarget{target[0], target[1], target[2]};
  }
  if (options.method == "vpl") {
    params.emission = options.emission == "full" ? Emission::kFull : Emission::kLambertian;
    params.vpl_count = parse_vpl_count(options.vpls, "--vpls");
    set_clamps(options.clamps, params);
  }
  if (!options.camera.empty()) params.camera = make_camera(options.camera, options.fov_degrees);
  return params;
}

ExrMetadata make_metadata(const ImageOptions& options) {
  return {{"equilux_method", options.method},
          {"equilux_seed", fmt::format("{}", options.params.seed)},
          {"equilux_version", kVersion},
          {"equilux_unit", "W/(m^2 sr)"}};
}

void add_clamp(ExrMetadata& metadata, const PictureParams& params, double clamp_per_m2) {
  if (params.vpl_count) metadata["equilux_clamp_per_m2"] = fmt::format("{}", clamp_per_m2);
}

// background.exr, and OBJECT.coverage.exr, OBJECT.direct.exr, OBJECT.indirect.exr for each object; where the
// last holds compensation, also that by itself.
void write_layers(const Picture& picture, const ImageOptions& options, const PictureParams& params) {
  const auto save = [&](const HdrImage& layer, const std::string& name, ExrMetadata metadata) {
    if (layer.channels == 1) metadata["equilux_unit"] = "1";  // coverage is a share
    save_exr(layer, std::move(metadata), options.layers / (name + ".exr"));
  };
  const ExrMetadata metadata = make_metadata(options);
  save(picture.background, "background", metadata);
  for (const ObjectLayers& object : picture.objects) {
    save(object.coverage, object.name + ".coverage", metadata);
    save(object.direct, object.name + ".direct", metadata);
    ExrMetadata clamped = metadata;
    add_clamp(clamped, params, object.clamp_per_m2);
    if (params.normalise) clamped["equilux_normalised"] = "to the unclamped layer's mean luminance";
    save(object.indirect, object.name + ".indirect", clamped);
    if (object.compensation) save(*object.compensation, object.name + ".compensation", clamped);
  }
}

void print_measures(const ObjectLayers& object) {
  if (!object.measures) return;
  const CutMeasures& cut = *object.measures;
  const ErrorSummary error = summarise_errors(cut.errors.front());
  fmt::print(
      "{}: lightcuts at ratio {:.3g} %, {:.0f} clusters a point, {} shadow rays; error at {} points against "
      "the "
      "{}: rms {:.2f} % ({:.2f} to {:.2f}), p99 {:.2f} %\n",
      object.name, 100 * cut.error_ratio, cut.mean_size, cut.rays, error.points,
      cut.against_plain_sum ? "plain sum" : "cuts of a twentieth", 100 * error.rms, 100 * error.rms_low,
      100 * error.rms_high, 100 * error.p99);
  if (cut.certified && !*cut.certified)
    fmt::print("warning: {}: not certified, more than 1 % of its points err by 1 % or more\n", object.name);
}

void print_picture(const Picture& picture, const PictureParams& params) {
  if (params.vpl_count) {
    fmt::print("VPLs: {}{}\n", picture.vpl_count,
               params.sets ? fmt::format(", mean of {} sets", picture.sets) : "");
    if (const std::string odd = tell_odd_count(*params.vpl_count, picture.vpl_count); !odd.empty())
      fmt::print("warning: {}\n", odd);
    for (const ObjectLayers& object : picture.objects)
      fmt::print("{}: clamped at {} / m^2{}\n", object.name, object.clamp_per_m2,
                 params.normalise    ? ", normalised"
                 : params.compensate ? ", compensated"
                                     : "");
    for (const ObjectLayers& object : picture.objects) print_measures(object);
  }
  fmt::print(
      "standard error of the path-traced parts{}, steps of 255: object mean {:.2f}, p99 {:.2f}; outside mean "
      "{:.2f}\n",
      params.sets ? " and the VPL sets" : "", picture.noise.object_mean, picture.noise.object_p99,
      picture.noise.outside_mean);
  fmt::print("paths a pixel: {:.0f}\n",
             picture.paths / (static_cast<double>(params.width) * static_cast<double>(params.height)));
}

// Before hours of work: each can be written, and none over the scene or another.
void check_outputs(const ImageOptions& options) {
  std::set<std::filesystem::path> taken{std::filesystem::weakly_canonical(options.params.scene_path)};
  for (const auto& [option, path] :
       {std::pair{"--out", options.out}, {"--png", options.png}, {"--error-png", options.error_png}}) {
    if (path.empty()) continue;
    if (!taken.insert(std::filesystem::weakly_canonical(path)).second)
      throw InputError(option, path.string(), "a file of its own",
                       "the scene, or what another option writes");
    check_writable(path);
  }
  if (options.layers.empty()) return;
  make_folder(options.layers);
  check_writable(options.layers / "background.exr");
}

int write_image(const ImageOptions& options) {
  const PictureParams params = to_params(options);
  check_outputs(options);
  const Picture picture = make_picture(params);
  ExrMetadata metadata = make_metadata(options);
  if (picture.objects.size() == 1) add_clamp(metadata, params, picture.objects.front().clamp_per_m2);
  save_exr(picture.image, metadata, options.out);
  if (!options.png.empty()) save_png(picture.display, options.png);
  if (!options.error_png.empty()) save_png(picture.noise_display, options.error_png);
  if (!options.layers.empty()) write_layers(picture, options, params);
  print_picture(picture, params);
  fmt::print("{}\n", options.out.string());
  return kExitOk;
}

}  // namespace

void add_image(CLI::App& app, CommandLine& line) {
  auto options = std::make_shared<ImageOptions>();
  CLI::App* image = app.add_subcommand("image", "Render one picture of a scene to EXR");
  image->add_option("scene", options->params.scene_path, "Scene file")->required();
  image->add_option("--out", options->out, "EXR file to write")->required();
  image->add_option("--png", options->png, "PNG to write too, through the tone curve of its own background");
  image->add_option("--tone-key", options->params.tone.key, "Key of that curve (0.18)")
      ->check(is_in_range(1e-6, 10));
  image
      ->add_option("--tone-operator", options->params.tone.operation,
                   "global, or local: each pixel by the luminance around it (global)")
      ->transform(CLI::CheckedTransformer(std::map<std::string, ToneOperator>{
          {"global", ToneOperator::kGlobal}, {"local", ToneOperator::kLocal}}));
  image->add_option("--error-png", options->error_png,
                    "PNG of the path-traced parts' standard error, 51 grey levels a displayed step");
  image->add_option("--layers", options->layers,
                    "Folder for the background and each object's coverage, direct and indirect light, EXR");
  image->add_option(
      "--geometry", options->params.geometry,
      "Geometry of the object (G0); of a scene with sculptures, the one that is the object (all)");
  image->add_option("--material", options->params.material, "Material of the object (MS; a sculpture's own)");
  image->add_option("--illumination", options->illumination, "ind or dir")
      ->check(CLI::IsMember({"ind", "dir"}));
  image->add_option("--view", options->view, "v0 or v1")->check(CLI::IsMember({"v0", "v1"}));
  image->add_option("--method", options->method, "path, or vpl: VPLs light the object")
      ->check(CLI::IsMember({"path", "vpl"}));
  const std::vector<CLI::Option*> of_vpls = {
      image->add_option("--vpls", options->vpls, "Number of VPLs (100k)")->check(is_vpls()),
      image->add_option("--clamp", options->clamps, "Clamp level (C0, none), or OBJECT=LEVEL for one object")
          ->check(is_object_clamp()),
      image->add_flag("--normalise", options->params.normalise,
                      "Scale each object's clamped light to the mean luminance of its unclamped light"),
      image
          ->add_option("--sets", options->params.sets,
                       "Mean of so many independent VPL sets, two a subpixel position or more, whose spread "
                       "is its error")
          ->check(CLI::Range(1, 10000))
          ->excludes("--normalise"),
      image
          ->add_flag("--compensate", options->params.compensate,
                     "Add by paths, --paths or --noise-target of them, what each object's clamp takes")
          ->excludes("--normalise"),
      image
          ->add_flag("--certified", options->params.certified,
                     "Refine lightcuts until 99 % of the points measured err by under 1 %")
          ->excludes("--sets"),
      image->add_option("--emission", options->emission, "Of VPLs: lambertian, the diffuse part, or full")
          ->check(CLI::IsMember({"lambertian", "full"}))};
  CLI::Option* camera =
      image->add_option("--camera", options->camera, "In place of the view: position and target, six numbers")
          ->expected(6)
          ->check(is_in_range(-1e9, 1e9));
  image->add_option("--fov", options->fov_degrees, "Vertical field of view with --camera, degrees (40)")
      ->check(is_in_range(0.01, 170))
      ->needs(camera);
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
      ->check(is_in_range(0.01, 255));
  image->add_option("--seed", options->params.seed, "Seed, 0 to 9223372036854775807 (1)")->check(is_seed());
  add_machine(*image, line);
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
