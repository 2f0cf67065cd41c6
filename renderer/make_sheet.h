// A contact sheet from a study folder to a PNG, and to an HTML page if wanted.
#pragma once

#include <filesystem>

#include "renderer/sheet.h"

namespace equilux {

struct SheetRequest {
  std::filesystem::path folder;
  std::filesystem::path out;   ///< PNG
  std::filesystem::path html;  ///< empty: none
  SheetParams params;
  bool crop = false;   ///< to the object; references always are
  int cell_width = 0;  ///< at most; 0: as wide as the pictures. units: pixels
  double scale = 32;   ///< of differences. units: displayed steps of 255
};

struct SheetSummary {
  std::size_t pictures = 0;   ///< that are shown
  std::size_t missing = 0;    ///< that are not rendered
  int width = 0, height = 0;  ///< of the sheet. units: pixels
};

/// Writes `out` and `html`, nothing else. errors: InputError, also where no picture of the sheet is rendered,
/// the sheet would be larger than 16,384 x 16,384 pixels, or a file would stand among the study's own;
/// StoreError.
SheetSummary make_sheet(const SheetRequest& request);

}  // namespace equilux
