// equilux-render converge: what a minute buys, by every method.
#include <fmt/format.h>

#include "base/files.h"
#include "base/program.h"
#include "renderer/commands.h"
#include "renderer/converge.h"
#include "renderer/converge_format.h"
#include "renderer/converge_plot.h"
#include "renderer/scene_or_study.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

struct ConvergeOptions {
  fs::path input, out;
  std::vector<std::string> conditions;
  ConvergeParams params;
  int width = 0, height = 0, positions = 0;
  std::string most_vpls = "5M";
  bool no_plot = false;
};

ConvergeParams make_converge_params(const ConvergeOptions& options, const SceneOrStudy& input) {
  ConvergeParams params = options.params;
  const Study& study = input.study;
  params.source = input.name();
  params.width = options.width > 0 ? options.width : study.width;
  params.height = options.height > 0 ? options.height : study.height;
  params.positions = options.positions > 0 ? options.positions : study.subpixel_positions;
  params.emission = study.emission;
  params.tone = study.tone;
  params.pixels_per_degree = params.width / study.target_degrees_wide;
  params.ladders.clamp_levels = study.clamp_levels;
  const std::int64_t most = parse_vpl_count(options.most_vpls, "--most-vpls");
  for (auto* counts : {&params.ladders.plain_counts, &params.ladders.cut_counts})
    std::erase_if(*counts, [&](std::int64_t count) { return count > most; });
  return params;
}

void write_convergence(const Convergence& convergence, const ConvergeOptions& options) {
  const auto file = [&](const char* extension) { return options.out / (convergence.condition + extension); };
  save_convergence(convergence, file(".json"));
  save_text(file(".csv"), format_convergence_csv(convergence));
  const bool drawn = !options.no_plot && can_be_drawn(convergence);
  save_text(file(".md"), format_convergence_page(convergence, drawn ? convergence.condition + ".svg" : ""));
  if (!drawn) {  // what an earlier run drew
    fs::remove(file(".svg"));
    fs::remove(file(".png"));
  } else {
    draw_convergence(convergence, PlotFormat::kSvg, file(".svg"));
    draw_convergence(convergence, PlotFormat::kPng, file(".png"));
  }
  for (const std::string& what : convergence.left_out) fmt::print("left out: {}\n", what);
  fmt::print("{}: {}\n{}\n", convergence.condition, format_advice(convergence), file(".md").string());
  std::fflush(stdout);
}

int run_converge(const ConvergeOptions& options) {
  const SceneOrStudy input = load_scene_or_study(options.input);
  auto conditions = parse_scene_conditions(input, options.conditions);
  for (Condition& condition : conditions) condition.cell.normalised = false;  // measured both ways
  if (!options.no_plot) check_gnuplot();
  make_folder(options.out);
  for (const Condition& condition : conditions) {
    for (const char* extension : {".json", ".csv", ".md", ".svg", ".png"})
      check_writable(options.out / (format_key(condition) + extension));
  }
  for (const Condition& condition : conditions) {
    ConvergeParams params = make_converge_params(options, input);
    params.condition = condition;
    write_convergence(measure_convergence(input.scene, params), options);
  }
  return kExitOk;
}

}  // namespace

void add_converge(CLI::App& app, CommandLine& line) {
  auto options = std::make_shared<ConvergeOptions>();
  ConvergeParams& params = options->params;
  CLI::App* converge =
      app.add_subcommand("converge", "Measure error against run time of every method and setting");
  converge->add_option("input", options->input, "Scene or study file")->required();
  converge
      ->add_option(
          "--condition", options->conditions,
          "Keys such as G0-MS-ind-100k-C4-v0: object and view, and the number of VPLs and the clamp\n"
          "level of the curves that hold them fixed")
      ->required();
  converge
      ->add_option("--out", options->out,
                   "Folder for KEY.json, .csv, .md, .svg and .png; convergence/ in a study folder is "
                   "shown by its report")
      ->required();
  converge->add_option("--width", options->width, "Pixels (a study's own; of a scene 280)")
      ->check(CLI::Range(1, 16384));
  converge->add_option("--height", options->height, "Pixels (a study's own; of a scene 210)")
      ->check(CLI::Range(1, 16384));
  converge->add_option("--positions", options->positions, "Subpixel positions (a study's own; of a scene 2)")
      ->check(CLI::Range(1, 64));
  converge->add_option("--seeds", params.seeds, "Pictures of each setting, seed by seed (4)")
      ->check(CLI::Range(2, 1000));
  converge
      ->add_option(
          "--budget", params.budget_s,
          "Longest time of a picture of the curves, seconds (60); the first of each curve, reference and\n"
          "parts of the error take what they take")
      ->check(is_in_range(0.01, 1e6));
  converge->add_option("--seconds", params.asked_s, "Times for which advice is wanted (1 10 60)")
      ->expected(1, 100)
      ->check(is_in_range(0.001, 1e6));
  converge->add_option("--reference-paths", params.reference_paths, "Paths a pixel of the reference (8192)")
      ->check(CLI::Range(1, 1 << 20));
  converge->add_option("--most-vpls", options->most_vpls, "Of the curves over counts (5M)")->check(is_vpls());
  converge->add_flag("--no-plot", options->no_plot, "Draw no plots; gnuplot is then not needed");
  converge->add_option("--seed", params.seed, "First seed (1)")->check(is_seed());
  add_machine(*converge, line);
  converge->footer(
      "Example: equilux-render converge stimuli/scenes/cafe.json --condition G0-MS-ind-100k-C4-v0 --out "
      "convergence");
  converge->callback([&line, options] { line.command = [options] { return run_converge(*options); }; });
}

}  // namespace equilux
