// Tone curves against closed forms, and what must have a defined answer.
#include "renderer/tone.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <optional>

namespace equilux {
namespace {

HdrImage constant(int width, int height, float value) {
  HdrImage image(width, height);
  for (float& v : image.values) v = value;
  return image;
}

HdrImage no_coverage(const HdrImage& image) { return HdrImage(image.width, image.height, 1); }

TEST(Tone, AConstantPictureIsShownAtTheKeyByReinhardsFormula) {
  const HdrImage image = constant(8, 8, 3.0f);
  const ToneCurve tone = make_tone_curve(image, no_coverage(image), ToneMapping{});
  // L = key x Lw / Lavg = .18 (delta is 1e-6 of the mean), white = .18: Ld = L (1 + L / white^2) / (1 + L)
  // = 1.
  EXPECT_NEAR(tone.record.log_average, 3.0, 1e-5);
  EXPECT_NEAR(tone.record.white, .18, 1e-6);
  EXPECT_NEAR(eval_display(tone, 0, image.pixel(0))[1], 255, .01);
}

TEST(Tone, MiddleGreyFallsWhereTheFormulaSays) {
  const ToneCurve tone{{1.0, 4.0, 0, .18, "background"}, {}};
  const float rgb[3] = {1, 1, 1};
  const double ld = .18 * (1 + .18 / 16) / 1.18;
  EXPECT_NEAR(eval_display(tone, 0, rgb)[0], 255 * (1.055 * std::pow(ld, 1 / 2.4) - .055), 1e-6);
}

TEST(Tone, TheCurveIsTakenOutsideTheObject) {
  HdrImage image = constant(10, 10, 1.0f);
  HdrImage coverage = no_coverage(image);
  for (std::size_t i = 0; i < 50; ++i) {
    coverage.values[i] = .25f;
    for (int c = 0; c < 3; ++c) image.pixel(i)[c] = 1000;
  }
  const auto background = make_tone_curve(image, coverage, ToneMapping{});
  const auto whole =
      make_tone_curve(image, coverage, ToneMapping{ToneOperator::kGlobal, .18, Exposure::kWhole});
  EXPECT_NEAR(background.record.log_average, 1, 1e-4);
  EXPECT_NEAR(whole.record.log_average, std::sqrt(1000.0), .1);
}

TEST(Tone, OneHotPixelDoesNotSetTheWhitePoint) {
  HdrImage image = constant(100, 20, 1.0f);
  image.pixel(7)[1] = 1e30f;
  const auto tone = make_tone_curve(image, no_coverage(image), ToneMapping{});
  EXPECT_LT(tone.record.white, 10);
  EXPECT_TRUE(std::isfinite(tone.record.log_average));
}

TEST(Tone, ABlackPictureStaysBlack) {
  const HdrImage image = constant(4, 4, 0);
  const auto tone = make_tone_curve(image, no_coverage(image), ToneMapping{});
  for (auto value : apply_tone_curve(image, tone).values) EXPECT_EQ(value, 0);
}

TEST(Tone, AnObjectThatCoversEverythingFallsBackToTheWholePicture) {
  const HdrImage image = constant(4, 4, 2);
  HdrImage coverage = no_coverage(image);
  for (float& value : coverage.values) value = 1;
  EXPECT_NEAR(make_tone_curve(image, coverage, ToneMapping{}).record.log_average, 2, 1e-4);
}

// An object before nothing: its picture does not depend on how bright it is.
TEST(Tone, ABlackBackgroundLeavesTheCurveToTheObject) {
  std::optional<LdrImage> first;
  for (const float light : {1.0f, 0x1p-40f, 0x1p20f}) {
    HdrImage image = constant(10, 10, 0), coverage = no_coverage(image);
    for (std::size_t i = 0; i < 20; ++i) {
      coverage.values[i] = 1;
      for (int c = 0; c < 3; ++c) image.pixel(i)[c] = (i < 10 ? 1.0f : 4.0f) * light;
    }
    const ToneCurve tone = make_tone_curve(image, coverage, ToneMapping{});
    EXPECT_NEAR(tone.record.log_average / light, 2, 1e-4);
    EXPECT_EQ(tone.record.exposure, "background");
    const LdrImage picture = apply_tone_curve(image, tone);
    if (!first) first = picture;
    EXPECT_EQ(picture.values, first->values);
    EXPECT_GT(picture.values[0], 50);
    EXPECT_LT(picture.values[0], 200);
  }
}

TEST(Tone, NoiseInDisplayStepsIsTheSlopeOfTheCurve) {
  const HdrImage image = constant(10, 10, 1), error = constant(10, 10, .001f);
  HdrImage coverage = no_coverage(image);
  coverage.values[0] = 1;
  const ToneCurve tone{{1.0, 4.0, 0, .18, "background"}, {}};
  const float high[3] = {1.001f, 1.001f, 1.001f}, low[3] = {.999f, .999f, .999f};
  const double half = (eval_display(tone, 0, high)[0] - eval_display(tone, 0, low)[0]) / 2;
  const auto noise = measure_display_noise(image, error, coverage, tone);
  EXPECT_NEAR(noise.object_mean, half, 1e-9);
  EXPECT_NEAR(noise.object_p99, half, 1e-9);
  EXPECT_NEAR(noise.outside_mean, half, 1e-9);
}

TEST(Tone, NormalisedLayersHaveTheMeanLuminanceOfTheUnclampedOne) {
  HdrImage clamped = constant(6, 6, .5f), unclamped = constant(6, 6, 0);
  unclamped.pixel(3)[1] = 100;
  const HdrImage scaled = normalise_luminance(clamped, unclamped);
  double sum = 0;
  for (std::size_t i = 0; i < 36; ++i) {
    const float* p = scaled.pixel(i);
    sum += .2126 * p[0] + .7152 * p[1] + .0722 * p[2];
  }
  EXPECT_NEAR(sum, 71.52, 1e-3);
  EXPECT_EQ(normalise_luminance(constant(6, 6, 0), unclamped).values, constant(6, 6, 0).values);
}

}  // namespace
}  // namespace equilux
