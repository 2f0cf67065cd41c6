// Open, lay out, load, draw, save.
#include "renderer/make_sheet.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/files.h"
#include "renderer/sheet_cells.h"
#include "renderer/sheet_html.h"
#include "stimuli/png_file.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

constexpr int kMaxSide = 16384;

bool is_inside(const fs::path& path, const fs::path& folder) {
  const fs::path inner = fs::weakly_canonical(fs::absolute(path)), outer = fs::weakly_canonical(folder);
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

// The folders of a study are its programs' own, and its other files have other endings.
void check_place(const fs::path& path, const char* option, const char* ending, const StudyFolder& folder) {
  if (path.extension() != ending)
    throw InputError(option, "", fmt::format("a file name that ends in {}", ending), path.string());
  for (const fs::path& own : {folder.picture_folder(), folder.layer_folder(), folder.report_folder()}) {
    if (is_inside(path, own))
      throw InputError(option, "", "a file outside " + own.string() + ", which holds what others made",
                       path.string());
  }
  check_writable(path);
}

void check_places(const SheetRequest& request) {
  const StudyFolder folder{request.folder};
  check_place(request.out, "--out", ".png", folder);
  if (!request.html.empty()) check_place(request.html, "--html", ".html", folder);
}

SheetSummary count_pictures(const SheetSource& source, const Sheet& sheet) {
  SheetSummary summary;
  for (const SheetCell& cell : sheet.cells) {
    if (cell.kind == CellKind::kNone) continue;
    ++(find_cell_file(source, cell).empty() ? summary.missing : summary.pictures);
  }
  if (summary.pictures == 0) {
    throw InputError(source.folder.root.string(), "", fmt::format("pictures of \"{}\"", sheet.title),
                     fmt::format("none; `equilux-render set STUDY.json --out {}` makes them",
                                 source.folder.root.string()));
  }
  return summary;
}

CellLook make_look(const SheetRequest& request, const Crop& crop) {
  const int width = request.cell_width > 0 ? std::min(request.cell_width, crop.width) : crop.width;
  const double height = static_cast<double>(crop.height) * width / crop.width;
  return {width, std::max(1, static_cast<int>(std::lround(height))), request.scale};
}

void check_size(const PageGrid& grid) {
  if (grid.width > kMaxSide || grid.height > kMaxSide) {
    throw InputError("--cell-width", "",
                     fmt::format("cells for a sheet of at most {0} x {0} pixels", kMaxSide),
                     fmt::format("{} x {}", grid.width, grid.height));
  }
}

std::vector<LdrImage> load_cells(const SheetSource& source, const Sheet& sheet,
                                 const std::vector<Crop>& crops, const CellLook& look,
                                 const SheetImage& image) {
  std::vector<LdrImage> cells;
  for (std::size_t i = 0; i < sheet.cells.size(); ++i)
    cells.push_back(load_cell(source, sheet.cells[i], crops[i], look, image));
  return cells;
}

std::string find_relative(const fs::path& file, const fs::path& page) {
  return fs::relative(fs::absolute(file), fs::absolute(page).parent_path()).generic_string();
}

HtmlSheet make_html(const SheetRequest& request, const SheetSource& source, const Sheet& sheet,
                    const std::vector<Crop>& crops, const std::vector<LdrImage>& cells,
                    const CellLook& look) {
  HtmlSheet html{{}, source.study.width, look.width, look.height, ""};
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::string file = find_cell_file(source, sheet.cells[i]);
    if (file.empty()) {
      html.cells.push_back({});
      continue;
    }
    html.cells.push_back({find_relative(source.folder.root / file, request.html),
                          sheet.cells[i].kind == CellKind::kPicture ? "" : encode_png(cells[i]), crops[i]});
  }
  if (sheet.kind == SheetKind::kDifference)
    html.scale = fmt::format(
        "blue darker, red brighter than the reference, full at {} displayed steps of 255", request.scale);
  if (sheet.kind == SheetKind::kError) html.scale = "white is five displayed steps of 255";
  return html;
}

}  // namespace

SheetSummary make_sheet(const SheetRequest& request) {
  check_places(request);
  const SheetSource source = open_sheet_source(request.folder);
  const Sheet sheet = make_sheet_layout(source.study, request.params);
  SheetSummary summary = count_pictures(source, sheet);
  const SheetImage& image = load_sheet_image();
  const bool crop = request.crop || sheet.kind == SheetKind::kReferences;
  const auto crops = find_cell_crops(source, sheet, crop);
  const CellLook look = make_look(request, crops.front());
  const ScaleBar scale = make_scale_bar(sheet.kind, request.scale, std::max(look.width, 160));
  const PageGrid grid = make_page_grid(sheet, look.width, look.height, scale, image.measure_text);
  check_size(grid);
  std::vector<LdrImage> cells = load_cells(source, sheet, crops, look, image);
  if (!request.html.empty())
    save_text(request.html, format_sheet_html(sheet, make_html(request, source, sheet, crops, cells, look)));
  const Page page = make_page(sheet, grid, std::move(cells), scale, image.measure_text);
  save_png(image.draw_page(page), request.out);
  summary.width = grid.width;
  summary.height = grid.height;
  return summary;
}

}  // namespace equilux
