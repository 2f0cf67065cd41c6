// peer_compare: reads a folder of pictures by both renderers, prints where they agree; leaves with 1 if
// anywhere they do not.
#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fstream>
#include <map>
#include <sstream>

#include "base/error.h"
#include "base/program.h"
#include "renderer/primary.h"
#include "stimuli/exr_file.h"
#include "tests/peer/compare.h"

namespace {

using namespace equilux;
using namespace equilux::test;
namespace fs = std::filesystem;

constexpr int kColumns = 4, kRows = 3;
constexpr const char* kChannels = "RGB";

struct Options {
  fs::path scene_path, folder;
  double level = 0.01;  ///< of all tests together
  double scale = 1;     ///< of our pictures: a mutant when it is not 1
};

struct Seconds {
  double wall = 0, processor = 0;
};

/// Pictures of one family by both renderers; seconds of the mean picture.
struct Case {
  Family family;
  Pictures ours, theirs;
  Seconds our_seconds, their_seconds;
};

// shape of seconds.txt: lines "FAMILY ours|cycles SEED WALL PROCESSOR"; the picture is FAMILY-ours-SEED.exr.
std::map<std::string, Case> load_cases(const fs::path& folder) {
  std::ifstream stream(folder / "seconds.txt");
  std::map<std::string, Case> cases;
  for (std::string line; std::getline(stream, line);) {
    std::istringstream words(line);
    std::string family, renderer, seed;
    Seconds seconds;
    if (!(words >> family >> renderer >> seed >> seconds.wall >> seconds.processor))
      throw InputError((folder / "seconds.txt").string(), "", "family, renderer, seed, two times", line);
    Case& found = cases[family];
    found.family = parse_family(family, "seconds.txt");
    const bool ours = renderer == "ours";
    (ours ? found.ours : found.theirs)
        .push_back(load_exr(folder / fmt::format("{}-{}-{}.exr", family, renderer, seed)).image);
    Seconds& sum = ours ? found.our_seconds : found.their_seconds;
    sum.wall += seconds.wall;
    sum.processor += seconds.processor;
  }
  for (auto& [family, found] : cases) {
    for (const Pictures* pictures : {&found.ours, &found.theirs}) {
      if (pictures->size() < 2)
        throw InputError(folder.string(), family, "at least two pictures of each renderer", "fewer");
    }
  }
  if (cases.empty()) throw InputError((folder / "seconds.txt").string(), "", "pictures", "none");
  return cases;
}

void scale_pictures(Pictures& pictures, double factor) {
  for (HdrImage& picture : pictures) {
    for (float& value : picture.values) value = static_cast<float>(double{value} * factor);
  }
}

HdrImage find_coverage(const Scene& scene, const Case& found) {
  const HdrImage& picture = found.ours.front();
  const World world = make_world(scene, found.family.object.geometry, found.family.object.illumination);
  return make_coverage(
      trace_primary(world, make_view_camera(scene, found.family.view), picture.width, picture.height, 16));
}

struct Verdict {
  int tests = 0, disagreements = 0;
  double largest_difference = 0, largest_t = 0, largest_visible_bias = 0;
};

void print_agreements(const std::vector<Agreement>& agreements, double level, Verdict& verdict) {
  fmt::print("| region | | ours | Cycles | difference, % | standard errors, % | t | sees, % |\n");
  fmt::print("|---|---|---|---|---|---|---|---|\n");
  for (const Agreement& row : agreements) {
    const double visible = row.visible_bias(level);
    fmt::print("| {} | {} | {:.5f} | {:.5f} | {:+.3f} | {:.3f}, {:.3f} | {:+.2f}{} | {:.2f} |\n", row.region,
               kChannels[row.channel], row.ours.mean, row.theirs.mean, 100 * row.relative_difference(),
               100 * row.ours.standard_error / row.ours.mean,
               100 * row.theirs.standard_error / row.theirs.mean, row.t, row.p < level ? " DIFFER" : "",
               100 * visible);
    ++verdict.tests;
    verdict.disagreements += row.p < level;
    verdict.largest_difference = std::max(verdict.largest_difference, std::abs(row.relative_difference()));
    verdict.largest_t = std::max(verdict.largest_t, std::abs(row.t));
    verdict.largest_visible_bias = std::max(verdict.largest_visible_bias, visible);
  }
}

void print_error(const char* name, double error, const Seconds& sum, std::size_t pictures) {
  const auto count = static_cast<double>(pictures);
  const double processor = sum.processor / count;
  fmt::print("| {} | {} | {:.1f} | {:.1f} | {:.2f} | {:.2f} |\n", name, pictures, sum.wall / count, processor,
             100 * error, 100 * error * std::sqrt(processor / 20));
}

void print_errors(const Case& found) {
  fmt::print("\n| | pictures | seconds | processor seconds | error, % | at 20 processor seconds, % |\n");
  fmt::print("|---|---|---|---|---|---|\n");
  print_error("ours", measure_pixel_error(found.ours, found.theirs), found.our_seconds, found.ours.size());
  print_error("Cycles", measure_pixel_error(found.theirs, found.ours), found.their_seconds,
              found.theirs.size());
}

int compare(const Options& options) {
  const Scene scene = load_scene(options.scene_path);
  auto cases = load_cases(options.folder);
  const double tests = static_cast<double>(cases.size()) * (kColumns * kRows + 2) * 3;
  Verdict verdict;
  for (auto& [family, found] : cases) {
    scale_pictures(found.ours, options.scale);
    fmt::print("\n## {}\n", family);
    const auto regions = make_regions(find_coverage(scene, found), kColumns, kRows);
    print_agreements(compare_regions(found.ours, found.theirs, regions), options.level / tests, verdict);
    print_errors(found);
  }
  fmt::print(
      "\n{} of {} means differ by more than {} % at the level {} over all. Largest difference {:.3f} %, "
      "largest |t| {:.2f}; a "
      "bias "
      "of {:.2f} % is seen everywhere in 95 of 100 runs.\n",
      verdict.disagreements, verdict.tests, 100 * kMargin, options.level, 100 * verdict.largest_difference,
      verdict.largest_t, 100 * verdict.largest_visible_bias);
  return verdict.disagreements == 0 ? kExitOk : kExitError;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Compares the pictures of two renderers region by region", "peer_compare");
  Options options;
  app.add_option("scene", options.scene_path, "Scene file")->required();
  app.add_option("folder", options.folder, "Folder of pictures with its seconds.txt")->required();
  app.add_option("--level", options.level, "Level of all tests together (.01)");
  app.add_option("--scale", options.scale, "Factor on our pictures: a mutant (1)");
  CLI11_PARSE(app, argc, argv);
  return run_program("peer_compare", [&] { return compare(options); });
}
