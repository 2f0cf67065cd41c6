// Places on a page: a title, labels, cells, a scale bar.
#include "renderer/sheet_page.h"

#include <algorithm>

#include "base/error.h"

namespace equilux {
namespace {

constexpr std::uint8_t kEmptyGrey = 240;

// Shares of the font's size. source: DejaVu Sans, its cap height and the height of a line.
int title_size(int size) { return size * 5 / 4; }
int line_height(int size) { return size * 3 / 2; }
int half_cap(int size) { return size * 36 / 100; }

int widest(const std::vector<std::string>& texts, int size, bool bold, const MeasureText& measure) {
  int width = 0;
  for (const std::string& text : texts) width = std::max(width, measure(text, size, bold));
  return width;
}

void place_columns(const Sheet& sheet, const MeasureText& measure, PageGrid& grid) {
  std::vector<std::string> names, notes;
  for (const SheetLabel& row : sheet.rows) {
    names.push_back(row.name);
    notes.push_back(row.note);
  }
  const int note_width = widest(notes, grid.size, false, measure);
  grid.note_x =
      grid.margin + widest(names, grid.size, true, measure) + (note_width > 0 ? grid.size * 2 / 3 : 0);
  const int label = widest(sheet.columns, grid.size, true, measure) + grid.size / 2;
  const int overhang = std::max(0, label - grid.cell_width) / 2;
  grid.left = grid.note_x + note_width + grid.size * 3 / 4 + overhang;
  const int gap = std::max(3, grid.cell_width / 100);
  grid.pitch_x = std::max(grid.cell_width, label) + gap;
  grid.pitch_y = std::max(grid.cell_height, grid.size) + gap;
}

int scale_bar_height(const ScaleBar& scale, int size) { return scale.bar.values.empty() ? 0 : 4 * size; }

LdrImage fill_cell(int width, int height) {
  LdrImage cell(width, height);
  std::fill(cell.values.begin(), cell.values.end(), kEmptyGrey);
  return cell;
}

void add_title(const Sheet& sheet, const PageGrid& grid, Page& page) {
  const int large = title_size(grid.size);
  int baseline = grid.margin + large;
  page.texts.push_back({sheet.title, grid.margin, baseline, large, TextAlign::kLeft, true});
  baseline += line_height(grid.size);
  page.texts.push_back({sheet.subtitle, grid.margin, baseline, grid.size, TextAlign::kLeft, false, true});
}

void add_labels(const Sheet& sheet, const PageGrid& grid, Page& page) {
  for (std::size_t column = 0; column < sheet.columns.size(); ++column) {
    const int middle = grid.left + static_cast<int>(column) * grid.pitch_x + grid.cell_width / 2;
    page.texts.push_back(
        {sheet.columns[column], middle, grid.top - grid.size / 2, grid.size, TextAlign::kCenter, true});
  }
  for (std::size_t row = 0; row < sheet.rows.size(); ++row) {
    const int baseline =
        grid.top + static_cast<int>(row) * grid.pitch_y + grid.cell_height / 2 + half_cap(grid.size);
    page.texts.push_back({sheet.rows[row].name, grid.margin, baseline, grid.size, TextAlign::kLeft, true});
    page.texts.push_back({sheet.rows[row].note, grid.note_x, baseline, grid.size});
  }
}

// The longest text that fits says that there is nothing.
void add_empty_cell(int x, int y, const PageGrid& grid, const MeasureText& measure, Page& page) {
  page.pictures.push_back({x, y, fill_cell(grid.cell_width, grid.cell_height)});
  for (const char* text : {"not rendered", "none", "-"}) {
    if (measure(text, grid.size, false) >= grid.cell_width) continue;
    page.texts.push_back({text, x + grid.cell_width / 2, y + grid.cell_height / 2 + half_cap(grid.size),
                          grid.size, TextAlign::kCenter, false, true});
    return;
  }
}

void add_cells(const Sheet& sheet, const PageGrid& grid, std::vector<LdrImage>& cells,
               const MeasureText& measure, Page& page) {
  const std::size_t columns = sheet.columns.size();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (sheet.cells[i].kind == CellKind::kNone) continue;
    const int x = grid.left + static_cast<int>(i % columns) * grid.pitch_x;
    const int y = grid.top + static_cast<int>(i / columns) * grid.pitch_y;
    if (cells[i].values.empty()) {
      add_empty_cell(x, y, grid, measure, page);
    } else {
      page.pictures.push_back({x, y, std::move(cells[i])});
    }
  }
}

LdrImage thicken(const LdrImage& line, int height) {
  LdrImage bar(line.width, height);
  for (int y = 0; y < height; ++y)
    std::copy(line.values.begin(), line.values.end(),
              bar.values.begin() + static_cast<std::ptrdiff_t>(line.values.size()) * y);
  return bar;
}

void add_scale_bar(const ScaleBar& scale, const PageGrid& grid, Page& page) {
  if (scale.bar.values.empty()) return;
  const int top = grid.height - grid.margin - scale_bar_height(scale, grid.size) + grid.size;
  const int below = top + grid.size + line_height(grid.size);
  page.pictures.push_back({grid.left, top, thicken(scale.bar, grid.size)});
  const int steps = static_cast<int>(scale.marks.size()) - 1;
  for (int i = 0; i <= steps; ++i) {
    page.texts.push_back({scale.marks[static_cast<std::size_t>(i)], grid.left + i * scale.bar.width / steps,
                          below, grid.size, TextAlign::kCenter});
  }
  page.texts.push_back({scale.caption, grid.left + scale.bar.width + grid.size,
                        top + grid.size / 2 + half_cap(grid.size), grid.size});
}

}  // namespace

PageGrid make_page_grid(const Sheet& sheet, int cell_width, int cell_height, const ScaleBar& scale,
                        const MeasureText& measure) {
  PageGrid grid;
  grid.cell_width = cell_width;
  grid.cell_height = cell_height;
  grid.size = std::clamp(cell_width / 17, 13, 30);
  grid.margin = grid.size;
  place_columns(sheet, measure, grid);
  grid.top = grid.margin + title_size(grid.size) + 3 * line_height(grid.size);
  const int columns = static_cast<int>(sheet.columns.size()), rows = static_cast<int>(sheet.rows.size());
  grid.width = grid.left + (columns - 1) * grid.pitch_x + std::max(cell_width, grid.pitch_x) + grid.margin;
  const int caption = measure(scale.caption, grid.size, false);
  grid.width = std::max({grid.width, measure(sheet.title, title_size(grid.size), true) + 2 * grid.margin,
                         measure(sheet.subtitle, grid.size, false) + 2 * grid.margin,
                         grid.left + scale.bar.width + grid.size + caption + grid.margin});
  grid.height = grid.top + rows * grid.pitch_y + scale_bar_height(scale, grid.size) + grid.margin;
  return grid;
}

Page make_page(const Sheet& sheet, const PageGrid& grid, std::vector<LdrImage> cells, const ScaleBar& scale,
               const MeasureText& measure) {
  EQ_CHECK(cells.size() == sheet.cells.size(), cells.size(), sheet.cells.size());
  Page page;
  page.width = grid.width;
  page.height = grid.height;
  add_title(sheet, grid, page);
  add_labels(sheet, grid, page);
  add_cells(sheet, grid, cells, measure, page);
  add_scale_bar(scale, grid, page);
  return page;
}

}  // namespace equilux
