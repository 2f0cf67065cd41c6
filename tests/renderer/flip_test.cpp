// FLIP on identities and on pictures whose error is known in closed form.
#include "renderer/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "renderer/tone.h"

namespace equilux {
namespace {

constexpr double kPixelsPerDegree = 35;

using Colour = std::array<std::uint8_t, 3>;

LdrImage fill(int width, int height, Colour colour) {
  LdrImage image(width, height);
  for (std::size_t i = 0; i < image.values.size(); ++i) image.values[i] = colour[i % 3];
  return image;
}

// Left half one colour, right half another.
LdrImage halve(int width, int height, Colour left, Colour right) {
  LdrImage image = fill(width, height, left);
  for (int y = 0; y < height; ++y) {
    for (int x = width / 2; x < width; ++x) {
      for (std::size_t c = 0; c < 3; ++c)
        image.values[3 * static_cast<std::size_t>(y * width + x) + c] = right[c];
    }
  }
  return image;
}

// CIELab of sRGB values by the textbook's formulas, chroma scaled by lightness.
std::array<double, 3> hunt_lab(Colour colour) {
  const double r = decode_srgb(colour[0] / 255.0), g = decode_srgb(colour[1] / 255.0),
               b = decode_srgb(colour[2] / 255.0);
  const double x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505, y = 0.2126 * r + 0.7152 * g + 0.0722 * b,
               z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.0890;
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  const double lightness = 116 * f(y) - 16;
  return {lightness, lightness / 100 * 500 * (f(x) - f(y)), lightness / 100 * 200 * (f(y) - f(z))};
}

double hyab(Colour one, Colour other) {
  const auto a = hunt_lab(one), b = hunt_lab(other);
  return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

// Of two pictures of one colour each: no feature differs, and filters change nothing.
double flat_error(Colour a, Colour b) {
  const double largest = std::pow(hyab({0, 255, 0}, {0, 0, 255}), 0.7), knee = 0.4 * largest;
  const double difference = std::pow(hyab(a, b), 0.7);
  return difference < knee ? 0.95 * difference / knee : 0.95 + 0.05 * (difference - knee) / (largest - knee);
}

TEST(Flip, OfAPictureAndItselfIsNothing) {
  LdrImage noise(31, 17);
  for (std::size_t i = 0; i < noise.values.size(); ++i)
    noise.values[i] = static_cast<std::uint8_t>(i * 7919 % 251);
  for (double error : measure_flip(noise, noise, kPixelsPerDegree)) EXPECT_EQ(error, 0);
}

TEST(Flip, OfFlatColoursIsTheirDistance) {
  const std::pair<Colour, Colour> pairs[] = {{{0, 0, 0}, {255, 255, 255}},
                                             {{0, 255, 0}, {0, 0, 255}},
                                             {{120, 120, 120}, {124, 124, 124}},
                                             {{200, 40, 60}, {190, 60, 60}}};
  for (const auto& [a, b] : pairs) {
    const auto errors = measure_flip(fill(20, 12, a), fill(20, 12, b), kPixelsPerDegree);
    for (double error : errors) EXPECT_NEAR(error, flat_error(a, b), 2e-3);
  }
  EXPECT_NEAR(flat_error({0, 255, 0}, {0, 0, 255}), 1, 1e-12) << "the farthest two colours";
}

TEST(Flip, IsTheSameBothWaysAndUpTo1) {
  const LdrImage a = halve(24, 16, {250, 10, 10}, {20, 220, 40}),
                 b = halve(24, 16, {0, 0, 0}, {30, 200, 255});
  const auto there = measure_flip(a, b, kPixelsPerDegree), back = measure_flip(b, a, kPixelsPerDegree);
  for (std::size_t i = 0; i < there.size(); ++i) {
    EXPECT_NEAR(there[i], back[i], 1e-12);
    EXPECT_GE(there[i], 0);
    EXPECT_LE(there[i], 1);
  }
}

// An edge between black and white is an edge of size 1 beside none: the feature part is 1/sqrt(2)^0.5, and
// far from it the colour alone counts.
TEST(Flip, SeesAnEdgeThatAppears) {
  const LdrImage flat = fill(60, 20, {0, 0, 0}), edge = halve(60, 20, {0, 0, 0}, {255, 255, 255});
  const auto errors = measure_flip(flat, edge, kPixelsPerDegree);
  const std::size_t row = 10 * 60;
  EXPECT_EQ(errors[row + 5], 0);
  EXPECT_NEAR(errors[row + 55], flat_error({0, 0, 0}, {255, 255, 255}), 1e-3);
  // At the white side's first column the blurred luminance is known: what of the kernel lies on white.
  const double b = 0.0047, deviation = std::sqrt(b / 2) / std::numbers::pi * kPixelsPerDegree;
  double white = 0, all = 0;
  for (int i = -5; i <= 5; ++i) {
    const double weight = std::exp(-i * i / (2 * deviation * deviation));
    all += weight;
    if (i >= 0) white += weight;
  }
  const double y = white / all, lightness = 116 * std::cbrt(y) - 16;
  const double largest = std::pow(hyab({0, 255, 0}, {0, 0, 255}), 0.7), knee = 0.4 * largest;
  const double difference = std::pow(lightness, 0.7);
  const double colour = 0.95 + 0.05 * (difference - knee) / (largest - knee);
  EXPECT_NEAR(errors[row + 30], std::pow(colour, 1 - std::sqrt(std::sqrt(0.5))), 2e-3);
}

// From farther away the same pixels blur together: fine noise is seen less.
TEST(Flip, FallsWithDistance) {
  LdrImage flat = fill(64, 48, {128, 128, 128}), noise = flat;
  for (std::size_t i = 0; i < noise.values.size() / 3; ++i) {
    const auto value = static_cast<std::uint8_t>(128 + ((i * 2654435761u >> 7) % 2 ? 12 : -12));
    for (std::size_t c = 0; c < 3; ++c) noise.values[3 * i + c] = value;
  }
  double before = 1;
  for (double ppd : {10.0, 35.0, 120.0}) {
    const auto errors = measure_flip(flat, noise, ppd);
    double mean = 0;
    for (double error : errors) mean += error / static_cast<double>(errors.size());
    EXPECT_LT(mean, before * 0.95) << ppd;
    before = mean;
  }
}

}  // namespace
}  // namespace equilux
