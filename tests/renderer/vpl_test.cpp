// Particle tracing: counts, sharing between materials, and agreement with the path tracer.
#include "renderer/vpl.h"

#include <cmath>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/random.h"
#include "renderer/family.h"
#include "renderer/parallel.h"
#include "renderer/shade.h"
#include "tests/renderer/test_scene.h"
#include "tests/support/statistics.h"

namespace equilux {
namespace {

using test::SceneText;

// A Lambertian ball that floats over a lit floor beside a wall: nothing touches, so the unclamped sum has a
// finite variance.
Scene floating_ball() {
  SceneText text;
  text.materials = R"([
    {"name":"grey","model":"lambertian","rho_d":[0.4,0.3,0.5]},
    {"name":"metal","model":"ward-duer","rho_d":[0.03,0.03,0.03],"rho_s":[0.22,0.22,0.22],"alpha":0.15},
    {"name":"room","model":"lambertian","rho_d":[0.7,0.6,0.5]}])";
  text.meshes =
      R"([{"name":"ball","sphere":{"radius":0.5,"subdivisions":5}},{"name":"side","quad":{"u":[4,0,0],"v":[0,4,0]}},
    {"name":"wall","quad":{"u":[4,0,0],"v":[0,0,4]}}])";
  text.instances =
      R"([{"mesh":"side","material":"room","at":[-2,-2,0]},{"mesh":"wall","material":"room","at":[-2,2,0]}])";
  text.stand = "[0,0,0.8]";
  text.camera = R"({"position":[0,-3,1.3],"target":[0,0,1.3],"up":[0,0,1],"vertical_fov_degrees":24})";
  text.lights =
      R"([{"spot":{"position":[1.8,-1.8,3],"target":[1.0,-0.8,0],"inner_degrees":10,"outer_degrees":25,
      "intensity":[5,5,5]}},
    {"rectangle":{"corner":[-1.8,1.2,2.8],"u":[0,0.5,0],"v":[0.5,0,0],"radiance":[6,5,4]}}])";
  return test::make_scene(text);
}

TEST(Vpl, KeepsItsNormalAndItsEpsilonWithinABoundAndItsGlossExactly) {
  RandomStream random(3, "vpl", 0);
  for (int i = 0; i < 10000; ++i) {
    const Vec3 ng = sample_cosine(random.next_float(), random.next_float()) * (i % 2 == 0 ? 1.0f : -1.0f);
    const float epsilon = std::pow(10.0f, -25 + 30 * random.next_float());
    Vpl vpl({1, 2, 3}, epsilon, ng, {4, 5, 6});
    EXPECT_EQ(vpl.gloss(), -1);
    const auto gloss = static_cast<std::int32_t>(random.next_below(Vpl::kMostGloss));
    vpl.set_gloss(gloss);
    ASSERT_EQ(vpl.gloss(), gloss);
    ASSERT_LT(std::atan2(length(cross(vpl.ng(), ng)), dot(vpl.ng(), ng)), kOctahedralError);
    ASSERT_GE(vpl.epsilon(), epsilon);
    ASSERT_LT(vpl.epsilon(), 2 * epsilon);
    vpl.set_gloss(-1);
    ASSERT_EQ(vpl.gloss(), -1);
  }
  EXPECT_EQ(Vpl({}, 0.25f, {0, 0, 1}, {}).epsilon(), 0.25f);
}

TEST(Vpls, PathsThatNeverMetTheObjectAreTheSameForEveryMaterial) {
  const Scene scene = floating_ball();
  const World world = make_world(scene, "G0", Illumination::kIndirect);
  const VplSet grey = trace_vpls(world, make_materials(world, find_material(scene, "grey")), 5000, 3, "vpls");
  const VplSet metal =
      trace_vpls(world, make_materials(world, find_material(scene, "metal")), 5000, 3, "vpls");
  EXPECT_EQ(grey.shared, metal.shared);
  EXPECT_NE(grey.own, metal.own);
  EXPECT_GT(grey.own.size(), 10u);
}

TEST(Vpls, OfTheObjectComeFromThePathsThatMetItAsIfAllWereTraced) {
  const Scene scene = load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/cafe.json");
  const World world = make_world(scene, "G2", Illumination::kDirectAndIndirect);
  const auto trace = [&](const char* material, Emission emission) {
    return trace_vpls(world, make_materials(world, find_material(scene, material)), 20000, 3, "vpls",
                      emission);
  };
  for (const Emission emission : {Emission::kLambertian, Emission::kFull}) {
    const VplSet first = trace("GS", emission), whole = trace("MS", emission);
    EXPECT_EQ(first.met, whole.met);
    EXPECT_LT(first.met.size(), 20000u / 2);
    EXPECT_GT(first.met.size(), 100u);
    const VplList own =
        trace_own_vpls(world, make_materials(world, find_material(scene, "MS")), first, 3, "vpls", emission);
    EXPECT_EQ(own, whole.own);
    EXPECT_NE(own, first.own);
  }
}

TEST(Vpls, OfAnObjectThatNoPathMeetsAreNone) {
  const Scene scene = floating_ball();
  const World world = make_world(scene, "G0", Illumination::kIndirect);
  VplSet set;
  set.paths = 1000;
  EXPECT_EQ(trace_own_vpls(world, make_materials(world, find_material(scene, "grey")), set, 3, "vpls").size(),
            0u);
}

TEST(Vpls, TheSameSeedGivesTheSameVplsOnAnyNumberOfThreads) {
  const Scene scene = floating_ball();
  const World world = make_world(scene, "G0", Illumination::kIndirect);
  const Materials materials = make_materials(world, find_material(scene, "grey"));
  std::vector<VplSet> sets;
  for (int threads : {1, 2, 3}) {
    const ThreadLimit limit(threads);
    sets.push_back(trace_vpls(world, materials, 20000, 3, "vpls"));
  }
  EXPECT_EQ(sets[0].shared, sets[1].shared);
  EXPECT_EQ(sets[0].own, sets[1].own);
  EXPECT_EQ(sets[0].shared, sets[2].shared);
  const VplSet other = trace_vpls(world, materials, 20000, 4, "vpls");
  EXPECT_NE(sets[0].shared, other.shared);
}

TEST(Vpls, ThePilotsPathCountGivesAboutTheNumberAskedFor) {
  const Scene scene = floating_ball();
  const World world = make_world(scene, "G0", Illumination::kIndirect);
  const Materials materials = make_materials(world, find_material(scene, "grey"));
  for (std::int64_t target : {1000, 10000, 100000}) {
    const std::int64_t paths = find_path_count(world, target, 1);
    const auto count = static_cast<double>(trace_vpls(world, materials, paths, 1, "vpls").count());
    // Another material than the pilot's: within 5 %, and four standard deviations of the counts.
    EXPECT_NEAR(count, static_cast<double>(target),
                .05 * static_cast<double>(target) + 8 * std::sqrt(static_cast<double>(target)));
  }
}

// All the room's VPLs send gloss alone on: none is Lambertian.
TEST(Vpls, OfARoomOfMetalAreCountedByTheEmissionThatTheyHave) {
  SceneText text;
  text.materials =
      R"([{"name":"metal","model":"ward-duer","rho_d":[0,0,0],"rho_s":[0.6,0.6,0.6],"alpha":0.2}])";
  text.meshes = R"([{"name":"ball","sphere":{"radius":0.5,"subdivisions":3}},
    {"name":"wall","quad":{"u":[4,0,0],"v":[0,0,4]}}])";
  text.instances = R"([{"mesh":"wall","material":"metal","at":[-2,2,-2]}])";
  text.lights = R"([{"spot":{"position":[1.5,0,0],"target":[0.5,2,0],"inner_degrees":20,"outer_degrees":35,
      "intensity":[5,5,5]}}])";
  text.stand = "[0,0,-0.5]";
  const Scene scene = test::make_scene(text);
  const World world = make_world(scene, "G0", Illumination::kIndirect);
  const Materials materials = make_materials(world, scene.materials[0]);
  const auto count = [&](Emission emission) {
    return trace_vpls(world, materials, find_path_count(world, 1000, 1, emission), 1, "vpls", emission)
        .count();
  };
  EXPECT_EQ(tell_odd_count(1000, count(Emission::kFull)), "");
  EXPECT_EQ(tell_odd_count(1000, count(Emission::kLambertian)),
            "no VPLs where 1000 are asked for: what light meets leaves none");
  EXPECT_EQ(tell_odd_count(1000, 2001), "2001 VPLs where 1000 are asked for");
  EXPECT_EQ(tell_odd_count(1000, 499), "499 VPLs where 1000 are asked for");
}

TEST(Vpls, FluxOfTheFirstHitsIsThatOfTheLight) {
  // A downward rectangle close to a large black-bodied floor: all its power, pi L A, arrives; a VPL's
  // intensity is W rho / pi.
  SceneText text;
  text.materials = R"([{"name":"grey","model":"lambertian","rho_d":[0.5,0.5,0.5]}])";
  text.meshes = R"([{"name":"ball","quad":{"u":[200,0,0],"v":[0,200,0]}}])";
  text.stand = "[-100,-100,0]";
  text.lights = R"([{"rectangle":{"corner":[-0.5,-0.5,0.5],"u":[0,1,0],"v":[1,0,0],"radiance":[3,2,1]}}])";
  const Scene scene = test::make_scene(text);
  const World world = make_world(scene, "G0", Illumination::kIndirect);
  const VplSet set = trace_vpls(world, make_materials(world, scene.materials[0]), 20000, 1, "vpls");
  double sum = 0;
  for (const Vpl& vpl : set.own.vpls) sum += vpl.intensity.x;
  EXPECT_NEAR(sum, std::numbers::pi * 3 * .5 / std::numbers::pi,
              .02);  // particles bounce at most into the black light
}

double mean_green(const std::vector<Vec3>& values) {
  double sum = 0;
  for (Vec3 v : values) sum += v.y;
  return sum / static_cast<double>(values.size());
}

// Where every surface is Lambertian, VPLs with Lambertian emission lose nothing: the unclamped sum's
// expectation is the path-traced indirect light. 320 VPL seeds against 320 path-tracer seeds, level 1 %; the
// standard errors are under .1 % (checked), so a bias of half a per cent is seen with a power over 90 %.
TEST(Vpls, UnclampedSumsOfALambertianSceneAgreeWithThePathTracer) {
  const Scene scene = floating_ball();
  const World world = make_world(scene, "G0", Illumination::kIndirect);
  const Materials materials = make_materials(world, find_material(scene, "grey"));
  const Primary primary = trace_primary(world, make_view_camera(scene, 0), 20, 20, 1);
  const auto points = find_shading_points(primary);
  const PathMap none(primary.hits.size(), 0), indirect = make_fixed_maps(primary, {64, 64, 64}).indirect;
  std::vector<double> by_vpls, by_paths;
  for (std::uint64_t seed = 1; seed <= 320; ++seed) {
    const VplSet set = trace_vpls(world, materials, 2000, seed, "vpls");
    double mean = 0;
    for (const auto* part : {&set.shared, &set.own}) {
      mean += mean_green(
          shade_all_vpls(world, points, *part, {materials[0]}, {clamp_per_m2(0)}, [](double) {}).radiance);
    }
    by_vpls.push_back(mean);
    const TracedLayers layers =
        trace_layers({world, materials, primary}, {none, none, indirect}, seed, "paths", {}, [](double) {});
    double sum = 0;
    for (std::size_t i = 0; i < none.size(); ++i) sum += layers.indirect.mean.pixel(i)[1];
    by_paths.push_back(sum / static_cast<double>(points.size()));
  }
  const auto vpls = test::mean_of(by_vpls), paths = test::mean_of(by_paths);
  EXPECT_GT(test::test_equal_means(vpls, paths, 320), .01)
      << vpls.mean << " +- " << vpls.standard_error << " by VPLs, " << paths.mean << " +- "
      << paths.standard_error;
  EXPECT_LT(vpls.standard_error, .001 * vpls.mean);
  EXPECT_LT(paths.standard_error, .001 * paths.mean);
}

TEST(Vpls, ALightThatReachesNothingIsAnInputError) {
  SceneText text;
  text.lights =
      R"([{"spot":{"position":[0,-4,0],"target":[0,-9,0],"inner_degrees":5,"outer_degrees":10,"intensity":[1,1,1]}}])";
  const World world = make_world(test::make_scene(text), "G0", Illumination::kIndirect);
  EXPECT_FALSE(find_vpls_per_path(world, 1));
  try {
    find_path_count(world, 1000, 1);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("scene.json: /lights (G0-ind): expected light that"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace equilux
