// Pictures and files whose values no display was made for.
#include <array>
#include <bit>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "base/error.h"
#include "base/files.h"
#include "base/random.h"
#include "renderer/stress.h"
#include "renderer/stress_scene.h"
#include "renderer/tone.h"
#include "stimuli/exr_file.h"

namespace equilux {
namespace {

constexpr int kSize = 100;

// Radiances over two decades, as a room's are; no object.
HdrImage make_room_picture() {
  HdrImage image(kSize, kSize);
  RandomStream random(4, "stress.pictures", 0);
  for (float& value : image.values) value = std::pow(10.0f, 2 * random.next_float() - 2);
  return image;
}

LdrImage display(const HdrImage& image) {
  const HdrImage coverage(kSize, kSize, 1);
  return apply_tone_curve(image, make_tone_curve(image, coverage, {}));
}

StressRow stress_hot_pixel() {
  const HdrImage plain = make_room_picture();
  HdrImage hot = plain;
  for (std::size_t c = 0; c < 3; ++c) hot.pixel(4242)[c] = 1e30f;
  const LdrImage a = display(plain), b = display(hot);
  int largest = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    if (i / 3 != 4242) largest = std::max(largest, std::abs(int{a.values[i]} - int{b.values[i]}));
  }
  const int shown = b.values[std::size_t{3} * 4242];
  return make_stress_row(
      "tone curve", "one hot pixel of 1e30 in 10,000", "it is white, the others move by two steps at most",
      fmt::format("it shows {}, the others move by {}", shown, largest), shown == 255 && largest <= 2);
}

StressRow stress_black_picture() {
  const LdrImage black = display(HdrImage(kSize, kSize));
  int largest = 0;
  for (std::uint8_t value : black.values) largest = std::max(largest, int{value});
  return make_stress_row("tone curve", "an all-black picture", "black", fmt::format("brightest {}", largest),
                         largest == 0);
}

StressRow stress_tiny_picture() {
  HdrImage image = make_room_picture();
  const LdrImage plain = display(image);
  for (float& value : image.values) value *= 0x1p-100f;
  const bool same = display(image) == plain;
  return make_stress_row("tone curve", "a picture times 2^-100", "the same display",
                         same ? "the same" : "another", same);
}

// An uncompressed EXR file of one pixel in Y, as another program may write it.
std::string make_exr_bytes(float value) {
  std::string bytes("\x76\x2f\x31\x01\x02\x00\x00\x00", 8);
  const auto add_int = [&](std::uint32_t number) {
    for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(number >> shift);
  };
  const auto add_float = [&](float number) { add_int(std::bit_cast<std::uint32_t>(number)); };
  const auto add = [&](const char* name, const char* type, std::uint32_t size) {
    bytes += std::string(name) + '\0' + type + '\0';
    add_int(size);
  };
  add("channels", "chlist", 2 + 16 + 1);
  bytes += std::string("Y\0", 2);
  for (std::uint32_t field : {2u, 0u, 1u, 1u}) add_int(field);  // float, not linear for eyes, every pixel
  bytes += '\0';
  add("compression", "compression", 1);
  bytes += '\0';
  for (const char* window : {"dataWindow", "displayWindow"}) {
    add(window, "box2i", 16);
    for (int i = 0; i < 4; ++i) add_int(0);
  }
  add("lineOrder", "lineOrder", 1);
  bytes += '\0';
  add("pixelAspectRatio", "float", 4);
  add_float(1);
  add("screenWindowCenter", "v2f", 8);
  add_float(0);
  add_float(0);
  add("screenWindowWidth", "float", 4);
  add_float(1);
  bytes += '\0';
  add_int(static_cast<std::uint32_t>(bytes.size()) + 8);
  add_int(0);  // offset of the only line, high half
  add_int(0);
  add_int(4);
  add_float(value);
  return bytes;
}

float load_pixel(float value) {
  const StressFolder folder;
  save_text(folder.path() / "pixel.exr", make_exr_bytes(value));
  return load_exr(folder.path() / "pixel.exr").image.values.at(0);
}

void add_files(std::vector<StressRow>& rows) {
  const float got = load_pixel(2.5f);
  rows.push_back(make_stress_row("EXR in", "a finite pixel", "2.5", fmt::format("{:g}", got), got == 2.5f));
  rows.push_back(
      expect_input_error("EXR in", "a NaN", [] { load_pixel(std::numeric_limits<float>::quiet_NaN()); }));
  rows.push_back(
      expect_input_error("EXR in", "an Inf", [] { load_pixel(std::numeric_limits<float>::infinity()); }));
  const StressFolder folder;
  HdrImage image(1, 1);
  image.values = {1e6f, 1e30f, 1e-30f};
  save_exr(image, {}, folder.path() / "wide.exr");
  const auto back = load_exr(folder.path() / "wide.exr").image.values;
  rows.push_back(
      make_stress_row("EXR out", "1e6, 1e30 and 1e-30, beyond half float", "kept: files hold 32-bit floats",
                      fmt::format("{:g}, {:g}, {:g}", back[0], back[1], back[2]), back == image.values));
}

}  // namespace

std::vector<StressRow> stress_pictures() {
  std::vector<StressRow> rows{stress_hot_pixel(), stress_black_picture(), stress_tiny_picture()};
  add_files(rows);
  return rows;
}

}  // namespace equilux
