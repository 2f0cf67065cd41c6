// Tone mapping against pfstmo_reinhard02 of the pfstools, which comes from the authors' own program.
//
// It takes the log-average with an addend of 1e-5 and the largest luminance as white; ours are 1e-6 of the
// mean and the 99.9th percentile, so that one pixel sets neither. Its local form, as Debian builds it, does
// not convolve: it looks each Gaussian up in an image pyramid. That accounts for the whole difference, which
// the last test shows by putting such a pyramid in the place of our Gaussians.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/files.h"
#include "base/random.h"
#include "renderer/local_tone.h"
#include "renderer/tone.h"
#include "tests/support/temp_folder.h"

namespace equilux::test {
namespace {

constexpr int kWidth = 90, kHeight = 64;

// A grey picture of four decades with edges, a gradient and noise.
HdrImage make_picture() {
  HdrImage image(kWidth, kHeight);
  RandomStream random(5, "reinhard", 0);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double side = x < 40 ? .02 : 1, window = x > 60 && y > 20 && y < 50 ? 60 : 1;
      const double value = side * window * (1 + .02 * y) * std::exp(.2 * (random.next_float() - .5));
      for (int c = 0; c < 3; ++c)
        image.pixel(static_cast<std::size_t>(y * kWidth + x))[c] = static_cast<float>(value);
    }
  }
  return image;
}

// Luminance of a grey picture by the peer. The stream holds channels X, Y and Z, which are the same here.
std::vector<float> map_by_peer(const HdrImage& image, const std::string& options) {
  const TempFolder folder;
  std::string stream =
      fmt::format("PFS1\n{} {}\n3\n1\nLUMINANCE=RELATIVE\nX\n0\nY\n0\nZ\n0\nENDH", image.width, image.height);
  std::vector<float> luminance(image.pixel_count());
  for (std::size_t i = 0; i < luminance.size(); ++i) luminance[i] = image.pixel(i)[1];
  const std::size_t bytes = luminance.size() * sizeof(float);
  for (int channel = 0; channel < 3; ++channel)
    stream.append(reinterpret_cast<const char*>(luminance.data()), bytes);
  save_text(folder.path() / "in.pfs", stream);
  const std::string out = (folder.path() / "out.pfs").string();
  const std::string command =
      fmt::format("pfstmo_reinhard02 {} < {} > {}", options, (folder.path() / "in.pfs").string(), out);
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  const std::string answer = load_text(out);
  const std::size_t start = answer.find("ENDH") + 4;
  EXPECT_EQ(answer.size(), start + 3 * bytes);
  if (answer.size() == start + 3 * bytes) std::memcpy(luminance.data(), answer.data() + start + bytes, bytes);
  return luminance;
}

// A curve with the peer's choices of addend and white.
ToneRecord make_peers_record(const HdrImage& image, double key) {
  double logs = 0, largest = 0;
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    logs += std::log(1e-5 + image.pixel(i)[1]);
    largest = std::max(largest, double{image.pixel(i)[1]});
  }
  const double average = std::exp(logs / static_cast<double>(image.pixel_count()));
  return {average, key * largest / average, 1e-5, key, "whole"};
}

// Displayed luminance before the transfer function, of pixels that are not cut off at 1.
double map_by_us(const ToneCurve& tone, const HdrImage& image, std::size_t pixel) {
  return decode_srgb(eval_display(tone, pixel, image.pixel(pixel))[1] / 255);
}

TEST(PeerReinhard, TheGlobalFormIsEqualWithinRounding) {
  const HdrImage image = make_picture();
  for (const double key : {.18, .36}) {
    const std::vector<float> theirs = map_by_peer(image, fmt::format("--key {}", key));
    const ToneCurve tone{make_peers_record(image, key), {}};
    for (std::size_t i = 0; i < image.pixel_count(); ++i)
      ASSERT_NEAR(map_by_us(tone, image, i), theirs[i], 2e-6 * theirs[i]) << i;
  }
}

TEST(PeerReinhard, OurLogAverageAndWhiteDifferAsStated) {
  const HdrImage image = make_picture();
  const ToneRecord ours =
      make_tone_curve(image, HdrImage(kWidth, kHeight, 1), {ToneOperator::kGlobal, .18, Exposure::kWhole})
          .record;
  const ToneRecord theirs = make_peers_record(image, .18);
  EXPECT_NEAR(ours.log_average / theirs.log_average, 1,
              1e-3);  // addends of 2e-5 and 1e-5 beside .02 and more
  EXPECT_NE(ours.log_average, theirs.log_average);
  EXPECT_LT(ours.white, theirs.white);
}

// Levels of half the size each, by the separable filter (.05, .25, .4, .25, .05), the first a square of a
// power of two; what lies outside is black. A level is read between its pixels in straight lines; level 0 is
// the picture.
class Pyramid {
 public:
  explicit Pyramid(std::vector<double> picture, int width) : picture_(std::move(picture)), width_(width) {
    const int height = static_cast<int>(picture_.size()) / width;
    int side = 1;
    while (2 * side < std::max(width, height)) side *= 2;
    sides_ = {side};
    levels_ = {halve(picture_, width, height, side)};
    while (side > 1) {
      const int half = side / 2;
      levels_.push_back(halve(levels_.back(), side, side, half));
      sides_.push_back(side = half);
    }
  }

  std::size_t depth() const { return levels_.size(); }

  std::vector<double> read(int level) const {
    if (level == 0) return picture_;
    const auto& values = levels_[static_cast<std::size_t>(level - 1)];
    const int side = sides_[static_cast<std::size_t>(level - 1)], step = 1 << level;
    std::vector<double> result(picture_.size());
    for (std::size_t i = 0; i < result.size(); ++i) {
      const int x = static_cast<int>(i) % width_, y = static_cast<int>(i) / width_;
      const int left = x / step, top = y / step;
      const int right = std::min(side - 1, left + 1), bottom = std::min(side - 1, top + 1);
      const double s = static_cast<double>(x % step) / step, t = static_cast<double>(y % step) / step;
      const auto at = [&](int u, int v) { return values[static_cast<std::size_t>(v * side + u)]; };
      result[i] = (1 - t) * ((1 - s) * at(left, top) + s * at(right, top)) +
                  t * ((1 - s) * at(left, bottom) + s * at(right, bottom));
    }
    return result;
  }

 private:
  static std::vector<double> halve(const std::vector<double>& from, int width, int height, int side) {
    static constexpr std::array<double, 5> kFilter{.05, .25, .4, .25, .05};
    std::vector<double> to(static_cast<std::size_t>(side) * static_cast<std::size_t>(side));
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        double sum = 0;
        for (int j = 0; j < 5; ++j) {
          for (int i = 0; i < 5; ++i) {
            const int u = 2 * x + i - 2, v = 2 * y + j - 2;
            if (u < 0 || v < 0 || u >= width || v >= height) continue;
            sum += kFilter[static_cast<std::size_t>(i)] * kFilter[static_cast<std::size_t>(j)] *
                   from[static_cast<std::size_t>(v * width + u)];
          }
        }
        to[static_cast<std::size_t>(y * side + x)] = sum;
      }
    }
    return to;
  }

  std::vector<double> picture_;
  int width_;
  std::vector<std::vector<double>> levels_;
  std::vector<int> sides_;
};

std::vector<double> scale_to_key(const HdrImage& image, const ToneRecord& record) {
  std::vector<double> scaled(image.pixel_count());
  for (std::size_t i = 0; i < scaled.size(); ++i)
    scaled[i] = record.key * image.pixel(i)[1] / record.log_average;
  return scaled;
}

// The peer looks at seven centres, at sizes of 43^(i / 8), and takes the eighth where all are even.
LocalTone make_peers_choice(double phi) {
  LocalTone local;
  local.sharpening = phi;
  return local;
}

TEST(PeerReinhard, TheLocalFormDiffersByItsPyramidAlone) {
  const HdrImage image = make_picture();
  ToneRecord record = make_peers_record(image, .18);
  record.white = 0;
  const std::vector<double> scaled = scale_to_key(image, record);
  const Pyramid pyramid(scaled, kWidth);
  ASSERT_EQ(pyramid.depth(), 7u);  // of 64 to 1: as many as there are centres beside the picture itself
  const std::vector<double> weights(scaled.size(), 1);
  for (const double phi : {1.0, 8.0}) {
    const std::vector<float> theirs = map_by_peer(image, fmt::format("--scales --phi {}", phi));
    const LocalTone local = make_peers_choice(phi);
    // At the last index the same again: an eighth centre without a surround of its own.
    const auto by_pyramid =
        choose_surrounds([&](int index) { return pyramid.read(std::min(index, 7)); }, local);
    const auto by_gaussians = choose_surrounds(
        [&](int index) { return blur_gaussian(scaled, weights, kWidth, find_scale(local, index)); }, local);
    std::vector<double> differences;
    for (std::size_t i = 0; i < scaled.size(); ++i) {
      ASSERT_NEAR(scaled[i] / (1 + by_pyramid[i]), theirs[i], 2e-6 * theirs[i]) << i << ", phi " << phi;
      differences.push_back(std::abs(scaled[i] / (1 + by_gaussians[i]) / theirs[i] - 1));
    }
    std::sort(differences.begin(), differences.end());
    fmt::print(
        "phi {}: the peer's pyramid changes half the pixels by {:.2f} % or more, a tenth by {:.2f} %\n", phi,
        100 * differences[differences.size() / 2], 100 * differences[differences.size() * 9 / 10]);
    EXPECT_LT(differences[differences.size() / 2], .05);
  }
}

}  // namespace
}  // namespace equilux::test
