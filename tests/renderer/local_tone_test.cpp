// The local operator against closed forms and a plain double sum.
#include "renderer/local_tone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include "base/random.h"
#include "renderer/tone.h"

namespace equilux {
namespace {

constexpr ToneMapping kLocal{ToneOperator::kLocal, .18, Exposure::kBackground};

HdrImage make_noise(int width, int height, float darkest) {
  HdrImage image(width, height);
  RandomStream random(11, "local-tone", 0);
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    const float value = darkest * std::pow(30.0f, random.next_float());
    for (int c = 0; c < 3; ++c) image.pixel(i)[c] = value;
  }
  return image;
}

HdrImage constant(int width, int height, float value) {
  HdrImage image(width, height);
  for (float& v : image.values) v = value;
  return image;
}

// A pixel's square as seen from another's centre: the Gaussian's integral over it, by the midpoint rule.
double integrate_square(double dx, double dy, double radius) {
  constexpr int kSteps = 40;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double x = dx + (i + .5) / kSteps - .5, y = dy + (j + .5) / kSteps - .5;
      sum += std::exp(-(x * x + y * y) / (radius * radius));
    }
  }
  return sum / (kSteps * kSteps * M_PI * radius * radius);
}

TEST(LocalTone, ScalesGoFromOneTo43PixelsBySteps16) {
  const LocalTone tone;
  EXPECT_NEAR(find_scale(tone, 0), 1, 1e-12);
  EXPECT_NEAR(find_scale(tone, 8), 43, 1e-9);
  for (int i = 0; i < 8; ++i) EXPECT_NEAR(find_scale(tone, i + 1) / find_scale(tone, i), 1.6, .001);
}

TEST(LocalTone, TheBlurIsThePlainSumOverAllPixels) {
  constexpr int kWidth = 9, kHeight = 7;
  RandomStream random(3, "blur", 0);
  std::vector<double> values(kWidth * kHeight), weights(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = random.next_float();
    weights[i] = random.next_float() < .6f;
  }
  for (const double scale : {1.0, 2.56, 11.0}) {
    const auto blurred = blur_gaussian(values, weights, kWidth, scale);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        double sum = 0, all = 0;
        for (int v = 0; v < kHeight; ++v) {
          for (int u = 0; u < kWidth; ++u) {
            const double share = integrate_square(u - x, v - y, scale / (2 * std::sqrt(2.0))) *
                                 weights[static_cast<std::size_t>(v * kWidth + u)];
            sum += share * values[static_cast<std::size_t>(v * kWidth + u)];
            all += share;
          }
        }
        EXPECT_NEAR(blurred[static_cast<std::size_t>(y * kWidth + x)], sum / all, 2e-3) << scale;
      }
    }
  }
}

TEST(LocalTone, AnEdgeIsBlurredToItsErrorFunction) {
  constexpr int kWidth = 200;
  constexpr double kRadius = 16 / 2.8284271247461903;
  std::vector<double> values(kWidth * 3), weights(values.size(), 1.0);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = i % kWidth >= 100;
  const auto blurred = blur_gaussian(values, weights, kWidth, 16);
  for (int x = 60; x < 140; ++x) {
    const double edge = (x - 99.5) / kRadius;
    EXPECT_NEAR(blurred[static_cast<std::size_t>(kWidth + x)], (1 + std::erf(edge)) / 2, 1e-9) << x;
  }
}

TEST(LocalTone, WithoutWeightNothingIsSeen) {
  const auto blurred = blur_gaussian({1, 2, 3, 4}, {0, 0, 0, 0}, 2, 3);
  EXPECT_EQ(blurred, std::vector<double>(4, 0.0));
}

TEST(LocalTone, TheFirstSurroundThatDiffersStopsTheGrowth) {
  LocalTone tone;
  tone.sharpening = 0;
  // One pixel; its Gaussians differ first from the third to the fourth.
  const std::vector<double> centres{1, 1.001, 1.002, 1.9, 1.9, 1.9, 1.9, 1.9, 1.9};
  int asked = 0;
  const auto blur = [&](int index) {
    EXPECT_EQ(index, asked++);
    return std::vector<double>{centres[static_cast<std::size_t>(index)]};
  };
  EXPECT_EQ(choose_surrounds(blur, tone), std::vector<double>{1.002});
  // Where all are even, the largest centre.
  asked = 0;
  EXPECT_EQ(choose_surrounds(
                [&](int index) {
                  EXPECT_EQ(index, asked++);
                  return std::vector<double>{1 + 1e-4 * index};
                },
                tone),
            std::vector<double>{1 + 1e-4 * 7});
}

TEST(LocalTone, AConstantPictureIsShownByReinhardsFormulaUpToItsBorders) {
  const HdrImage image = constant(60, 50, 3);
  const ToneCurve tone = make_tone_curve(image, HdrImage(60, 50, 1), kLocal);
  EXPECT_EQ(tone.record.tone_operator, "local");
  EXPECT_EQ(tone.record.white, 0);
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    EXPECT_NEAR(eval_display(tone, i, image.pixel(i))[0], 255 * encode_srgb(.18 / 1.18), 1e-3) << i;
  }
}

// The rule in one place and by plain sums, for a picture of 40 x 30.
TEST(LocalTone, APictureIsShownAsTheRuleWrittenOutSays) {
  const HdrImage image = make_noise(40, 30, .05f);
  const ToneCurve tone = make_tone_curve(image, HdrImage(40, 30, 1), kLocal);
  const double scale_to_key = .18 / tone.record.log_average;
  const auto centre_at = [&](int x, int y, double size) {
    const double a = 2 * std::sqrt(2.0) / size;
    const auto line = [&](int d) { return std::erf(a * (d + .5)) - std::erf(a * (d - .5)); };
    double sum = 0, all = 0;
    for (int v = 0; v < 30; ++v) {
      for (int u = 0; u < 40; ++u) {
        const double share = line(u - x) * line(v - y);
        sum += share * scale_to_key * image.pixel(static_cast<std::size_t>(v * 40 + u))[0];
        all += share;
      }
    }
    return sum / all;
  };
  std::array<int, 9> chosen{};
  for (int y = 0; y < 30; y += 4) {
    for (int x = 0; x < 40; x += 3) {
      double around = 0;
      for (int s = 0; s < 8; ++s) {
        const double size = std::pow(43.0, s / 8.0), centre = centre_at(x, y, size);
        around = centre;
        const double differs = centre - centre_at(x, y, std::pow(43.0, (s + 1) / 8.0));
        ++chosen[static_cast<std::size_t>(s)];
        if (std::abs(differs) > .05 * (.18 * 256 / (size * size) + centre)) break;
      }
      const auto pixel = static_cast<std::size_t>(y * 40 + x);
      EXPECT_NEAR(tone.surrounds[pixel], around, 1e-4 * around) << x << " " << y;
    }
  }
  EXPECT_GT(chosen[0], chosen[7]);  // the picture has some of each
  EXPECT_GT(chosen[7], 0);
}

TEST(LocalTone, TheObjectDodgesNoWallUnlessTheWholePictureIsAsked) {
  HdrImage dark = make_noise(50, 40, .1f), bright = dark, coverage(50, 40, 1);
  for (int y = 10; y < 30; ++y) {
    for (int x = 15; x < 35; ++x) {
      const auto i = static_cast<std::size_t>(y * 50 + x);
      coverage.values[i] = x == 15 ? .5f : 1;
      for (int c = 0; c < 3; ++c) bright.pixel(i)[c] *= 40;
    }
  }
  ToneMapping whole = kLocal;
  whole.exposure = Exposure::kWhole;
  double largest = 0;
  const ToneCurve a = make_tone_curve(dark, coverage, kLocal), b = make_tone_curve(bright, coverage, kLocal);
  const ToneCurve c = make_tone_curve(bright, coverage, whole);
  const double same_scale = c.record.log_average / a.record.log_average;
  double object = 0;
  for (std::size_t i = 0; i < coverage.values.size(); ++i) {
    if (coverage.values[i] > 0) {
      object = std::max(object, std::abs(b.surrounds[i] / a.surrounds[i] - 1.0));
      continue;
    }
    EXPECT_EQ(a.surrounds[i], b.surrounds[i]) << i;
    largest = std::max(largest, std::abs(c.surrounds[i] * same_scale / a.surrounds[i] - 1));
  }
  EXPECT_GT(largest, .5);
  EXPECT_GT(object, 5);
}

TEST(LocalTone, ATestPictureIsShownByItsReferencesSurroundings) {
  const HdrImage reference = make_noise(50, 40, .1f);
  HdrImage coverage(50, 40, 1), darker = reference;
  for (int y = 10; y < 30; ++y) {
    for (int x = 15; x < 35; ++x) {
      const auto i = static_cast<std::size_t>(y * 50 + x);
      coverage.values[i] = 1;
      for (int c = 0; c < 3; ++c) darker.pixel(i)[c] *= .25f;
    }
  }
  const ToneCurve tone = make_tone_curve(reference, coverage, kLocal);
  const LdrImage shown = apply_tone_curve(reference, tone), test = apply_tone_curve(darker, tone);
  double darkest = 1;
  for (std::size_t i = 0; i < coverage.values.size(); ++i) {
    if (coverage.values[i] == 0) {
      EXPECT_EQ(shown.values[3 * i], test.values[3 * i]);
    } else {
      // A quarter of the light is a quarter of the displayed luminance, whatever is around it.
      const double ratio = eval_display(tone, i, darker.pixel(i))[1];
      EXPECT_NEAR(decode_srgb(ratio / 255),
                  decode_srgb(eval_display(tone, i, reference.pixel(i))[1] / 255) / 4, .01);
      darkest = std::min(darkest, test.values[3 * i] / std::max(1.0, 1.0 * shown.values[3 * i]));
    }
  }
  EXPECT_LT(darkest, .6);
}

TEST(LocalTone, ExtremesHaveADefinedAnswer) {
  const HdrImage coverage(60, 40, 1), black = constant(60, 40, 0), faint = constant(60, 40, 1e-30f);
  for (auto value : apply_tone_curve(black, make_tone_curve(black, coverage, kLocal)).values)
    EXPECT_EQ(value, 0);
  HdrImage hot = constant(60, 40, 1);
  constexpr std::size_t kHot = 10 * 60 + 5;
  hot.pixel(kHot)[1] = 1e30f;
  const ToneCurve tone = make_tone_curve(hot, coverage, kLocal);
  for (float around : tone.surrounds) EXPECT_TRUE(std::isfinite(around));
  const LdrImage shown = apply_tone_curve(hot, tone);
  EXPECT_EQ(shown.values[3 * kHot + 1], 255);
  // The surroundings stop growing before they see it, but for those that touch it.
  const double plain = 255 * encode_srgb(.18 / 1.18);
  for (std::size_t i = 0; i < hot.pixel_count(); ++i) {
    const auto dx = static_cast<double>(i % 60) - 5, dy = static_cast<double>(i / 60) - 10;
    if (std::hypot(dx, dy) > 4) {
      EXPECT_NEAR(shown.values[3 * i], plain, 2) << i;
    }
  }
  EXPECT_NEAR(eval_display(make_tone_curve(faint, coverage, kLocal), 7, faint.pixel(7))[0], plain, .01);
}

}  // namespace
}  // namespace equilux
