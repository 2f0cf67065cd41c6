// What a sheet needs of OpenImageIO, in a module that the first sheet loads: the library brings some 240
// others along, which would make every start of equilux-render .15 s longer.
#pragma once

#include "renderer/sheet_page.h"

namespace equilux {

struct SheetImage {
  /// 0 for what cannot be set.
  int (*measure_text)(const std::string& text, int size, bool bold);
  /// Of any channels, by a tent as wide as two of the new pixels, so that light is kept. Never enlarges.
  HdrImage (*shrink_image)(const HdrImage& image, int width, int height);
  LdrImage (*draw_page)(const Page& page);
};

/// The font of a sheet's text.
inline const char* sheet_font_path(bool bold) {
  return bold ? "/usr/share/fonts/truetype/dejavu/DejaVuSans-Bold.ttf"
              : "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
}

/// errors: InputError where a font is missing, or the module beside the program or what it needs.
const SheetImage& load_sheet_image();

}  // namespace equilux
