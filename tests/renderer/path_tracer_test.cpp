// The path tracer against closed forms.
#include "renderer/path_tracer.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "renderer/lights.h"
#include "renderer/reference.h"
#include "tests/renderer/test_scene.h"
#include "tests/support/statistics.h"

namespace equilux {
namespace {

using test::SceneText;

struct Traced {
  Primary primary;
  FamilyLayers layers;
  HdrImage coverage;
};

Traced trace(const Scene& scene, const std::string& material, PathCounts paths, int size = 32,
             std::uint64_t seed = 1) {
  const World world = make_world(scene, "G0", Illumination::kDirectAndIndirect);
  Traced traced;
  traced.primary = trace_primary(world, make_view_camera(scene, 0), size, size, 1);
  ReferenceParams params;
  params.fixed = paths;
  params.seed = seed;
  params.stream_name = params.background_stream_name = "test";
  traced.layers = trace_family({world, make_materials(world, find_material(scene, material)), traced.primary},
                               params, test::no_progress());
  traced.coverage = make_coverage(traced.primary);
  return traced;
}

// Means over the pixels that the object covers, of any channel.
test::Mean object_mean(const Traced& traced, const HdrImage& layer, std::size_t channel = 1) {
  std::vector<double> values;
  for (std::size_t i = 0; i < layer.pixel_count(); ++i) {
    if (traced.coverage.values[i] == 1) values.push_back(layer.pixel(i)[channel]);
  }
  return test::mean_of(values);
}

// A convex Lambertian body in a furnace of radiance 1 reflects rho at every point: L = rho / pi x integral of
// cos = rho.
TEST(PathTracer, ALambertianBallInAFurnaceShinesAtItsAlbedo) {
  SceneText text;
  text.lights = test::furnace_lights(6);
  const Traced traced = trace(test::make_scene(text), "grey", {16, 1024, 16});
  for (std::size_t i = 0; i < traced.coverage.pixel_count(); ++i) {
    if (traced.coverage.values[i] != 1) continue;
    // 1,024 paths a pixel, six lights: the estimate's standard error is under 1.5 %; five of them.
    EXPECT_NEAR(traced.layers.direct.pixel(i)[1], .5,
                5 * std::max(.002f, traced.layers.standard_error.pixel(i)[1]));
  }
  const auto mean = object_mean(traced, traced.layers.direct);
  EXPECT_NEAR(mean.mean, .5, 4 * mean.standard_error + .0005);
  EXPECT_EQ(object_mean(traced, traced.layers.indirect).mean, 0);  // the furnace's walls are black
}

// The same for Ward-Duer: the ball's albedo at normal incidence is rho_d + rho_s x lobe albedo, which is .998
// rho_s at alpha = .05.
TEST(PathTracer, AMetalBallInAFurnaceShinesAtItsAlbedoInTheMiddle) {
  SceneText text;
  text.materials =
      R"([{"name":"metal","model":"ward-duer","rho_d":[0.03,0.03,0.03],"rho_s":[0.22,0.22,0.22],"alpha":0.05}])";
  text.lights = test::furnace_lights(6);
  const Traced traced = trace(test::make_scene(text), "metal", {16, 4096, 16}, 33);
  const std::size_t middle = 16 * 33 + 16;
  EXPECT_NEAR(traced.layers.direct.pixel(middle)[1], .2495,
              5 * traced.layers.standard_error.pixel(middle)[1] + .0005);
}

// The furnace of a constant environment of radiance 2: a Lambertian ball shows twice its albedo wherever it
// is seen, and where nothing is seen the environment itself.
TEST(PathTracer, ALambertianBallInAConstantEnvironmentShinesAtItsAlbedo) {
  SceneText text;
  text.lights = R"([{"environment":{"radiance":[2,2,2]}}])";
  const Traced traced = trace(test::make_scene(text), "grey", {16, 256, 16}, 24);
  const auto mean = object_mean(traced, traced.layers.direct);
  EXPECT_NEAR(mean.mean, 2 * .5, 4 * mean.standard_error + .001);
  for (std::size_t i = 0; i < traced.coverage.pixel_count(); ++i) {
    if (traced.coverage.values[i] == 0) {
      ASSERT_EQ(traced.layers.background.pixel(i)[1], 2);
    }
  }
  EXPECT_EQ(object_mean(traced, traced.layers.indirect).mean, 0);  // a convex ball does not see itself
}

// Irradiance of a spot at distance d and incidence t is I cos t / d^2; a Lambertian plane reflects rho / pi
// of it.
TEST(PathTracer, ASpotOnAPlaneGivesTheInverseSquareLaw) {
  SceneText text;
  text.meshes = R"([{"name":"ball","quad":{"u":[8,0,0],"v":[0,8,0]}}])";
  text.camera = R"({"position":[4,4,3],"target":[4,4,0],"up":[0,1,0],"vertical_fov_degrees":30})";
  text.stand = "[0,0,0]";
  text.lights =
      R"([{"spot":{"position":[4,4,2],"target":[4,4,0],"inner_degrees":60,"outer_degrees":80,"intensity":[3,2,1]}}])";
  const Scene scene = test::make_scene(text);
  const Traced traced = trace(scene, "grey", {16, 16, 16}, 32);
  for (std::size_t i = 0; i < traced.coverage.pixel_count(); ++i) {
    const Vec3 p = traced.primary.at(i, 0).point.p;
    const double dx = p.x - 4, dy = p.y - 4, r2 = dx * dx + dy * dy + 4, cosine = 2 / std::sqrt(r2);
    const double expected = .5 / std::numbers::pi * cosine / r2;
    EXPECT_NEAR(traced.layers.direct.pixel(i)[0], 3 * expected, 3e-6);
    EXPECT_NEAR(traced.layers.direct.pixel(i)[2], expected, 3e-6);
  }
}

// A parallel square of side s at height h over a point: E = L x 4 x F of a quarter, the standard form factor
// of a parallel rectangle with a corner over the point: F = 1/(2 pi) (a/A atan(b/A) + b/B atan(a/B)), A =
// sqrt(1+a^2), B = sqrt(1+b^2), a = b = s / 2h.
TEST(PathTracer, ARectangleOverAPlaneGivesItsFormFactor) {
  SceneText text;
  text.meshes = R"([{"name":"ball","quad":{"u":[8,0,0],"v":[0,8,0]}}])";
  text.camera = R"({"position":[4.0,1.5,1.2],"target":[4,4,0],"up":[0,0,1],"vertical_fov_degrees":0.2})";
  text.stand = "[0,0,0]";
  text.lights = R"([{"rectangle":{"corner":[3,3,2],"u":[0,2,0],"v":[2,0,0],"radiance":[5,5,5]}}])";
  const Traced traced = trace(test::make_scene(text), "grey", {16, 4096, 16}, 16);
  const double a = .5, root = std::sqrt(1 + a * a);
  const double form = 4 * (1 / (2 * std::numbers::pi)) * 2 * (a / root * std::atan(a / root));
  const auto mean = object_mean(traced, traced.layers.direct);
  EXPECT_NEAR(mean.mean, .5 * 5 * form, 4 * mean.standard_error + 1e-4);
}

// Inside a closed Lambertian sphere of albedo rho with a point light of intensity I at its centre every wall
// point has the same irradiance E = I / R^2, and interreflection multiplies it by 1 / (1 - rho): indirect
// radiance = rho / pi x E rho / (1 - rho).
TEST(PathTracer, AnIntegratingSphereInterreflectsAsItsSeries) {
  SceneText text;
  text.meshes = R"([{"name":"ball","sphere":{"radius":2,"subdivisions":6}}])";
  text.camera = R"({"position":[0.5,0.3,0],"target":[2,0.3,0.1],"up":[0,0,1],"vertical_fov_degrees":50})";
  text.stand = "[0,0,-2]";
  text.lights =
      R"([{"spot":{"position":[0,0,0],"target":[0,0,1],"inner_degrees":179,"outer_degrees":180,"intensity":[1,1,1]}}])";
  for (double rho : {.5, .8}) {
    text.materials = R"([{"name":"grey","model":"lambertian","rho_d":[)" + std::to_string(rho) + "," +
                     std::to_string(rho) + "," + std::to_string(rho) + "]}]";
    const Traced traced = trace(test::make_scene(text), "grey", {512, 16, 16}, 24);
    const auto mean = object_mean(traced, traced.layers.indirect);
    const double expected = rho / std::numbers::pi * .25 * rho / (1 - rho);
    EXPECT_NEAR(mean.mean, expected, 4 * mean.standard_error + .003 * expected)
        << rho;  // .3 %: facets of the sphere
  }
}

// Between white walls no light is lost and the series has no limit: what matters is that every path ends.
TEST(PathTracer, PathsEndBetweenWhiteWalls) {
  SceneText text;
  text.materials = R"([{"name":"white","model":"lambertian","rho_d":[1,1,1]}])";
  text.meshes = R"([{"name":"ball","sphere":{"radius":2,"subdivisions":3}}])";
  text.camera = R"({"position":[0.5,0.3,0],"target":[2,0.3,0.1],"up":[0,0,1],"vertical_fov_degrees":50})";
  text.stand = "[0,0,-2]";
  text.lights =
      R"([{"spot":{"position":[0,0,0],"target":[0,0,1],"inner_degrees":20,"outer_degrees":40,"intensity":[1,1,1]}}])";
  const Traced traced = trace(test::make_scene(text), "white", {16, 16, 16}, 8);
  EXPECT_GT(object_mean(traced, traced.layers.indirect).mean, 0);
}

TEST(PathTracer, TheStandardErrorIsThatOfRepeatedRuns) {
  SceneText text;
  text.lights = test::furnace_lights(6);
  const Scene scene = test::make_scene(text);
  std::vector<double> values;
  double predicted = 0;
  const std::size_t middle = 8 * 16 + 8;
  for (std::uint64_t seed = 1; seed <= 64; ++seed) {
    const Traced traced = trace(scene, "grey", {16, 64, 16}, 16, seed);
    values.push_back(traced.layers.direct.pixel(middle)[0]);
    predicted += std::pow(traced.layers.standard_error.pixel(middle)[0], 2) / 64;
  }
  const double spread = test::mean_of(values).standard_error * std::sqrt(64.0);
  // 64 seeds: the ratio of the two lies within a quarter of one in all but 1 of 200 cases.
  EXPECT_NEAR(spread / std::sqrt(predicted), 1, .27);
}

TEST(PathTracer, PathCountsRoundUpToWholeBatches) {
  EXPECT_EQ(round_paths(1, 1), 16);
  EXPECT_EQ(round_paths(16, 1), 16);
  EXPECT_EQ(round_paths(17, 2), 32);
  EXPECT_EQ(round_paths(384, 2), 384);
}

TEST(PathTracer, SubpixelPositionsLieInsideThePixelAndTheCentreIsOne) {
  EXPECT_EQ(make_subpixel_positions(1)[0], (std::array<float, 2>{.5f, .5f}));
  for (int count : {2, 3, 4, 16, 64}) {
    double x = 0, y = 0;
    for (const auto& [px, py] : make_subpixel_positions(count)) {
      EXPECT_TRUE(px > 0 && px < 1 && py > 0 && py < 1) << count;
      x += px;
      y += py;
    }
    EXPECT_NEAR(x / count, .5, 1e-6);
    if ((count & (count - 1)) == 0) {
      EXPECT_NEAR(y / count, .5, 1e-6) << count;
    }
  }
}

TEST(Lights, ASpotFallsSmoothlyFromItsInnerToItsOuterCone) {
  const SpotLight spot{{0, 0, 0}, {0, 0, 1}, std::cos(.2f), std::cos(.6f), {2, 2, 2}};
  const auto at = [&](float angle) { return eval_spot(spot, {std::sin(angle), 0, std::cos(angle)}).x; };
  EXPECT_EQ(at(.1f), 2);
  EXPECT_EQ(at(.61f), 0);
  float before = 2;
  for (float angle = .2f; angle < .6f; angle += .01f) {
    EXPECT_LE(at(angle), before + 1e-6f);
    EXPECT_LT(before - at(angle), .2f);
    before = at(angle);
  }
}

}  // namespace
}  // namespace equilux
