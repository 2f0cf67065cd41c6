// Where everything of a sheet stands on its page. It draws nothing.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "renderer/sheet.h"
#include "stimuli/image.h"

namespace equilux {

enum class TextAlign { kLeft, kCenter, kRight };

struct PageText {
  std::string text;
  int x = 0;         ///< of the edge or middle that `align` says. units: pixels
  int baseline = 0;  ///< units: pixels from the top
  int size = 0;      ///< of the font. units: pixels
  TextAlign align = TextAlign::kLeft;
  bool bold = false;
  bool soft = false;  ///< grey, for what is said beside the matter
};

struct PagePicture {
  int x = 0;
  int y = 0;
  LdrImage picture;
};

/// White, with pictures and text on it.
struct Page {
  int width = 0;
  int height = 0;
  std::vector<PagePicture> pictures;
  std::vector<PageText> texts;
};

/// What the colours of a sheet mean: a bar, and marks evenly spaced along it.
struct ScaleBar {
  LdrImage bar;  ///< one pixel high; empty: none
  std::vector<std::string> marks;
  std::string caption;
};

/// The width that a text takes. units: pixels
using MeasureText = std::function<int(const std::string& text, int size, bool bold)>;

/// Sizes and places that follow from the labels and the size of a cell. units: pixels
struct PageGrid {
  int cell_width = 0, cell_height = 0;
  int pitch_x = 0, pitch_y = 0;  ///< from one cell to the next
  int left = 0, top = 0;         ///< of the first cell
  int size = 0;                  ///< of the font
  int margin = 0;
  int note_x = 0;  ///< where the notes of row labels begin
  int width = 0, height = 0;
};

PageGrid make_page_grid(const Sheet& sheet, int cell_width, int cell_height, const ScaleBar& scale,
                        const MeasureText& measure);

/// `cells` in the sheet's order; an empty picture is one that is not rendered.
Page make_page(const Sheet& sheet, const PageGrid& grid, std::vector<LdrImage> cells, const ScaleBar& scale,
               const MeasureText& measure);

}  // namespace equilux
