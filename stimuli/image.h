// The two kinds of pictures.
#pragma once

#include <cstdint>
#include <vector>

namespace equilux {

/// units: pixels
struct PixelSize {
  int width = 0, height = 0;
  bool operator==(const PixelSize&) const = default;
};

/// What a file of an image takes at most: an EXR layer of three floats a pixel that nothing could compress,
/// or a PNG picture, with its head. units: bytes
inline std::uintmax_t most_file_bytes(PixelSize size) {
  return 16 * static_cast<std::uintmax_t>(size.width) * static_cast<std::uintmax_t>(size.height) + (1 << 26);
}

/// Linear Rec.709 radiance. shape: height x width x channels, row-major from the top left. channels: 3, or 1
/// for coverage.
struct HdrImage {
  int width = 0;
  int height = 0;
  int channels = 3;
  std::vector<float> values;

  HdrImage() = default;
  HdrImage(int image_width, int image_height, int channel_count = 3)
      : width(image_width),
        height(image_height),
        channels(channel_count),
        values(static_cast<std::size_t>(image_width) * static_cast<std::size_t>(image_height) *
               static_cast<std::size_t>(channel_count)) {}

  float* pixel(std::size_t index) { return values.data() + index * static_cast<std::size_t>(channels); }
  const float* pixel(std::size_t index) const {
    return values.data() + index * static_cast<std::size_t>(channels);
  }
  std::size_t pixel_count() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }
};

/// 8-bit sRGB. shape: height x width x 3, row-major from the top left.
struct LdrImage {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> values;

  LdrImage() = default;
  LdrImage(int image_width, int image_height)
      : width(image_width),
        height(image_height),
        values(static_cast<std::size_t>(image_width) * static_cast<std::size_t>(image_height) * 3) {}

  bool operator==(const LdrImage&) const = default;
};

}  // namespace equilux
