// What is left out changes no picture: with and without it the bits are the same.
#include "renderer/plan.h"

#include <gtest/gtest.h>

#include "renderer/compensation.h"
#include "renderer/lightcut.h"
#include "renderer/lights.h"
#include "renderer/reference.h"
#include "renderer/wanted.h"
#include "tests/renderer/test_scene.h"

namespace equilux {
namespace {

Scene load_cafe() {
  return load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/cafe.json");
}

struct Stage {
  World world;
  Materials materials;
  Primary primary;

  Stage(const Scene& scene, const std::string& geometry, const std::string& material,
        Illumination illumination, const WorldParams& params = {})
      : world(make_world(scene, geometry, illumination, params)),
        materials(make_materials(world, find_material(scene, material))),
        primary(trace_primary(world, make_view_camera(scene, 0), 32, 24, 2)) {}

  FamilyScene family() const { return {world, materials, primary}; }
};

TracedLayers trace_stage(const Stage& stage) {
  return trace_layers(stage.family(), make_fixed_maps(stage.primary, {64, 64, 64}), 1, "plan-test", {},
                      [](double) {});
}

void expect_equal(const TracedLayer& a, const TracedLayer& b) {
  EXPECT_EQ(a.mean.values, b.mean.values);
  EXPECT_EQ(a.standard_error.values, b.standard_error.values);
}

bool is_black(const HdrImage& image) {
  return std::all_of(image.values.begin(), image.values.end(), [](float value) { return value == 0; });
}

class Reach : public testing::TestWithParam<Illumination> {};

// Spots out of reach and the object's direct light are the two that a world leaves out.
TEST_P(Reach, LeavesOutNoLightThatCounts) {
  const Scene scene = load_cafe();
  const Stage with(scene, "G2", "MS", GetParam()), without(scene, "G2", "MS", GetParam(), {false});
  const bool indirect = GetParam() == Illumination::kIndirect;
  EXPECT_EQ(with.world.may_be_lit(0), !indirect);
  EXPECT_TRUE(without.world.may_be_lit(0));
  EXPECT_LT(with.world.spot_grid().mean_length(), 0.2 * static_cast<double>(with.world.spots().size()));
  EXPECT_EQ(without.world.spot_grid().mean_length(), with.world.spots().size());
  const TracedLayers a = trace_stage(with), b = trace_stage(without);
  expect_equal(a.background, b.background);
  expect_equal(a.direct, b.direct);
  expect_equal(a.indirect, b.indirect);
  EXPECT_EQ(is_black(b.direct.mean), indirect);
}
INSTANTIATE_TEST_SUITE_P(Illuminations, Reach,
                         testing::Values(Illumination::kIndirect, Illumination::kDirectAndIndirect),
                         [](const auto& row) { return format_illumination(row.param); });

Vec3 draw_in(const Box& box, RandomStream& random) {
  const float x = random.next_float(), y = random.next_float(), z = random.next_float();
  return box.low + (box.high - box.low) * Vec3{x, y, z};
}

Vec3 draw_direction(RandomStream& random) {
  const float z = 2 * random.next_float() - 1, phi = 2 * kPi * random.next_float();
  const float r = std::sqrt(std::max(0.0f, 1 - z * z));
  return {r * std::cos(phi), r * std::sin(phi), z};
}

// 20,000 spots and boxes of all sizes, a point of each: one that is lit is in reach. Every third room is so
// far away that coordinates are rounded to a hundredth.
TEST(LightReach, IsNeverDeniedToAPointInTheCone) {
  RandomStream random(1, "light-reach", 0);
  int lit = 0, denied = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 away = i % 3 == 0 ? Vec3{1e5f, -2e5f, 3e4f} : Vec3{};
    const Box room{away + Vec3{-4, -3, 0}, away + Vec3{4, 3, 3}};
    SpotLight spot;
    spot.position = draw_in(room, random);
    spot.direction = draw_direction(random);
    spot.cos_outer = std::cos(kPi * random.next_float() * (i % 2 ? 1.0f : 0.05f));
    spot.cos_inner = 1;
    spot.intensity_w_per_sr = {1, 1, 1};
    Box box;
    box.low = draw_in(room, random);
    box.high = box.low + Vec3{1, 1, 1} * std::pow(10.0f, -4 + 4 * random.next_float());
    const Vec3 p = draw_in(box, random);
    const bool reaches = may_reach(spot, box);
    if (eval_spot(spot, normalize(p - spot.position)) != Vec3{}) {
      ++lit;
      ASSERT_TRUE(reaches) << i;
      ASSERT_TRUE(may_reach(spot, Sphere{p, 0})) << i;
      const SpotGrid grid({spot}, room, 5);
      ASSERT_EQ(grid.at(p).size(), 1u) << i;
    }
    denied += !reaches;
  }
  EXPECT_GT(lit, 3000);
  EXPECT_GT(denied, 6000);
}

TEST(LightReach, OfARectangleEndsAtItsPlane) {
  const RectangleLight light{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1}};  // shines up
  EXPECT_FALSE(may_reach(light, Box{{-9, -9, -9}, {9, 9, 0.9f}}));
  EXPECT_TRUE(may_reach(light, Box{{-9, -9, -9}, {9, 9, 1}}));
  EXPECT_TRUE(may_reach(light, Box{{5, 5, 3}, {6, 6, 4}}));
}

TEST(LightReach, HoldsInGridsOfAllKinds) {
  SpotLight up;
  up.position = {0, 0, -2};
  up.direction = {0, 0, 1};
  up.cos_outer = std::cos(0.7f);
  EXPECT_TRUE(SpotGrid().at({1, 2, 3}).empty());
  EXPECT_TRUE(SpotGrid({}, {{0, 0, 0}, {1, 1, 1}}, 16).at({0.5f, 0.5f, 0.5f}).empty());
  // A floor has no height; its border and its corners are in it.
  const SpotGrid flat({up}, {{-1, -1, 0}, {1, 1, 0}}, 16);
  for (const Vec3 p : {Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0.9f, 0.9f, 0}})
    EXPECT_EQ(flat.at(p).size(), 1u) << p.x << " " << p.y;
  const SpotGrid many(std::vector<SpotLight>(300, up), {{-1, -1, 0}, {1, 1, 1}}, 8);
  EXPECT_EQ(many.at({0, 0, 0.5f}).size(), 300u);
}

// All lights and their cells are asked where a point lies: at 100,000 points of the café.
TEST(LightReach, OfTheCafeHoldsInEveryCell) {
  const World world = make_world(load_cafe(), "G0", Illumination::kDirectAndIndirect);
  RandomStream random(2, "light-reach", 0);
  const float radius = world.radius();
  const Box box{world.center() - Vec3{1, 1, 1} * radius, world.center() + Vec3{1, 1, 1} * radius};
  std::size_t lit = 0;
  for (int i = 0; i < 100000; ++i) {
    const Vec3 p = draw_in(box, random);
    const auto near = world.spots_at(p);
    for (std::uint32_t s = 0; s < world.spots().size(); ++s) {
      const SpotLight& spot = world.spots()[s];
      if (eval_spot(spot, normalize(p - spot.position)) == Vec3{}) continue;
      // Outside the world there is no surface.
      if (world.is_open(p, {0, 0, -1}) || world.is_open(p, {0, 0, 1})) continue;
      ++lit;
      ASSERT_NE(std::find(near.begin(), near.end(), s), near.end()) << i << " " << s;
    }
  }
  EXPECT_GT(lit, 1000u);
}

// A lobe that is there and 0 everywhere takes the glossy way through every kernel.
TEST(Omission, OfALambertianObjectsLobeKeepsEveryBit) {
  const Stage stage(load_cafe(), "G2", "LG", Illumination::kIndirect);
  const VplList list = join_vpls(trace_vpls(stage.world, stage.materials, 2000, 1, "plan-test"));
  Material forced = stage.materials[0];
  ASSERT_EQ(forced.glossy_share, 0);
  forced.glossy_share = 1e-30f;
  forced.alpha = 0.1f;
  const auto points = find_shading_points(stage.primary);
  const std::vector<double> clamps{clamp_per_m2(0), clamp_per_m2(4)};
  const auto sum = [&](const Material& material) {
    return shade_all_vpls(stage.world, points, list, {material}, clamps, [](double) {}).radiance;
  };
  EXPECT_EQ(sum(stage.materials[0]), sum(forced));
  const LightTree tree = make_light_tree(VplList(list), {1, 4});
  const auto cut = [&](const Material& material) {
    return shade_lightcut(stage.world, points, tree, {material}, clamps, {0.0075, 1e-5}).radiance;
  };
  EXPECT_EQ(cut(stage.materials[0]), cut(forced));
}

// Gloss that no VPL of the list has takes the way of full emission.
TEST(Omission, OfEmissionDirectionsKeepsEveryBit) {
  const Stage stage(load_cafe(), "G2", "MS", Illumination::kIndirect);
  const VplList list = join_vpls(trace_vpls(stage.world, stage.materials, 2000, 1, "plan-test"));
  ASSERT_TRUE(list.gloss.empty());
  VplList forced(list);
  forced.gloss.push_back({{0, 0, 1}, {0, 0, 1}, {}, 0.1f, GlossModel::kWardDuer});
  const auto points = find_shading_points(stage.primary);
  const std::vector<double> clamps{clamp_per_m2(0), clamp_per_m2(4)};
  const auto object = std::vector{stage.materials[0]};
  EXPECT_EQ(shade_all_vpls(stage.world, points, list, object, clamps, [](double) {}).radiance,
            shade_all_vpls(stage.world, points, forced, object, clamps, [](double) {}).radiance);
  const auto cut = [&](const VplList& vpls) {
    const LightTree tree = make_light_tree(VplList(vpls), {1, 4});
    return shade_lightcut(stage.world, points, tree, object, clamps, {0.0075, 1e-5}).radiance;
  };
  EXPECT_EQ(cut(list), cut(forced));
}

// The cuts of the tree err within their rule; the sum does not.
TEST(Omission, OfTheTreeIsTheSumThatCutsAreHeldTo) {
  const Stage stage(load_cafe(), "G2", "GS", Illumination::kIndirect);
  const VplList list = join_vpls(trace_vpls(stage.world, stage.materials, 300, 1, "plan-test"));
  ASSERT_TRUE(is_summed_plainly(static_cast<std::int64_t>(list.size())));
  const auto points = find_shading_points(stage.primary);
  const std::vector<double> clamps{clamp_per_m2(0)};
  const auto object = std::vector{stage.materials[0]};
  const auto sum = shade_all_vpls(stage.world, points, list, object, clamps, [](double) {}).radiance;
  const LightTree tree = make_light_tree(VplList(list), {1, 4});
  const auto cut = shade_lightcut(stage.world, points, tree, object, clamps, {1e-9, 1e-12}).radiance;
  for (std::size_t i = 0; i < sum.size(); ++i)
    ASSERT_NEAR(luminance(cut[i]), luminance(sum[i]), 2e-5 * luminance(sum[i])) << i;
}

// A cut for all levels is as fine as each level's own, so that each errs no more than alone; opened to the
// end, to a rounding.
TEST(Omission, OfATraversalForEachLevelKeepsEachWithinItsRule) {
  const Stage stage(load_cafe(), "G2", "MS", Illumination::kIndirect);
  const VplList list = join_vpls(trace_vpls(stage.world, stage.materials, 5000, 1, "plan-test"));
  ASSERT_FALSE(is_summed_plainly(static_cast<std::int64_t>(list.size())));
  const auto points = find_shading_points(stage.primary);
  const auto object = std::vector{stage.materials[0]};
  const std::vector<double> clamps{clamp_per_m2(0), clamp_per_m2(3), clamp_per_m2(6), clamp_per_m2(10)};
  const auto sum = shade_all_vpls(stage.world, points, list, object, clamps, [](double) {});
  const LightTree tree = make_light_tree(VplList(list), {1, 4});
  for (const double ratio : {1e-9, 0.0075, 0.05}) {
    const LightcutParams rule{ratio, 1e-5};
    CutRecord all_sizes;
    const auto all = shade_lightcut(stage.world, points, tree, object, clamps, rule, &all_sizes);
    for (std::size_t level = 0; level < clamps.size(); ++level) {
      CutRecord sizes;
      const auto alone = shade_lightcut(stage.world, points, tree, object, {clamps[level]}, rule, &sizes);
      double together = 0, apart = 0, light = 0, shorter = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double true_light = luminance(sum.radiance[sum.index(0, level, i)]),
                     of_all = luminance(all.radiance[all.index(0, level, i)]),
                     of_one = luminance(alone.radiance[alone.index(0, 0, i)]);
        if (ratio == 1e-9) {
          ASSERT_NEAR(of_all, of_one, 2e-5 * of_one) << i;
        }
        together += std::pow(of_all - true_light, 2);
        apart += std::pow(of_one - true_light, 2);
        light += true_light * true_light;
        shorter += all_sizes.sizes[i] < sizes.sizes[i] ? 1 : 0;
      }
      EXPECT_LE(std::sqrt(together), 1.1 * std::sqrt(apart) + 1e-5 * std::sqrt(light))
          << ratio << " " << level;
      // A total that comes out higher may leave out a node or two.
      EXPECT_LE(shorter, 0.05 * static_cast<double>(points.size())) << ratio << " " << level;
    }
  }
}

// Rays that end where the asked clamp takes nothing, and rays that go on for a level that nobody needs.
TEST(Omission, OfLongCompensationRaysKeepsEveryBit) {
  const Stage stage(load_cafe(), "G2", "LG", Illumination::kIndirect);
  const PathMap map(stage.primary.hits.size() / 2, 4);
  const auto trace = [&](std::vector<double> clamps) {
    return trace_compensation(stage.family(), map, {std::move(clamps), Emission::kFull, 1, "plan-test", {}},
                              [](double) {})[0];
  };
  const TracedLayer asked = trace({clamp_per_m2(8)});
  EXPECT_FALSE(is_black(asked.mean));
  expect_equal(asked, trace({clamp_per_m2(8), clamp_per_m2(10)}));
}

// A path of the room is walked once until it meets the object, then by each material: as if alone.
TEST(Omission, OfPathsThatNeverMetTheObjectKeepsEveryBit) {
  const Scene scene = load_cafe();
  const Stage stage(scene, "G2", "MS", Illumination::kDirectAndIndirect);
  std::vector<Materials> materials;
  for (const char* name : {"GS", "MS", "LG"})
    materials.push_back(make_materials(stage.world, find_material(scene, name)));
  const PathMap map(stage.primary.hits.size() / 2, 8);
  const PathMeasures measures;
  const BatchJob job{make_background_key(1, "plan-test"), map, measures};
  const auto trace = [&](std::span<const Materials> some) {
    return trace_backgrounds(stage.world, some, stage.primary, job, "plan-test", [](double) {});
  };
  const auto together = trace(materials);
  for (std::size_t i = 0; i < materials.size(); ++i) expect_equal(together[i], trace({&materials[i], 1})[0]);
  expect_equal(together[1],
               trace_layers(stage.family(), {map, map, map}, 1, "plan-test", {}, [](double) {}).background);
  std::size_t differing = 0;
  for (std::size_t i = 0; i < together[0].mean.values.size(); ++i)
    differing += together[0].mean.values[i] != together[2].mean.values[i];
  EXPECT_GT(differing, 100u);
}

// A rectangle that shines away from everything makes direct light a matter of samples.
TEST(Omission, OfSamplesOfDirectLightKeepsItToARounding) {
  test::SceneText text;
  const Stage without(test::make_scene(text), "G0", "grey", Illumination::kIndirect);
  text.lights.insert(text.lights.rfind(']'),
                     R"(,{"rectangle":{"corner":[0,9,0],"u":[0,0,1],"v":[1,0,0],"radiance":[1,1,1]}})");
  const Stage with(test::make_scene(text), "G0", "grey", Illumination::kIndirect);
  ASSERT_FALSE(has_extended_lights(without.world));
  ASSERT_TRUE(has_extended_lights(with.world));
  const HdrImage left_out = trace_stage(without).direct.mean, sampled = trace_stage(with).direct.mean;
  EXPECT_FALSE(is_black(left_out));
  for (std::size_t i = 0; i < left_out.values.size(); ++i)
    ASSERT_NEAR(sampled.values[i], left_out.values[i], 2e-6 * left_out.values[i]) << i;
}

// What no instance names and what is off under this illumination never reaches the world.
TEST(Omission, OfPartsOfOtherConditionsKeepsEveryBit) {
  test::SceneText text;
  const Stage least(test::make_scene(text), "G0", "grey", Illumination::kIndirect);
  text.meshes = R"([{"name":"unused","quad":{"u":[9,0,0],"v":[0,0,9]}},
    {"name":"ball","sphere":{"radius":1,"subdivisions":5}}])";
  text.materials = R"([{"name":"unused","model":"lambertian","rho_d":[0.9,0.1,0.1]},
    {"name":"grey","model":"lambertian","rho_d":[0.5,0.5,0.5]}])";
  text.lights.insert(
      text.lights.rfind(']'),
      R"(,{"illuminations":["dir"],"rectangle":{"corner":[0,-9,0],"u":[0,0,1],"v":[1,0,0],"radiance":[7,1,1]}})");
  const Scene scene = test::make_scene(text);
  ASSERT_EQ(scene.meshes.size(), 2u);
  ASSERT_EQ(scene.materials.size(), 2u);
  const Stage more(scene, "G0", "grey", Illumination::kIndirect),
      lit(scene, "G0", "grey", Illumination::kDirectAndIndirect);
  const TracedLayers a = trace_stage(least), b = trace_stage(more);
  expect_equal(a.background, b.background);
  expect_equal(a.direct, b.direct);
  expect_equal(a.indirect, b.indirect);
  EXPECT_NE(trace_stage(lit).direct.mean.values, a.direct.mean.values) << "where it is on it shows";
}

PlanRequest make_request(const std::string& key) {
  PlanRequest request;
  request.source = "cafe";
  request.condition = parse_condition(key, "test");
  request.width = 280;
  request.height = 210;
  request.positions = 2;
  request.clamp_levels = {request.condition.cell.clamp_level};
  return request;
}

std::vector<std::string> list_left_out(const Plan& plan) {
  std::vector<std::string> names;
  for (const Omission& omission : plan.omissions) {
    EXPECT_FALSE(omission.because.empty()) << omission.what;
    EXPECT_EQ(omission.saves.empty(), !omission.left_out) << omission.what;
    if (omission.left_out) names.push_back(omission.what);
  }
  return names;
}

TEST(Plan, FollowsTheCondition) {
  const Scene scene = load_cafe();
  EXPECT_EQ(
      list_left_out(make_plan(scene, make_request("G0-LG-ind-1k-C0-v0"))),
      (std::vector<std::string>{
          "the object's glossy lobe, its bounds and its sampling", "emission directions of VPLs",
          "direct light of the object", "sampling of direct light", "spots out of reach", "the light tree",
          "long rays of compensation", "meshes, materials and lights of other conditions"}));
  PlanRequest study = make_request("G2-MS-dir-5M-C4-v0");
  study.emission = Emission::kFull;
  study.clamp_levels = {0, 4};
  study.materials = {"MS", "GS"};
  study.layers_on_disk = {3, 6};
  study.reference = ReferenceMethod::kCompensated;
  EXPECT_EQ(list_left_out(make_plan(scene, study)),
            (std::vector<std::string>{
                "spots out of reach", "a traversal for each clamp level", "particles again for each material",
                "the background's paths again for each material", "VPLs and trees again for each view",
                "long rays of compensation", "path tracing of the reference's indirect light",
                "meshes, materials and lights of other conditions", "layers that are on disk"}));
  study.reference = ReferenceMethod::kPath;
  const auto by_paths = list_left_out(make_plan(scene, study));
  EXPECT_EQ(std::count(by_paths.begin(), by_paths.end(), "path tracing of the reference's indirect light"),
            0);
}

// What the plan says of a condition, against what its rendering came to.
void expect_rendered_by_plan(const Scene& scene, const std::string& key, Emission emission) {
  PlanRequest request = make_request(key);
  request.emission = emission;
  const auto left_out = list_left_out(make_plan(scene, request));
  const auto leaves_out = [&](const char* what) {
    return std::count(left_out.begin(), left_out.end(), what) > 0;
  };
  const Object& object = request.condition.cell.column.object;
  const Stage stage(scene, object.geometry, object.material, object.illumination);
  const TracedLayers layers = trace_stage(stage);
  if (leaves_out("direct light of the object")) {
    EXPECT_TRUE(is_black(layers.direct.mean)) << key;
  }
  if (!is_black(layers.direct.mean)) {
    EXPECT_EQ(is_black(layers.direct.standard_error), leaves_out("sampling of direct light")) << key;
  }
  const VplList vpls = join_vpls(trace_vpls(stage.world, stage.materials, 5000, 1, "plan-test", emission));
  ASSERT_GT(vpls.size(), 0u) << key;
  EXPECT_EQ(vpls.gloss.empty(), leaves_out("emission directions of VPLs")) << key;
  // Without a clamp nothing comes back but what goes missing at any distance.
  const PathMap map(stage.primary.hits.size() / 2, 64);
  const double none = std::numeric_limits<double>::infinity();
  const TracedLayer missing =
      trace_compensation(stage.family(), map, {{none}, emission, 1, "plan-test", {}}, [](double) {})[0];
  EXPECT_EQ(is_black(missing.mean), leaves_out("long rays of compensation")) << key;
}

Scene load_scene_of(const char* name) {
  return load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes" /
                    (std::string(name) + ".json"));
}

// The renderer decides where it works; the plan must never tell another story.
TEST(Plan, IsWhatTheRendererDoes) {
  for (const Emission emission : {Emission::kLambertian, Emission::kFull}) {
    for (const char* key : {"G0-LG-ind-1k-C0-v0", "G2-MS-dir-1k-C0-v0"}) {
      for (const char* scene : {"cafe", "proof-room"})
        expect_rendered_by_plan(load_scene_of(scene), key, emission);
    }
    expect_rendered_by_plan(load_scene_of("gallery"), "Ball-MS-ind-1k-C0-v0", emission);
    test::SceneText text;
    text.instances = R"([{"mesh":"ball","material":"grey","at":[2.2,0,0]}])";
    expect_rendered_by_plan(test::make_scene(text), "G0-grey-ind-1k-C0-v0", emission);
    text.lights = R"([{"environment":{"radiance":[1,2,3]}}])";
    expect_rendered_by_plan(test::make_scene(text), "G0-grey-ind-1k-C0-v0", emission);
  }
}

TEST(Plan, IsToldInWords) {
  const std::string text = format_plan(make_plan(load_cafe(), make_request("G0-MS-ind-5M-C4-v0")));
  EXPECT_EQ(text.find("cafe, G0-MS-ind-5M-C4-v0: "), 0u) << text;
  EXPECT_NE(text.find("left out  direct light of the object\n          because no cone of 31 spots"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("kept      the light tree\n          because cuts of 5M VPLs"), std::string::npos)
      << text;
}

}  // namespace
}  // namespace equilux
