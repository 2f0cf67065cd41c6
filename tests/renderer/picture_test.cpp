// One picture: each object's layers are its own, whatever is asked of the others.
#include "renderer/picture.h"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <limits>

#include "base/error.h"
#include "tests/renderer/test_scene.h"
#include "tests/support/failures.h"
#include "tests/support/statistics.h"

namespace equilux {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Two balls close together in a room whose far wall alone is lit.
constexpr const char* kTwoBalls = R"({
  "schema": "equilux-scene", "schema_version": 1, "name": "two-balls",
  "camera": {"position": [0, -3, 1.2], "target": [0, 0, 0.9], "up": [0, 0, 1], "vertical_fov_degrees": 40},
  "materials": [
    {"name": "MS", "model": "ward-duer", "rho_d": [0.03, 0.03, 0.03], "rho_s": [0.22, 0.22, 0.22], "alpha": 0.05},
    {"name": "LG", "model": "lambertian", "rho_d": [0.19, 0.19, 0.19]},
    {"name": "wall", "model": "lambertian", "rho_d": [0.7, 0.5, 0.4]}],
  "meshes": [
    {"name": "large", "sphere": {"radius": 0.5, "subdivisions": 4}},
    {"name": "small", "sphere": {"radius": 0.3, "subdivisions": 4}},
    {"name": "floor", "quad": {"u": [8, 0, 0], "v": [0, 8, 0]}},
    {"name": "back", "quad": {"u": [8, 0, 0], "v": [0, 0, 3]}}],
  "instances": [
    {"mesh": "floor", "material": "wall", "at": [-4, -4, 0]},
    {"mesh": "back", "material": "wall", "at": [-4, 2, 0]}],
  "pivot": [0, 0, 0.4],
  "sculptures": [
    {"name": "Large", "mesh": "large", "material": "MS", "stand": [-0.4, 0.2, 0.4]},
    {"name": "Small", "mesh": "small", "material": "LG", "stand": [0.35, -0.3, 0.4]}],
  "lights": [
    {"spot": {"position": [0, -1, 2.8], "target": [0, 2, 1.6], "inner_degrees": 10, "outer_degrees": 20,
              "intensity": [20, 19, 18]}},
    {"rectangle": {"corner": [-0.5, -0.5, 2.8], "u": [0, 1, 0], "v": [1, 0, 0], "radiance": [5, 5, 5]},
     "illuminations": ["dir"]}]
})";

class SculpturePicture : public testing::Test {
 protected:
  PictureParams vpl_params(double clamp) const {
    PictureParams params;
    params.scene_path = path_;
    params.width = 48;
    params.height = 36;
    params.positions = 2;
    params.paths = {32, 32, 32};
    params.vpl_count = 2000;
    params.clamp_per_m2 = clamp;
    return params;
  }
  void SetUp() override { save_text(path_, kTwoBalls); }

  const test::Folder folder_;
  const std::filesystem::path path_ = folder_ / "scene.json";
};

double mean_luminance(const HdrImage& layer) {
  double sum = 0;
  for (std::size_t i = 0; i < layer.pixel_count(); ++i) {
    const float* p = layer.pixel(i);
    sum += luminance({p[0], p[1], p[2]});
  }
  return sum / static_cast<double>(layer.pixel_count());
}

TEST_F(SculpturePicture, IsTheSumOfItsLayersAndCoversEachPixelOnce) {
  for (const bool vpls : {false, true}) {
    PictureParams params = vpl_params(10);
    params.illumination = Illumination::kDirectAndIndirect;
    if (!vpls) params.vpl_count.reset();
    const Picture picture = make_picture(params);
    ASSERT_EQ(picture.objects.size(), 2u);
    for (std::size_t i = 0; i < picture.image.values.size(); ++i) {
      double sum = picture.background.values[i];
      for (const ObjectLayers& object : picture.objects)
        sum += double{object.direct.values[i]} + object.indirect.values[i];
      ASSERT_NEAR(picture.image.values[i], sum, 1e-5 * (1 + sum));
    }
    int shared = 0;
    for (std::size_t i = 0; i < picture.image.pixel_count(); ++i) {
      const float large = picture.objects[0].coverage.values[i],
                  small = picture.objects[1].coverage.values[i];
      ASSERT_LE(large + small, 1);
      shared += large > 0 && small > 0;
    }
    EXPECT_GT(shared, 0) << "the balls meet in the picture, so that a pixel may hold both";
    EXPECT_GT(mean_luminance(picture.objects[0].direct), 0);
  }
}

// The split by objects is bit for bit the picture that a world of the same parts gives as a whole.
TEST_F(SculpturePicture, OfOneSculptureHasItsCoverageAndTheOthersInTheRoom) {
  PictureParams params = vpl_params(10);
  const Picture all = make_picture(params);
  params.geometry = "Small";
  const Picture one = make_picture(params);
  ASSERT_EQ(one.objects.size(), 1u);
  EXPECT_EQ(one.objects[0].coverage.values, all.objects[1].coverage.values);
  EXPECT_GT(mean_luminance(one.background), mean_luminance(all.background));
}

TEST_F(SculpturePicture, LeavesOneObjectAsItIsWhenAnotherIsClampedOtherwise) {
  const Picture uniform = make_picture(vpl_params(10));
  PictureParams params = vpl_params(10);
  params.clamps_by_object["Large"] = 0.1;
  const Picture mixed = make_picture(params);
  const Picture other = make_picture(vpl_params(0.1));
  EXPECT_EQ(mixed.background.values, uniform.background.values);
  EXPECT_EQ(mixed.objects[1].indirect.values, uniform.objects[1].indirect.values);
  EXPECT_NE(mixed.objects[0].indirect.values, uniform.objects[0].indirect.values);
  EXPECT_EQ(mixed.objects[0].indirect.values, other.objects[0].indirect.values);
  EXPECT_EQ(mixed.objects[0].clamp_per_m2, 0.1);
}

// A common factor would leave one object too dark and the other too bright: their losses differ.
TEST_F(SculpturePicture, NormalisesEachObjectToItsOwnUnclampedMean) {
  const Picture unclamped = make_picture(vpl_params(kInfinity));
  const Picture clamped = make_picture(vpl_params(1));
  PictureParams params = vpl_params(1);
  params.normalise = true;
  const Picture normalised = make_picture(params);
  double factors[2];
  for (std::size_t i = 0; i < 2; ++i) {
    const double wanted = mean_luminance(unclamped.objects[i].indirect);
    EXPECT_NEAR(mean_luminance(normalised.objects[i].indirect) / wanted, 1, 1e-5) << i;
    factors[i] = wanted / mean_luminance(clamped.objects[i].indirect);
  }
  EXPECT_GT(factors[0], 1.2 * factors[1]) << "the smooth metal loses more than the grey";
  EXPECT_EQ(normalised.background.values, clamped.background.values);
}

// Two clamps in one picture, 48 seeds of it and of the path-traced one: level .01 over both objects; what the
// clamp takes is many times the error.
TEST_F(SculpturePicture, CompensatesEachObjectForItsOwnClamp) {
  PictureParams params = vpl_params(1);
  params.vpl_count = 400;
  params.clamps_by_object["Small"] = 0.003;
  params.compensate = true;
  std::array<std::vector<double>, 2> differences, losses;
  for (params.seed = 1; params.seed <= 48; ++params.seed) {
    const Picture compensated = make_picture(params);
    PictureParams paths = params;
    paths.vpl_count.reset();
    paths.clamps_by_object.clear();
    paths.compensate = false;
    const Picture traced = make_picture(paths);
    for (std::size_t i : {0u, 1u}) {
      const ObjectLayers& object = compensated.objects[i];
      const double whole = mean_luminance(traced.objects[i].indirect);
      differences[i].push_back(mean_luminance(object.indirect) - whole);
      losses[i].push_back(mean_luminance(*object.compensation));
    }
  }
  for (std::size_t i : {0u, 1u}) {
    const test::Mean difference = test::mean_of(differences[i]), loss = test::mean_of(losses[i]);
    EXPECT_LT(std::abs(difference.mean), 2.9 * difference.standard_error) << i;
    EXPECT_GT(loss.mean, 10 * difference.standard_error) << i;
  }
}

TEST_F(SculpturePicture, RefusesSettingsOfObjectsThatAreNotThere) {
  PictureParams params = vpl_params(10);
  params.clamps_by_object["Tall"] = 1;
  EXPECT_THAT(message_of<InputError>([&] { make_picture(params); }),
              AllOf(HasSubstr("--clamp"), HasSubstr("Large, Small"), HasSubstr("Tall")));
  params = vpl_params(10);
  params.material = "LG";
  EXPECT_THAT(message_of<InputError>([&] { make_picture(params); }), HasSubstr("--material"));
  params.geometry = "Tall";
  EXPECT_THAT(message_of<InputError>([&] { make_picture(params); }), HasSubstr("the geometry Tall"));
}

constexpr const char* kBallBeforeNothing = R"({
  "schema": "equilux-scene", "schema_version": 1, "name": "before-nothing",
  "camera": {"position": [0, -3, 0.3], "target": [0, 0, 0], "up": [0, 0, 1], "vertical_fov_degrees": 30},
  "materials": [{"name": "MS", "model": "lambertian", "rho_d": [0.5, 0.5, 0.5]}],
  "meshes": [
    {"name": "ball", "sphere": {"radius": 0.5, "subdivisions": 4}},
    {"name": "wall", "quad": {"u": [6, 0, 0], "v": [0, 0, 4]}}],
  "instances": [{"mesh": "wall", "material": "MS", "at": [-3, -3.5, -2]}],
  "object": {"stand": [0, 0, -0.5], "geometries": [{"name": "G0", "mesh": "ball"}]},
  "lights": [{"spot": {"position": [0, -2, 3], "target": [0, -3.5, 0], "inner_degrees": 20,
                       "outer_degrees": 30, "intensity": [1, 1, 1]}}]
})";

// Light that a million times as dim a spot gives is cut as finely, also where nothing but VPLs brings any.
TEST(BlackBackground, WhatIsSeenOfAStepIsRelativeToTheLightThereIs) {
  const test::Folder folder;
  const auto make = [&](float intensity) {
    std::string text = kBallBeforeNothing;
    const std::string one = "[1, 1, 1]";
    text.replace(text.find(one), one.size(), fmt::format("[{0}, {0}, {0}]", intensity));
    PictureParams params;
    params.scene_path = folder / "scene.json";
    save_text(params.scene_path, text);
    params.width = 24;
    params.height = 18;
    params.positions = 1;
    params.paths = {16, 16, 16};
    params.vpl_count = 5000;
    params.clamp_per_m2 = kInfinity;
    return make_picture(params);
  };
  const Picture bright = make(1), dim = make(0x1p-20f);
  ASSERT_GT(mean_luminance(bright.image), 0);
  for (std::size_t i = 0; i < bright.image.values.size(); ++i)
    ASSERT_EQ(dim.image.values[i], 0x1p-20f * bright.image.values[i]) << i;
  EXPECT_EQ(dim.display.values, bright.display.values);
}

}  // namespace
}  // namespace equilux
