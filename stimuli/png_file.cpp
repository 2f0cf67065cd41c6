// The one file that knows libpng.
#include "stimuli/png_file.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>
#include <png.h>

#include "base/error.h"
#include "base/files.h"

namespace equilux {
namespace {

constexpr png_uint_32 kMaxSide = 16384;
constexpr std::size_t kMostInflated = 1032;  // bytes that deflate can make of one

struct PngImage : png_image {
  PngImage() : png_image{} { version = PNG_IMAGE_VERSION; }
  ~PngImage() { png_image_free(this); }
  PngImage(const PngImage&) = delete;
  PngImage& operator=(const PngImage&) = delete;
};

}  // namespace

PixelSize load_png_size(const std::filesystem::path& path) {
  if (!is_file(path)) return {};  // a pipe would be waited for
  std::array<unsigned char, 24> head{};
  std::ifstream file(path, std::ios::binary);
  if (!file.read(reinterpret_cast<char*>(head.data()), head.size())) return {};
  const auto number = [&](std::size_t at) {
    const std::uint32_t value = std::uint32_t{head[at]} << 24 | std::uint32_t{head[at + 1]} << 16 |
                                std::uint32_t{head[at + 2]} << 8 | head[at + 3];
    return value > std::numeric_limits<int>::max() ? 0 : static_cast<int>(value);
  };
  return {number(16), number(20)};
}

LdrImage load_png(const std::filesystem::path& path) { return decode_png(load_text(path), path.string()); }

LdrImage decode_png(std::string_view bytes, const std::string& name) {
  PngImage png;
  if (!png_image_begin_read_from_memory(&png, bytes.data(), bytes.size())) {
    throw InputError(name, "", "a PNG file", png.message);
  }
  if (png.width > kMaxSide || png.height > kMaxSide) {
    throw InputError(name, "", fmt::format("at most {} x {} pixels", kMaxSide, kMaxSide),
                     fmt::format("{} x {}", png.width, png.height));
  }
  // A row takes at least a bit a pixel and a byte for its filter: what cannot be in the file gets no memory.
  if ((png.width / 8 + std::size_t{1}) * png.height > kMostInflated * bytes.size()) {
    throw InputError(name, "", fmt::format("the {} x {} pixels that it declares", png.width, png.height),
                     fmt::format("{} bytes, too few for them", bytes.size()));
  }
  png.format = PNG_FORMAT_RGB;
  LdrImage image(static_cast<int>(png.width), static_cast<int>(png.height));
  if (!png_image_finish_read(&png, nullptr, image.values.data(), 0, nullptr)) {
    throw InputError(name, "", "a whole PNG file", png.message);
  }
  return image;
}

std::string encode_png(const LdrImage& image) {
  PngImage png;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  const int written =
      png_image_write_to_memory(&png, bytes.data(), &size, 0, image.values.data(), 0, nullptr);
  EQ_CHECK(written != 0, png.message);
  bytes.resize(size);
  return bytes;
}

void save_png(const LdrImage& image, const std::filesystem::path& path) {
  save_text(path, encode_png(image));
}

}  // namespace equilux
