// What the cells of a sheet show, as numbers and as pictures: cuts, differences, colours.
#pragma once

#include <vector>

#include "stimuli/image.h"

namespace equilux {

/// A part of a picture. units: pixels
struct Crop {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
  bool operator==(const Crop&) const = default;
};

/// The least part that holds every pixel of coverage > 0; of none, an empty one in the middle.
Crop find_object_box(const HdrImage& coverage);

/// A crop about the middle of each box, all of one size: the largest box and a margin of 1/40 of the width,
/// no larger than the picture, in which they all stay.
std::vector<Crop> make_crops(const std::vector<Crop>& boxes, int width, int height);

HdrImage cut_image(const HdrImage& image, const Crop& crop);

/// Out of sRGB and into it. A picture that goes both ways keeps its bits.
HdrImage to_linear(const LdrImage& picture);
LdrImage to_display(const HdrImage& linear);

/// Luminance of the sRGB values, Rec.709's weights: a picture less its reference. shape: height x width.
/// units: displayed steps of 255
HdrImage measure_difference(const LdrImage& picture, const LdrImage& reference);

/// Grey where equal, towards blue where darker, towards red where brighter, full at `scale` steps. source:
/// the cool-warm ends of Moreland, "Diverging color maps for scientific visualization", ISVC 2009, met in
/// sRGB by straight lines.
LdrImage show_difference(const HdrImage& steps, double scale);

}  // namespace equilux
