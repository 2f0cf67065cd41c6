// Where the pictures and the question stand on the screen: pure arithmetic, between a session and its window.
#pragma once

#include <optional>

#include "experiment/trial_log.h"

namespace equilux {

inline constexpr int kPictureGap = 16;      ///< pixels between the two lower pictures
inline constexpr int kQuestionHeight = 90;  ///< pixels between the upper picture and the lower two
inline constexpr int kQuestionWidth = 720;  ///< pixels that the longer question needs on one line
inline constexpr int kWindowMargin = 32;    ///< pixels of grey around the pictures in a plain window

/// units: pixels
struct Size {
  int width = 0;
  int height = 0;
  bool operator==(const Size&) const = default;
};

/// units: framebuffer pixels from the top left
struct Rectangle {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  bool operator==(const Rectangle&) const = default;
};

/// The lower pair and the question are at the same place in both experiments.
struct Layout {
  Size framebuffer;
  Rectangle left;
  Rectangle right;
  Rectangle question;              ///< what the text may cover
  std::optional<Rectangle> upper;  ///< the reference; empty in the artifact experiment
};

/// The smallest framebuffer in which three pictures of this size and the question have room.
Size find_least_framebuffer(Size picture);

/// A plain window at least so large has room for every page of text.
inline constexpr Size kPageSize{960, 760};

/// The size of a plain window: the least framebuffer with a margin, and the pages of text, as far as the
/// screen allows.
Size choose_window_size(Size picture, Size screen);

/// errors: InputError with both sizes for a framebuffer that is too small; pictures are never scaled.
Layout make_layout(Size framebuffer, Size picture, Experiment experiment);

/// Between the two lower pictures, for one alone.
Rectangle find_middle(const Layout& layout);

/// The lower picture at a point; empty beside them.
std::optional<Side> find_side(const Layout& layout, double x, double y);

}  // namespace equilux
