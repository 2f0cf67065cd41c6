// Cuts, differences and colours of cells.
#include "renderer/sheet_values.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "renderer/tone.h"

namespace equilux {
namespace {

using Colour = std::array<double, 3>;
constexpr Colour kEqual{221, 221, 221}, kDarker{59, 76, 192}, kBrighter{180, 4, 38};

std::uint8_t round_to_step(double value) {
  return static_cast<std::uint8_t>(std::floor(std::clamp(value, 0.0, 255.0) + 0.5));
}

int place_within(int middle_twice, int size, int limit) {
  return std::clamp((middle_twice - size) / 2, 0, limit - size);
}

std::size_t find_pixel(int x, int y, int width) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
}

double displayed_luminance(const std::uint8_t* rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

}  // namespace

Crop find_object_box(const HdrImage& coverage) {
  int left = coverage.width, top = coverage.height, right = 0, bottom = 0;
  for (int y = 0; y < coverage.height; ++y) {
    for (int x = 0; x < coverage.width; ++x) {
      if (!(coverage.values[find_pixel(x, y, coverage.width)] > 0)) continue;
      left = std::min(left, x);
      top = std::min(top, y);
      right = std::max(right, x + 1);
      bottom = std::max(bottom, y + 1);
    }
  }
  if (right == 0) return {coverage.width / 2, coverage.height / 2, 0, 0};
  return {left, top, right - left, bottom - top};
}

std::vector<Crop> make_crops(const std::vector<Crop>& boxes, int width, int height) {
  const int margin = std::max(1, width / 40);
  Crop largest;
  for (const Crop& box : boxes) {
    largest.width = std::min(width, std::max(largest.width, box.width + 2 * margin));
    largest.height = std::min(height, std::max(largest.height, box.height + 2 * margin));
  }
  std::vector<Crop> crops;
  for (const Crop& box : boxes) {
    crops.push_back({place_within(2 * box.x + box.width, largest.width, width),
                     place_within(2 * box.y + box.height, largest.height, height), largest.width,
                     largest.height});
  }
  return crops;
}

HdrImage cut_image(const HdrImage& image, const Crop& crop) {
  EQ_CHECK(crop.x >= 0 && crop.y >= 0 && crop.x + crop.width <= image.width &&
               crop.y + crop.height <= image.height,
           crop.x, crop.y, crop.width, crop.height);
  HdrImage cut(crop.width, crop.height, image.channels);
  const std::size_t row_length =
      static_cast<std::size_t>(crop.width) * static_cast<std::size_t>(image.channels);
  for (int y = 0; y < crop.height; ++y) {
    const float* from = image.pixel(find_pixel(crop.x, crop.y + y, image.width));
    std::copy_n(from, row_length, cut.pixel(find_pixel(0, y, crop.width)));
  }
  return cut;
}

HdrImage to_linear(const LdrImage& picture) {
  std::array<float, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i)
    table[i] = static_cast<float>(decode_srgb(static_cast<double>(i) / 255));
  HdrImage linear(picture.width, picture.height);
  for (std::size_t i = 0; i < picture.values.size(); ++i) linear.values[i] = table[picture.values[i]];
  return linear;
}

LdrImage to_display(const HdrImage& linear) {
  LdrImage picture(linear.width, linear.height);
  for (std::size_t i = 0; i < picture.values.size(); ++i)
    picture.values[i] = round_to_step(255 * encode_srgb(std::max(0.0f, linear.values[i])));
  return picture;
}

HdrImage measure_difference(const LdrImage& picture, const LdrImage& reference) {
  EQ_CHECK(picture.width == reference.width && picture.height == reference.height, picture.width,
           reference.width, picture.height, reference.height);
  HdrImage steps(picture.width, picture.height, 1);
  for (std::size_t i = 0; i < steps.values.size(); ++i) {
    steps.values[i] = static_cast<float>(displayed_luminance(&picture.values[3 * i]) -
                                         displayed_luminance(&reference.values[3 * i]));
  }
  return steps;
}

LdrImage show_difference(const HdrImage& steps, double scale) {
  LdrImage shown(steps.width, steps.height);
  for (std::size_t i = 0; i < steps.values.size(); ++i) {
    const Colour& end = steps.values[i] < 0 ? kDarker : kBrighter;
    const double share = std::min(1.0, std::abs(static_cast<double>(steps.values[i])) / scale);
    for (std::size_t c = 0; c < 3; ++c)
      shown.values[3 * i + c] = round_to_step(kEqual[c] + share * (end[c] - kEqual[c]));
  }
  return shown;
}

}  // namespace equilux
