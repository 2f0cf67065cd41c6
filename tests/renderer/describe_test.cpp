// What describe says, against closed forms; and the café, in which no light that is on in indirect-only may
// reach the object.
#include "renderer/describe.h"

#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>

#include "base/error.h"
#include "renderer/parallel.h"
#include "tests/renderer/test_scene.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kPi2 = 2 * std::numbers::pi;

Scene load_cafe() {
  return load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/cafe.json");
}

DirectLight find_light(const Scene& scene, const std::string& geometry, Illumination illumination,
                       int points = 20000) {
  return find_direct_light(make_world(scene, geometry, illumination),
                           sample_area(make_object(scene, geometry), points, 1), 1);
}

// In both scenes the fixture is the last light and the one that is off in indirect-only.
TEST(DirectLight, InTheCafeReachesNoObjectInIndirectOnlyAndEachWithTheFixture) {
  const Scene scene = load_cafe();
  const std::size_t fixture = scene.lights.size() - 1;
  for (const char* geometry : {"G0", "G1", "G2", "G3"}) {
    const DirectLight without = find_light(scene, geometry, Illumination::kIndirect),
                      with = find_light(scene, geometry, Illumination::kDirectAndIndirect);
    EXPECT_EQ(without.pair_count(), 20000 * fixture) << geometry;
    EXPECT_EQ(without.lit_count(), 0) << geometry;
    EXPECT_EQ(with.brightest(), fixture) << geometry;
    EXPECT_GT(with.lit[fixture], 6000) << geometry;
    EXPECT_EQ(with.lit_count(), with.lit[fixture]) << geometry;
  }
}

TEST(DirectLight, InTheGalleryReachesNoSculptureInIndirectOnlyAndEachWithTheFixture) {
  const Scene scene = load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/gallery.json");
  for (const Sculpture& sculpture : scene.sculptures) {
    EXPECT_EQ(find_light(scene, sculpture.name, Illumination::kIndirect).lit_count(), 0) << sculpture.name;
    EXPECT_GT(find_light(scene, sculpture.name, Illumination::kDirectAndIndirect).lit_count(), 4000)
        << sculpture.name;
  }
}

// Mutants of the café: one spot that points at the object; one whose cone is so wide that its rim meets it.
TEST(DirectLight, OfAMutantCafeWithOneSpotTurnedOrWideIsFound) {
  for (std::size_t spot : {0u, 7u, 20u}) {
    Scene turned = load_cafe(), wide = turned;
    auto& light = std::get<SpotLight>(turned.lights[spot].shape);
    light.direction = normalize(turned.stand + Vec3{0, 0, .45f} - light.position);
    std::get<SpotLight>(wide.lights[spot].shape).cos_outer = 0.05f;
    for (const Scene& scene : {turned, wide}) {
      const DirectLight found = find_light(scene, "G0", Illumination::kIndirect, 4096);
      EXPECT_GT(found.lit_count(), 0) << spot;
      EXPECT_EQ(found.brightest(), spot);
    }
  }
}

// From a point at distance d a sphere of radius 1 shows (1 - 1/d) / 2 of its area.
TEST(DirectLight, OfASpotLightsTheCapOfASphereThatItSees) {
  const DirectLight found = find_light(test::make_scene({}), "G0", Illumination::kIndirect);
  ASSERT_EQ(found.lit.size(), 1u);
  EXPECT_NEAR(double(found.lit[0]) / double(found.points), .375, .002);
}

TEST(DirectLight, BehindAScreenIsNone) {
  test::SceneText text;
  text.meshes = R"([{"name":"ball","sphere":{"radius":1,"subdivisions":5}},
                    {"name":"screen","quad":{"u":[9,0,0],"v":[0,0,9]}}])";
  text.instances = R"([{"mesh":"screen","material":"grey","at":[-4.5,-2,-4.5]}])";
  EXPECT_EQ(find_light(test::make_scene(text), "G0", Illumination::kIndirect).lit_count(), 0);
}

TEST(DirectLight, OfRectanglesAroundAndOfTheEnvironmentReachesAllPoints) {
  test::SceneText text;
  text.lights = R"([{"environment":{"radiance":[1,1,1]}}])";
  const DirectLight open = find_light(test::make_scene(text), "G0", Illumination::kIndirect, 2000);
  // Each of sixteen directions is below the horizon for half of the chance: 2000 / 65536 points expected
  // unlit.
  EXPECT_GE(open.lit.at(0), 1998);
  text.lights = test::furnace_lights(4);
  const DirectLight furnace = find_light(test::make_scene(text), "G0", Illumination::kIndirect, 2000);
  EXPECT_EQ(furnace.lit.size(), 6u);
  EXPECT_GT(furnace.lit_count(), 3 * 2000) << "from most places a sphere sees more than half of a cube";
}

TEST(SampleArea, IsEvenByArea) {
  test::SceneText text;
  text.meshes = R"([{"name":"ball","box":{"size":[1,1,4]}}])";
  const auto points = sample_area(make_object(test::make_scene(text), "G0"), 9000, 1);
  const auto ends = std::count_if(points.begin(), points.end(),
                                  [](const AreaPoint& point) { return std::abs(point.ng.z) > .5f; });
  EXPECT_NEAR(double(ends), 1000, 6) << "one in nine, to within the shares that straddle an edge";
}

// A cone of half angle t whose axis is b off the picture's: an ellipse of area pi cos t sin^2 t / K^(3/2) at
// distance 1, K = cos^2 t - sin^2 b.
double find_sphere_share(double t, double b, double vertical_fov) {
  const double k = std::pow(std::cos(t), 2) - std::pow(std::sin(b), 2);
  const double height = 2 * std::tan(vertical_fov / 2);
  return kPi2 / 2 * std::cos(t) * std::pow(std::sin(t), 2) / std::pow(k, 1.5) /
         (height * height * kDescribeWidth / kDescribeHeight);
}

DescribeParams few_points() {
  DescribeParams params;
  params.points = 64;
  return params;
}

double value_of(const Share& share) { return double(share.count) / double(share.total); }

TEST(Describe, CoverageOfASphereIsItsConesProjection) {
  const double degree = kPi2 / 360;
  for (const auto& [target, off] : {std::pair{"[0,0,0]", 0.0}, {"[0.3,0,0.4]", std::atan(.5 / 4)}}) {
    test::SceneText text;
    text.camera =
        fmt::format(R"({{"position":[0,-4,0],"target":{},"up":[0,0,1],"vertical_fov_degrees":40}})", target);
    const Description found = describe_scene(test::make_scene(text), few_points());
    for (const Share& share : found.geometries.at(0).coverage)
      EXPECT_NEAR(value_of(share) / find_sphere_share(std::asin(.25), off, 40 * degree), 1, .005);
  }
}

TEST(Describe, OfASphereMeetsNothingOfItself) {
  const GeometryDescription sphere = describe_scene(test::make_scene({}), few_points()).geometries.at(0);
  EXPECT_EQ(sphere.self_occlusion.count, 0);
  EXPECT_EQ(sphere.self_mirroring.count, 0);
  EXPECT_GT(sphere.self_mirroring.total, 10000);
}

// Half a sphere, hollow: half of what leaves its inner side by cosine meets it; its rim and outer side see
// nothing of it.
TEST(Describe, OfABowlMeetsItselfByHalfOfItsInside) {
  constexpr double kInner = .9;
  std::vector<std::string> profile;
  for (int i = 0; i <= 64; ++i)
    profile.push_back(fmt::format("[{},{}]", std::sin(kPi2 / 4 * i / 64), -std::cos(kPi2 / 4 * i / 64)));
  for (int i = 64; i >= 0; --i)
    profile.push_back(fmt::format("[{},{}]", kInner * std::sin(kPi2 / 4 * i / 64),
                                  i == 64 ? 0 : -kInner * std::cos(kPi2 / 4 * i / 64)));
  profile[64] = "[1,0]";
  test::SceneText text;
  text.camera = R"({"position":[0,-0.5,4],"target":[0,0,0],"up":[0,1,0],"vertical_fov_degrees":40})";
  text.meshes = fmt::format(R"([{{"name":"ball","lathe":{{"profile":[{}],"segments":128}}}}])",
                            fmt::join(profile, ","));
  DescribeParams params;
  params.points = 20000;
  const GeometryDescription bowl = describe_scene(test::make_scene(text), params).geometries.at(0);
  const double inner = 2 * kInner * kInner, all = inner + 2 + (1 - kInner * kInner);
  EXPECT_NEAR(value_of(bowl.self_occlusion), .5 * inner / all, .003);
  EXPECT_GT(value_of(bowl.self_mirroring), .2);
  EXPECT_LT(value_of(bowl.self_mirroring), .9);
}

test::SceneText make_box_room() {
  test::SceneText text;
  text.materials = R"([{"name":"grey","model":"lambertian","rho_d":[0.5,0.5,0.5]},
    {"name":"MS","model":"ward-duer","rho_d":[0.03,0.03,0.03],"rho_s":[0.22,0.22,0.22],"alpha":0.05},
    {"name":"GS","model":"ward-duer","rho_d":[0.19,0.19,0.19],"rho_s":[0.033,0.033,0.033],"alpha":0.05}])";
  text.meshes = R"([{"name":"ball","sphere":{"radius":1,"subdivisions":5}},
                    {"name":"room","box":{"size":[12,10,8]}}])";
  text.instances = R"([{"mesh":"room","material":"grey","at":[0,0,-4]}])";
  return text;
}

// At a silhouette a facet turns its back on some mirror directions of its smooth normals.
TEST(Describe, OfAClosedRoomHasMirrorRaysWithinItsDiagonal) {
  const Description found = describe_scene(test::make_scene(make_box_room()), few_points());
  EXPECT_EQ(found.counts.instances, 1u);
  EXPECT_EQ(found.counts.room_triangles, 12u);
  const auto& rays = found.geometries.at(0).mirror_rays;
  EXPECT_LE(found.bite.rays, rays.size());
  EXPECT_GT(double(found.bite.rays), .999 * double(rays.size()));
  for (const MirrorRay& ray : rays) {
    if (ray.length_m < 0) continue;
    ASSERT_GT(ray.length_m, 2.9) << "the nearest wall is three from the sphere";
    ASSERT_LT(ray.length_m, std::sqrt(12 * 12 + 10 * 10 + 8 * 8));
  }
  EXPECT_TRUE(std::is_sorted(found.bite.length_quantiles_m.begin(), found.bite.length_quantiles_m.end()));
}

TEST(Describe, ClampLevelsBiteMoreAndMoreAndC0Never) {
  const ClampBite bite = describe_scene(test::make_scene(make_box_room()), few_points()).bite;
  EXPECT_EQ(bite.material, "MS");
  EXPECT_EQ(bite.bitten[0].count, 0);
  for (std::size_t i = 1; i < bite.bitten.size(); ++i)
    EXPECT_GE(bite.bitten[i].count, bite.bitten[i - 1].count) << i;
  EXPECT_EQ(bite.bitten[10].count, std::int64_t(bite.rays)) << "26 m and more, in a room of 18";
}

TEST(Describe, ClampDistancesAreThoseOfTheirMaterials) {
  const Description found = describe_scene(test::make_scene(make_box_room()), few_points());
  ASSERT_EQ(found.reaches.size(), 2u);
  const auto& metal = found.reaches[0].distance_m;
  EXPECT_EQ(metal[0], 0);
  EXPECT_NEAR(metal[1], .149, .001);
  EXPECT_NEAR(metal[4], .837, .001);
  EXPECT_NEAR(metal[8], 8.37, .01);
  const auto& grey = found.reaches[1].distance_m;
  EXPECT_NEAR(grey[1], .0593, .0001);
  EXPECT_NEAR(grey[4], .333, .001);
  EXPECT_NEAR(grey[8], 3.33, .01);
  // Towards silhouettes the lobe grows as one over the cosine.
  const Material material = make_material({"MS", {.03f, .03f, .03f}, {.22f, .22f, .22f}, .05f});
  EXPECT_NEAR(find_mirror_peak(material, .1) / find_mirror_peak(material, 1), 10, .05);
}

double share_of(const Share& share) {
  return static_cast<double>(share.count) / static_cast<double>(share.total);
}

// Of 560 x 420 pixels, and about evenly apart: neighbours by 13 to 15 degrees.
TEST(Describe, TheCafesObjectsFillAQuarterToThreeTenthsOfBothViewsAndGrowEvenlyBumpier) {
  DescribeParams params = few_points();
  params.geometries = {"G0", "G1", "G2", "G3"};
  params.points = 4096;
  const Description found = describe_scene(load_cafe(), params);
  ASSERT_EQ(found.geometries.size(), 4u);
  double before = -14;
  for (const GeometryDescription& geometry : found.geometries) {
    for (const Share& seen : geometry.coverage) {
      EXPECT_GT(share_of(seen), 0.25) << geometry.name;
      EXPECT_LT(share_of(seen), 0.30) << geometry.name;
    }
    EXPECT_NEAR(geometry.bumpiness.rms_angle_degrees - before, 14, 1) << geometry.name;
    before = geometry.bumpiness.rms_angle_degrees;
  }
  EXPECT_EQ(share_of(found.geometries[0].self_occlusion), 0);
  EXPECT_GT(share_of(found.geometries[3].self_occlusion), 0.05) << "G3 occludes itself";
  EXPECT_GT(share_of(found.geometries[3].self_mirroring), 0.05) << "and mirrors itself";
}

TEST(Describe, AMissingMeshIsALineWithTheCommandThatBringsIt) {
  const test::Folder folder;
  save_text(folder / "cafe.json", load_text(load_cafe().path));
  DescribeParams params = few_points();
  params.geometries = {"Bunny", "G0"};
  const Description found = describe_scene(load_scene(folder / "cafe.json"), params);
  EXPECT_EQ(found.bite.geometry, "G0") << "the first that is there";
  const std::string text = format_description(found);
  EXPECT_THAT(text, HasSubstr("bunny.ply; stimuli/meshes/fetch.sh brings the Stanford Bunny\n"));
  EXPECT_THAT(text, HasSubstr("no light reaches the object (64 points x 31 lights)"));
}

TEST(Describe, SaysWhatWasMendedInAFile) {
  const test::Folder folder;
  save_text(folder / "scan.obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 5 3\nf 2 3 5\nf 1 2 2\n");
  test::SceneText text;
  text.meshes = fmt::format(R"([{{"name":"ball","file":{{"path":"{}"}}}}])", (folder / "scan.obj").string());
  EXPECT_THAT(format_description(describe_scene(test::make_scene(text), few_points())),
              HasSubstr("G0 has 1 duplicate vertex joined, 1 degenerate triangle left out\n"));
}

// Lambertian alone, nothing in the picture, no light in indirect-only, and a length of tenths of millimetres.
TEST(Describe, OfASceneWithNothingToSayIsWithoutNumbersThatAreNone) {
  test::SceneText text;
  text.camera = R"({"position":[0,-4e-4,0],"target":[0,-8e-4,0],"up":[0,0,1],"vertical_fov_degrees":40})";
  text.meshes = R"([{"name":"ball","sphere":{"radius":1e-4,"subdivisions":3}}])";
  text.stand = "[0,0,-1e-4]";
  text.lights = R"([{"rectangle":{"corner":[-1e-4,-1e-4,9e-4],"u":[0,1e-4,0],"v":[1e-4,0,0],
                     "radiance":[1,1,1]},"illuminations":["dir"]}])";
  const std::string found = format_description(describe_scene(test::make_scene(text), few_points()));
  EXPECT_THAT(found, HasSubstr("ind: no light is on"));
  EXPECT_THAT(found, HasSubstr("points by /lights/0"));
  EXPECT_THAT(found, HasSubstr("No glossy material"));
  EXPECT_THAT(found, Not(HasSubstr("nan")));
}

TEST(Describe, OfAGlossyObjectThatIsNotInThePictureSaysSo) {
  test::SceneText text = make_box_room();
  text.camera = R"({"position":[0,-4,0],"target":[0,-8,0],"up":[0,0,1],"vertical_fov_degrees":40})";
  const std::string found = format_description(describe_scene(test::make_scene(text), few_points()));
  EXPECT_THAT(found, HasSubstr("None leaves the object"));
  EXPECT_THAT(found, Not(HasSubstr("nan")));
}

TEST(Describe, OfWhatTheSceneLacksIsRefused) {
  const Scene scene = test::make_scene({});
  DescribeParams params = few_points();
  params.geometries = {"G7"};
  EXPECT_THAT(message_of<InputError>([&] { describe_scene(scene, params); }), HasSubstr("G7"));
  params = few_points();
  params.materials = {"MS"};
  EXPECT_THAT(message_of<InputError>([&] { describe_scene(scene, params); }), HasSubstr("MS"));
}

TEST(Describe, IsTheSameOnAnyNumberOfThreads) {
  const Scene scene = test::make_scene(make_box_room());
  const std::string all = format_description(describe_scene(scene, {}));
  const ThreadLimit limit(1);
  EXPECT_EQ(format_description(describe_scene(scene, {})), all);
}

}  // namespace
}  // namespace equilux
