// Integer places for pictures that are never scaled.
#include "experiment/app/layout.h"

#include <algorithm>

#include "base/error.h"

namespace equilux {
namespace {

int pair_width(Size picture) { return 2 * picture.width + kPictureGap; }

bool is_inside(const Rectangle& rectangle, double x, double y) {
  return x >= rectangle.x && x < rectangle.x + rectangle.width && y >= rectangle.y &&
         y < rectangle.y + rectangle.height;
}

}  // namespace

Size find_least_framebuffer(Size picture) {
  return {std::max(pair_width(picture), kQuestionWidth), 2 * picture.height + kQuestionHeight};
}

Size choose_window_size(Size picture, Size screen) {
  const Size least = find_least_framebuffer(picture);
  const auto choose = [](int pictures, int page, int available) {
    return std::max(pictures, std::min(std::max(pictures + 2 * kWindowMargin, page), available));
  };
  return {choose(least.width, kPageSize.width, screen.width),
          choose(least.height, kPageSize.height, screen.height)};
}

Layout make_layout(Size framebuffer, Size picture, Experiment experiment) {
  const Size least = find_least_framebuffer(picture);
  if (framebuffer.width < least.width || framebuffer.height < least.height) {
    throw InputError(
        "screen", "",
        fmt::format("a framebuffer of at least {} x {} pixels for pictures of {} x {}, which are "
                    "never scaled",
                    least.width, least.height, picture.width, picture.height),
        fmt::format("{} x {}", framebuffer.width, framebuffer.height));
  }
  const int top = (framebuffer.height - least.height) / 2;
  const int lower = top + picture.height + kQuestionHeight;
  const int left = (framebuffer.width - pair_width(picture)) / 2;
  Layout layout;
  layout.framebuffer = framebuffer;
  layout.left = {left, lower, picture.width, picture.height};
  layout.right = {left + picture.width + kPictureGap, lower, picture.width, picture.height};
  layout.question = {(framebuffer.width - least.width) / 2, top + picture.height, least.width,
                     kQuestionHeight};
  if (experiment == Experiment::kMaterial) {
    layout.upper = {(framebuffer.width - picture.width) / 2, top, picture.width, picture.height};
  }
  return layout;
}

Rectangle find_middle(const Layout& layout) {
  Rectangle middle = layout.left;
  middle.x = (layout.left.x + layout.right.x) / 2;
  return middle;
}

std::optional<Side> find_side(const Layout& layout, double x, double y) {
  if (is_inside(layout.left, x, y)) return Side::kLeft;
  if (is_inside(layout.right, x, y)) return Side::kRight;
  return std::nullopt;
}

}  // namespace equilux
