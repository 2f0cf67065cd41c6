// Sets whose pictures are scaled to the light of the unclamped ones.
#include <cmath>
#include <gtest/gtest.h>

#include "renderer/set.h"
#include "renderer/tone.h"
#include "stimuli/exr_file.h"
#include "stimuli/png_file.h"
#include "tests/renderer/tiny_study.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

// The picture is made once more from the layers on disk, by a factor that is found here.
TEST(Set, NormalisedPicturesHaveTheMeanLuminanceOfTheUnclampedOnes) {
  const test::TinyStudy study("normalise");
  make_set({study.path(), study.folder() / "set", "*"});
  const auto layer = [&](const std::string& name) {
    return load_exr(study.folder() / "set/layers" / (name + ".exr")).image;
  };
  const auto sum_luminance = [](const HdrImage& image) {
    double sum = 0;
    for (std::size_t i = 0; i < image.pixel_count(); ++i)
      sum += luminance({image.pixel(i)[0], image.pixel(i)[1], image.pixel(i)[2]});
    return sum;
  };
  const std::string family = "G0-MS-ind-ref-v0";
  HdrImage clamped = layer("G0-MS-ind-100-C9-v0");
  const double factor = sum_luminance(layer("G0-MS-ind-100-C0-v0")) / sum_luminance(clamped);
  EXPECT_GT(factor, 1.5);
  for (float& value : clamped.values) value = static_cast<float>(value * factor);
  const HdrImage background = layer(family + ".background"), direct = layer(family + ".direct"),
                 indirect = layer(family + ".indirect");
  const ToneCurve tone = make_tone_curve(composite({&background, &direct, &indirect}),
                                         layer(family + ".coverage"), ToneMapping{});
  const LdrImage made = apply_tone_curve(composite({&background, &direct, &clamped}), tone);
  const LdrImage picture = load_png(study.folder() / "set/pictures/G0-MS-ind-100-C9n-v0.png");
  int differing = 0, most = 0;
  for (std::size_t i = 0; i < made.values.size(); ++i) {
    const int difference = std::abs(int(made.values[i]) - int(picture.values[i]));
    differing += difference > 0;
    most = std::max(most, difference);
  }
  EXPECT_LE(most, 1);  // rounding of half floats on their way to a step's edge
  EXPECT_LT(differing, static_cast<int>(made.values.size() / 20));
}

// Cuts are made at the levels of the study, and a normalised picture needs that without a clamp beside its
// own.
TEST(Set, OfNormalisedPicturesByCutsIsWholeWithoutTheUnclampedLevelInTheStudy) {
  const test::TinyStudy study("normalise-many");
  Json json = study.load().source;
  save_text(study.path(), format_json(json.set("clamp_levels", parse_json(R"(["C2","C3","C4","C5"])", ""))));
  const SetSummary summary = make_set({study.path(), study.folder() / "set", "G0-GS-*-v0"});
  EXPECT_EQ(summary.pictures, 1u + 4u);
  EXPECT_TRUE(fs::exists(study.folder() / "set/layers/G0-GS-ind-30k-C0-v0.exr"));
  EXPECT_TRUE(fs::exists(study.folder() / "set/pictures/G0-GS-ind-30k-C5n-v0.png"));
  EXPECT_EQ(make_set({study.path(), study.folder() / "set", "G0-GS-*-v0"}).layers_rendered, 0u);
}

}  // namespace
}  // namespace equilux
