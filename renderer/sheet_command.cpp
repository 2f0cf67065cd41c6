// equilux-render sheet: the pictures of a study side by side.
#include <algorithm>
#include <fmt/format.h>
#include <map>

#include "base/program.h"
#include "renderer/commands.h"
#include "renderer/make_sheet.h"
#include "stimuli/study_folder.h"

namespace equilux {
namespace {

struct SheetOptions {
  SheetRequest request;
  std::string kind = "clamp", view = "v0", illumination;
  std::vector<std::string> levels, vpls;
};

const std::map<std::string, SheetKind> kKinds = {{"clamp", SheetKind::kClamp},
                                                 {"references", SheetKind::kReferences},
                                                 {"difference", SheetKind::kDifference},
                                                 {"error", SheetKind::kError}};

SheetRequest to_request(const SheetOptions& options) {
  SheetRequest request = options.request;
  request.params.kind = kKinds.at(options.kind);
  request.params.view = options.view == "v1" ? 1 : 0;
  if (!options.illumination.empty())
    request.params.illumination = parse_illumination(options.illumination, "--illumination");
  for (const std::string& level : options.levels)
    request.params.clamp_levels.push_back(parse_clamp_level(level, "--levels"));
  for (const std::string& count : options.vpls)
    request.params.vpl_counts.push_back(parse_vpl_count(count, "--vpls"));
  return request;
}

// Where no name is given: in the study folder, by what is on it.
void name_files(const SheetOptions& options, SheetRequest& request) {
  if (!request.out.empty()) return;
  std::string name = "sheet-" + options.kind;
  for (const std::string& part : {request.params.object, options.illumination, options.view})
    if (!part.empty()) name += "-" + part;
  request.out = request.folder / (name + ".png");
  if (request.html.empty()) request.html = request.folder / (name + ".html");
}

int write_sheet(const SheetOptions& options) {
  SheetRequest request = to_request(options);
  load_folder_study({request.folder});  // before its name is taken for that of a file
  name_files(options, request);
  const SheetSummary summary = make_sheet(request);
  fmt::print("{} pictures, {} not rendered; {} x {} pixels\n", summary.pictures, summary.missing,
             summary.width, summary.height);
  fmt::print("{}\n", request.out.string());
  if (!request.html.empty()) fmt::print("{}\n", request.html.string());
  return kExitOk;
}

// Options of some kinds only; others say so rather than pass them over.
struct KindOption {
  const CLI::Option* option;
  std::vector<std::string> kinds;
};

void check_kind(const std::string& kind, const std::vector<KindOption>& of_kinds) {
  for (const auto& [option, kinds] : of_kinds) {
    if (option->count() == 0 || std::find(kinds.begin(), kinds.end(), kind) != kinds.end()) continue;
    throw CLI::ValidationError(
        option->get_name(),
        "only --kind " + kinds.front() + (kinds.size() > 1 ? " and " + kinds[1] + " have it" : " has it"));
  }
}

std::vector<KindOption> add_kind_options(CLI::App& sheet, SheetOptions& options) {
  const std::vector<std::string> by_clamp = {"clamp", "difference"}, by_material = {"references", "error"};
  return {
      {sheet.add_option("--object", options.request.params.object, "Such as G0-MS-ind (the study's first)"),
       by_clamp},
      {sheet.add_option("--levels", options.levels, "Clamp levels, such as C0,C2,C4 (all)")
           ->delimiter(',')
           ->check(is_clamp()),
       by_clamp},
      {sheet.add_option("--vpls", options.vpls, "Numbers of VPLs, such as 1k,100k (all)")
           ->delimiter(',')
           ->check(is_vpls()),
       by_clamp},
      {sheet.add_option("--illumination", options.illumination, "ind or dir (the study's first)")
           ->check(CLI::IsMember({"ind", "dir"})),
       by_material},
      {sheet.add_option("--scale", options.request.scale, "Steps of 255 at full colour (32)")
           ->check(is_in_range(0.1, 255)),
       {"difference"}}};
}

}  // namespace

void add_sheet(CLI::App& app, CommandLine& line) {
  auto options = std::make_shared<SheetOptions>();
  SheetRequest& request = options->request;
  CLI::App* sheet = app.add_subcommand("sheet", "Put pictures of a study folder side by side, labelled");
  sheet->add_option("folder", request.folder, "Study folder")->required();
  sheet->add_option("--out", request.out,
                    "PNG to write (default: one named by what is on it, and its page, in the study folder)");
  sheet->add_option("--html", request.html, "Page to write too, whose pictures can be enlarged");
  sheet
      ->add_option("--kind", options->kind,
                   "clamp: VPLs by clamp level and the reference; difference: the same, luminance less the "
                   "reference's; references: geometries by materials, cropped to the object; error: their "
                   "standard error")
      ->check(CLI::IsMember(kKinds));
  sheet->add_option("--view", options->view, "v0 or v1")->check(CLI::IsMember({"v0", "v1"}));
  const auto of_kinds = add_kind_options(*sheet, *options);
  sheet->add_flag("--crop", request.crop, "Show the object only, and a margin; references always do");
  sheet
      ->add_option("--cell-width", request.cell_width,
                   "Pixels at most (the pictures' own); shrunk in linear light by a tent filter")
      ->check(CLI::Range(8, 16384));
  sheet->footer(
      "Example: equilux-render sheet studies/pocket --out sheet.png --levels C0,C2,C4 --cell-width 200");
  sheet->callback([&line, options, of_kinds] {
    check_kind(options->kind, of_kinds);
    line.command = [options] { return write_sheet(*options); };
  });
}

}  // namespace equilux
