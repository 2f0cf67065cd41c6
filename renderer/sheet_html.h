// A sheet as an HTML page whose pictures can be enlarged.
#pragma once

#include <string>
#include <vector>

#include "renderer/sheet.h"
#include "renderer/sheet_values.h"

namespace equilux {

/// A cell of the page.
struct HtmlCell {
  std::string file;   ///< of the whole picture, relative to the page; empty: not rendered
  std::string bytes;  ///< PNG of what the cell shows, where that is no part of the file
  Crop crop;          ///< of the file
};

struct HtmlSheet {
  std::vector<HtmlCell> cells;          ///< in the sheet's order
  int picture_width = 0;                ///< of the files. units: pixels
  int cell_width = 0, cell_height = 0;  ///< units: pixels
  std::string scale;                    ///< what the colours mean, in words
};

std::string format_sheet_html(const Sheet& sheet, const HtmlSheet& html);

}  // namespace equilux
