// The one file that knows OpenImageIO. A module of its own, which calls nothing else of Equilux's.
#include "renderer/sheet_image.h"

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <algorithm>
#include <array>
#include <stdexcept>

namespace equilux {
namespace {
namespace algorithms = OIIO::ImageBufAlgo;

constexpr int kThreads = 1;  // a page is small

void require(bool done, const OIIO::ImageBuf& image) {
  if (!done) throw std::runtime_error("OpenImageIO: " + image.geterror());
}

// OpenImageIO only reads what it is given to paste or shrink, but takes no const pointer.
OIIO::ImageBuf view_picture(const LdrImage& picture) {
  return OIIO::ImageBuf(OIIO::ImageSpec(picture.width, picture.height, 3, OIIO::TypeDesc::UINT8),
                        const_cast<std::uint8_t*>(picture.values.data()));
}

OIIO::ImageBuf view_image(const HdrImage& image) {
  return OIIO::ImageBuf(OIIO::ImageSpec(image.width, image.height, image.channels, OIIO::TypeDesc::FLOAT),
                        const_cast<float*>(image.values.data()));
}

int measure_text(const std::string& text, int size, bool bold) {
  const OIIO::ROI box = algorithms::text_size(text, size, sheet_font_path(bold));
  return box.defined() ? box.xend : 0;
}

HdrImage shrink_image(const HdrImage& image, int width, int height) {
  HdrImage shrunk(std::min(width, image.width), std::min(height, image.height), image.channels);
  OIIO::ImageBuf to = view_image(shrunk);
  require(algorithms::resize(to, view_image(image), "triangle", 0, {}, kThreads), to);
  return shrunk;
}

void draw_text(const PageText& text, OIIO::ImageBuf& page) {
  if (text.text.empty()) return;
  constexpr std::array<OIIO::ImageBufAlgo::TextAlignX, 3> kAlign = {
      algorithms::TextAlignX::Left, algorithms::TextAlignX::Center, algorithms::TextAlignX::Right};
  const float grey = text.soft ? 0.4f : 0.1f;
  const std::array<float, 3> colour{grey, grey, grey};
  require(
      algorithms::render_text(page, text.x, text.baseline, text.text, text.size, sheet_font_path(text.bold),
                              colour, kAlign[static_cast<std::size_t>(text.align)],
                              algorithms::TextAlignY::Baseline, 0, {}, kThreads),
      page);
}

LdrImage draw_page(const Page& page) {
  LdrImage drawn(page.width, page.height);
  std::fill(drawn.values.begin(), drawn.values.end(), std::uint8_t{255});
  OIIO::ImageBuf to = view_picture(drawn);
  for (const PagePicture& picture : page.pictures)
    require(algorithms::paste(to, picture.x, picture.y, 0, 0, view_picture(picture.picture), {}, kThreads),
            to);
  for (const PageText& text : page.texts) draw_text(text, to);
  return drawn;
}

}  // namespace

extern "C" const SheetImage equilux_sheet_image = {measure_text, shrink_image, draw_page};

}  // namespace equilux
