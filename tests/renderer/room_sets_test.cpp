// The room by VPL sets and compensation: unbiased beside every material, as sure as it says, checked.
#include "renderer/room_sets.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <limits>

#include "base/digest.h"
#include "base/files.h"
#include "renderer/compensation.h"
#include "renderer/parallel.h"
#include "renderer/reference.h"
#include "renderer/room_format.h"
#include "renderer/vpl_sets.h"
#include "tests/renderer/test_scene.h"
#include "tests/support/statistics.h"
#include "tests/support/temp_folder.h"

namespace equilux {
namespace {

struct Stage {
  Scene scene;
  World world;
  std::vector<Materials> materials;
  Primary primary;
  HdrImage coverage;

  Stage(Scene made, const std::string& geometry, const std::vector<std::string>& names, int width, int height)
      : scene(std::move(made)),
        world(make_world(scene, geometry, Illumination::kIndirect)),
        primary(trace_primary(world, make_view_camera(scene, 0), width, height, 2)),
        coverage(make_coverage(primary)) {
    for (const std::string& name : names)
      materials.push_back(make_materials(world, find_material(scene, name)));
  }

  RoomScene room() const { return {world, materials, primary}; }
  RoomScene room_beside(std::size_t material) const {
    return {world, std::span(materials).subspan(material, 1), primary};
  }
  PathMap map(std::uint32_t paths) const {
    PathMap map(coverage.pixel_count());
    for (std::size_t i = 0; i < map.size(); ++i) map[i] = coverage.values[i] > 0 ? 0 : paths;
    return map;
  }
};

Scene load_cafe() {
  return load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/cafe.json");
}

// A lamp that has an area and a spot light a floor, a wall of metal and a ball before them.
Scene make_lamp_room() {
  test::SceneText text;
  text.materials = R"([{"name":"grey","model":"lambertian","rho_d":[0.5,0.5,0.5]},
    {"name":"floor","model":"lambertian","rho_d":[0.7,0.5,0.3]},
    {"name":"shiny","model":"ward-duer","rho_d":[0.1,0.1,0.1],"rho_s":[0.3,0.3,0.3],"alpha":0.2},
    {"name":"metal","model":"ward-duer","rho_d":[0.1,0.1,0.1],"rho_s":[0.3,0.3,0.3],"alpha":0.3}])";
  text.meshes = R"([{"name":"ball","sphere":{"radius":0.5,"subdivisions":5}},
    {"name":"wall","quad":{"u":[4,0,0],"v":[0,0,4]}},{"name":"floor","quad":{"u":[4,0,0],"v":[0,4,0]}}])";
  text.instances = R"([{"mesh":"wall","material":"metal","at":[-2,2,-0.5]},
    {"mesh":"floor","material":"floor","at":[-2,-2,-0.5]}])";
  text.lights = R"([{"spot":{"position":[1.5,0,0.4],"target":[0.5,2,0],"inner_degrees":20,"outer_degrees":35,
      "intensity":[5,5,5]}},
    {"rectangle":{"corner":[-1.5,-0.5,2],"u":[0,1,0],"v":[1,0,0],"radiance":[3,3,3]}}])";
  text.stand = "[0,0,-0.5]";
  text.camera = R"({"position":[2,-3,1],"target":[0,0,0],"up":[0,0,1],"vertical_fov_degrees":45})";
  return test::make_scene(text);
}

// The room near the object, where its gloss and the clamp act most, and elsewhere.
std::array<double, 2> sum_parts(const Stage& stage, const HdrImage& layer) {
  constexpr int kNear = 4;
  std::array<double, 2> sums{};
  const int width = stage.coverage.width, height = stage.coverage.height;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      bool near = false;
      for (int v = std::max(0, y - kNear); v <= std::min(height - 1, y + kNear); ++v) {
        for (int u = std::max(0, x - kNear); u <= std::min(width - 1, x + kNear); ++u)
          near |= stage.coverage.values[static_cast<std::size_t>(v * width + u)] > 0;
      }
      sums[near ? 0 : 1] += test::luminance_at(layer, static_cast<std::size_t>(y * width + x));
    }
  }
  return sums;
}

struct Case {
  const char* name;
  Scene (*make)();
  std::vector<std::string> materials;
  int level;
};

class RoomSetsOf : public testing::TestWithParam<Case> {};

constexpr int kRuns = 40;

// By material and part, over the runs.
using Sums = std::vector<std::array<std::vector<double>, 2>>;

void add_sums(const Stage& stage, std::size_t material, const HdrImage& layer, Sums& sums) {
  const auto parts = sum_parts(stage, layer);
  for (std::size_t part = 0; part < 2; ++part) sums[material][part].push_back(parts[part]);
}

// Forty runs of four sets each against as many of paths. Level 1 % over a case's materials and parts; that
// the clamped sets alone are too dark is seen beyond doubt.
TEST_P(RoomSetsOf, WithWhatTheClampTakesHaveThePathTracersLight) {
  const Case& how = GetParam();
  const Stage stage(how.make(), "G0", how.materials, 40, 30);
  const std::size_t materials = how.materials.size();
  const double clamp = clamp_per_m2(how.level);
  HdrImage totals(stage.primary.width, stage.primary.height);
  std::fill(totals.values.begin(), totals.values.end(), 0.1f);
  const std::vector<int> regions;
  Sums whole(materials), clamped(materials), traced(materials);
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    const RoomSetsParams params{
        4, find_path_count(stage.world, 6000, 1), clamp, 0.05, 1e-4, seed, "room-sets-test", totals, regions};
    const auto sets = trace_room_sets(stage.room(), params, [] {});
    const PathMap map = stage.map(2);
    const StreamKey key = make_stream_key(seed, "room-sets-test");
    const TracedLayer direct =
        trace_room_direct(stage.world, stage.primary, {key, map, {}}, "room-sets-test", [](double) {});
    const auto returned = trace_room_compensation(
        stage.room(), map, {{clamp}, Emission::kLambertian, seed, "room-sets-test", {}}, [](double) {});
    const PathMap more = stage.map(8);
    const auto by_paths = trace_backgrounds(stage.world, stage.materials, stage.primary,
                                            {make_background_key(1000 + seed, "room-sets-test"), more, {}},
                                            "room-sets-test", [](double) {});
    for (std::size_t i = 0; i < materials; ++i) {
      HdrImage sum = sets[i].layer.mean;
      for (std::size_t j = 0; j < sum.values.size(); ++j) sum.values[j] += direct.mean.values[j];
      add_sums(stage, i, sum, clamped);
      for (std::size_t j = 0; j < sum.values.size(); ++j) sum.values[j] += returned[i].mean.values[j];
      add_sums(stage, i, sum, whole);
      add_sums(stage, i, by_paths[i].mean, traced);
    }
  }
  for (std::size_t i = 0; i < materials; ++i) {
    for (std::size_t part = 0; part < 2; ++part) {
      const std::string what = fmt::format("{} part {}", how.materials[i], part);
      const test::Mean sets = test::mean_of(whole[i][part]), paths = test::mean_of(traced[i][part]),
                       dark = test::mean_of(clamped[i][part]);
      EXPECT_GT(test::test_equal_means(sets, paths, kRuns), .01 / (2.0 * static_cast<double>(materials)))
          << what << ": " << sets.mean << " and " << paths.mean;
      EXPECT_LT(std::hypot(sets.standard_error, paths.standard_error), .006 * paths.mean) << what;
      if (part == 0) {
        EXPECT_LT(test::test_equal_means(dark, paths, kRuns), 1e-6) << what;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, RoomSetsOf,
                         testing::Values(Case{"Cafe", load_cafe, {"MS", "GS", "LG"}, 7},
                                         Case{"LampRoom", make_lamp_room, {"grey", "shiny"}, 8}),
                         [](const auto& row) { return std::string(row.param.name); });

// A family of the paper's, small.
ReferenceParams make_params(double outside_mean, std::uint64_t seed = 1) {
  ReferenceParams params;
  params.method = ReferenceMethod::kCompensated;
  params.target = {6, 18, outside_mean};
  params.seed = seed;
  params.stream_name = params.background_stream_name = "room-sets-test";
  return params;
}

DisplayNoise find_noise(const Stage& stage, const FamilyLayers& layers) {
  const HdrImage reference = composite({&layers.background, &layers.direct, &layers.indirect});
  return measure_display_noise(reference, layers.standard_error, stage.coverage,
                               make_tone_curve(reference, stage.coverage, ToneMapping{}));
}

constexpr double kTarget = 2;
constexpr int kWidth = 48, kHeight = 36;

class CompensatedRooms : public testing::Test {
 protected:
  Stage stage_{load_cafe(), "G0", {"MS", "GS", "LG"}, kWidth, kHeight};
  ReferenceParams params_ = make_params(kTarget);
  BackgroundPlan plan_ = plan_background(stage_.world, stage_.primary, params_, test::no_progress());
};

TEST_F(CompensatedRooms, AreTheSameBesideAMaterialWhateverElseIsAskedForAndOnAnyNumberOfThreads) {
  ASSERT_TRUE(plan_.by_sets);
  const auto together = trace_planned_backgrounds(stage_.room(), plan_, params_, test::no_progress());
  const ThreadLimit limit(1);
  for (const std::size_t i : {0u, 2u}) {
    const auto alone = trace_planned_backgrounds(stage_.room_beside(i), plan_, params_, test::no_progress());
    EXPECT_EQ(together[i].layer.mean.values, alone[0].layer.mean.values) << i;
    EXPECT_EQ(together[i].layer.standard_error.values, alone[0].layer.standard_error.values) << i;
    ASSERT_EQ(together[i].sets->regions.size(), alone[0].sets->regions.size()) << i;
    EXPECT_EQ(together[i].sets->regions.front().z(), alone[0].sets->regions.front().z()) << i;
  }
}

TEST_F(CompensatedRooms, MeetTheirNoiseTargetAndCarryACheckThatFindsLostLight) {
  const auto rooms = trace_planned_backgrounds(stage_.room(), plan_, params_, test::no_progress());
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    const FamilyLayers layers = trace_object({stage_.world, stage_.materials[i], stage_.primary}, plan_,
                                             rooms[i], params_, test::no_progress());
    const DisplayNoise noise = find_noise(stage_, layers);
    EXPECT_LE(noise.outside_mean, kTarget) << i;
    EXPECT_GT(noise.outside_mean, .4 * kTarget) << i;
    ASSERT_TRUE(layers.room) << i;
    EXPECT_GE(layers.room->sets, 8) << i;
    EXPECT_GE(layers.room->regions.size(), 6u) << i;
    double lost = 0;
    for (RegionCheck region : layers.room->regions) {
      EXPECT_LT(std::abs(region.z()), 7) << region.name;
      region.light.mean *= 0.9;
      lost = std::max(lost, std::abs(region.z()));
    }
    EXPECT_GT(lost, 7) << i;
  }
}

// Of which an eighth of the VPLs was foreseen: it is made again, by more sets, until it meets the target.
TEST_F(CompensatedRooms, ThatMissTheirTargetAreMadeAgain) {
  ASSERT_TRUE(plan_.by_sets);
  plan_.by_sets->sets.vpls /= 8;
  const auto room = trace_planned_backgrounds(stage_.room_beside(1), plan_, params_, test::no_progress());
  const FamilyLayers layers = trace_object({stage_.world, stage_.materials[1], stage_.primary}, plan_,
                                           room[0], params_, test::no_progress());
  EXPECT_GT(layers.room_turns, 1);
  ASSERT_TRUE(layers.room);
  EXPECT_GT(layers.room->sets, room[0].sets->sets);
  EXPECT_LE(find_noise(stage_, layers).outside_mean, kTarget);
}

// A room whose stages are kept, as runs come and go.
class KeptRooms : public CompensatedRooms {
 protected:
  KeptRooms() {
    for (const char* name : {"MS", "GS"})
      members_.push_back({fmt::format("G0-{}-ind-ref-v0", name), digest_text(name)});
  }

  // Of the first so many materials: what is made of them, and by how many paths.
  struct Run {
    BackgroundPlan plan;
    std::vector<Background> rooms;
    double paths = 0;
  };
  Run run(std::size_t materials = 2) const {
    Run run;
    std::atomic<double> paths = 0;
    const FamilyProgress progress{[&](double done) { paths += done; }, [](double) {}};
    const RoomStages stages(folder_ / "room", {members_.begin(), members_.begin() + materials},
                            {kWidth, kHeight});
    run.plan = plan_background(stage_.world, stage_.primary, params_, progress, stages);
    const RoomScene scene{stage_.world, std::span(stage_.materials).first(materials), stage_.primary};
    run.rooms = trace_planned_backgrounds(scene, run.plan, params_, progress, stages);
    run.paths = paths;
    return run;
  }
  std::vector<Background> trace_all() const {
    const RoomScene scene{stage_.world, std::span(stage_.materials).first(members_.size()), stage_.primary};
    return trace_planned_backgrounds(scene, plan_, params_, test::no_progress());
  }
  void expect_same(const Run& run, const std::vector<Background>& rooms) const {
    EXPECT_EQ(run.plan.map, plan_.map);
    EXPECT_EQ(run.plan.pilot.mean.values, plan_.pilot.mean.values);
    ASSERT_EQ(run.plan.by_sets.has_value(), plan_.by_sets.has_value());
    for (std::size_t i = 0; i < run.rooms.size(); ++i) {
      EXPECT_EQ(run.rooms[i].layer.mean.values, rooms[i].layer.mean.values) << i;
      EXPECT_EQ(run.rooms[i].layer.standard_error.values, rooms[i].layer.standard_error.values) << i;
      ASSERT_EQ(run.rooms[i].sets.has_value(), rooms[i].sets.has_value());
      if (!rooms[i].sets) continue;
      EXPECT_EQ(run.rooms[i].sets->mean_vpls, rooms[i].sets->mean_vpls);
      EXPECT_EQ(run.rooms[i].sets->compensation_paths, rooms[i].sets->compensation_paths);
      EXPECT_EQ(run.rooms[i].sets->regions.back().z(), rooms[i].sets->regions.back().z());
    }
  }
  std::vector<std::filesystem::path> list_stages() const {
    std::vector<std::filesystem::path> stages;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "room"))
      stages.push_back(entry.path());
    std::sort(stages.begin(), stages.end());
    return stages;
  }
  // As if a run had ended after all others; how many paths it takes to make what is not there.
  double run_without(const std::string& stage, const std::vector<Background>& rooms) const {
    std::filesystem::remove(folder_ / "room" / (stage + ".stage"));
    const Run again = run();
    expect_same(again, rooms);
    return again.paths;
  }

  const TempFolder folder_;
  std::vector<RoomMember> members_;
};

TEST_F(KeptRooms, AreTheSameAndMakeNoStageTwice) {
  ASSERT_TRUE(plan_.by_sets);
  const auto rooms = trace_all();
  const Run first = run();
  EXPECT_EQ(list_stages().size(), 2u + 4u * 2u) << "the plan, direct light; paths, compensation, check, sets";
  expect_same(first, rooms);
  const Run again = run();
  EXPECT_EQ(again.paths, 0);
  expect_same(again, rooms);
  const Run fewer = run(1);
  EXPECT_EQ(fewer.paths, 0) << "after the reference of one is whole";
  expect_same(fewer, rooms);
  for (const char* stage : {"direct", "check-G0-GS-ind-ref-v0"}) {
    const double one = run_without(stage, rooms);
    EXPECT_GT(one, 0) << stage;
    EXPECT_LT(one, .5 * first.paths) << stage;
  }
}

TEST_F(KeptRooms, OfPathsAloneAreMadeInParts) {
  params_.method = ReferenceMethod::kPath;
  params_.target.outside_mean = 6;
  plan_ = plan_background(stage_.world, stage_.primary, params_, test::no_progress());
  const auto rooms = trace_all();
  const Run first = run();
  EXPECT_EQ(list_stages().size(), 1u + 8u * 2u);
  expect_same(first, rooms);
  EXPECT_EQ(run().paths, 0);
  const double part = run_without("paths-4-of-8-G0-GS-ind-ref-v0", rooms);
  EXPECT_GT(part, 0);
  EXPECT_LT(part, .25 * first.paths);
}

// Stages of nothing but a grey layer.
class GreyStages : public testing::Test {
 protected:
  RoomStages open(std::vector<RoomMember> members) const {
    return {folder_ / "rooms/room", std::move(members), {4, 3}};
  }
  // How many of the two stages, of all and of each, are made.
  int count_made(const std::vector<RoomMember>& members) {
    int made = 0, skipped = 0;
    lacked_.clear();
    const auto make = [&] {
      ++made;
      TracedLayer layer{HdrImage(4, 3), HdrImage(4, 3)};
      layer.mean.values.assign(36, .5f);
      return layer;
    };
    const RoomStages stages = open(members);
    const auto skip = [&] { ++skipped; };
    const TracedLayer shared = stages.keep<TracedLayer>("shared", make, skip);
    const auto own = stages.keep_each<TracedLayer>(
        "own", members.size(),
        [&](const std::vector<std::size_t>& which) {
          lacked_ = which;
          return std::vector(which.size(), make());
        },
        skip);
    EXPECT_EQ(made + skipped, 2);
    EXPECT_EQ(own.size(), members.size());
    EXPECT_EQ(shared.mean.values, std::vector(36, .5f));
    for (const TracedLayer& layer : own) EXPECT_EQ(layer.mean.values, shared.mean.values);
    return made;
  }

  const TempFolder folder_;
  const std::vector<RoomMember> members_{{"a", digest_text("a")}, {"b", digest_text("b")}};
  std::vector<std::size_t> lacked_;  // of the last time, what was made for members by themselves
};

TEST_F(GreyStages, AreTakenForTheSameReferencesOrFewerOfThem) {
  EXPECT_EQ(count_made(members_), 2);
  EXPECT_EQ(count_made(members_), 0);
  EXPECT_EQ(count_made({members_[1]}), 0);
  EXPECT_EQ(count_made({members_[0], {"c", digest_text("c")}}), 2) << "of one reference more";
  EXPECT_EQ(count_made({{"a", digest_text("another")}}), 2) << "of another scene";
}

TEST_F(GreyStages, ThatAreDamagedOrAnothersAreMadeAgain) {
  count_made(members_);
  for (const char* stage : {"shared", "own-a"}) {
    const auto path = folder_ / "rooms/room" / (std::string(stage) + ".stage");
    const std::string whole = load_text(path);
    std::string changed = whole, other = whole;
    changed[whole.size() - 30] ^= 1;
    other.replace(other.find(stage, 64), 1, "S");
    for (const std::string& bytes :
         {changed, whole.substr(0, whole.size() - 1), whole + "x", std::string(),
          digest_text(other.substr(64)) + other.substr(64), load_text(folder_ / "rooms/room/own-b.stage")}) {
      save_text(path, bytes);
      EXPECT_EQ(count_made(members_), 1) << stage;
    }
  }
}

// As a kill between two members' files leaves it.
TEST_F(GreyStages, AreMadeForTheMembersThatLackThemAlone) {
  count_made(members_);
  EXPECT_EQ(lacked_, (std::vector<std::size_t>{0, 1}));
  const auto of = [&](const char* stage) { return folder_ / "rooms/room" / stage; };
  const auto written = std::filesystem::last_write_time(of("own-a.stage"));
  std::filesystem::remove(of("own-b.stage"));
  EXPECT_EQ(count_made(members_), 1);
  EXPECT_EQ(lacked_, std::vector<std::size_t>{1});
  EXPECT_EQ(std::filesystem::last_write_time(of("own-a.stage")), written);
  EXPECT_EQ(count_made({members_[1], {"c", digest_text("c")}, members_[0]}), 2);
  EXPECT_EQ(lacked_, std::vector<std::size_t>{1});
}

TEST_F(GreyStages, GoWithTheirFoldersUnlessSomebodysFilesAreThere) {
  count_made(members_);
  const auto note = folder_.write("rooms/room/note.txt", "somebody's");
  open(members_).remove();
  EXPECT_TRUE(std::filesystem::exists(note));
  std::filesystem::remove(note);
  count_made(members_);
  remove_room_stages(folder_ / "rooms");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "rooms"));
  EXPECT_EQ(count_made(members_), 2);
  open(members_).remove();
  EXPECT_FALSE(std::filesystem::exists(folder_ / "rooms"));
}

// A digest can be had by anybody; what it is of must still be a room's.
TEST(RoomStageBytes, ThatNoRoomCouldHaveAreRefused) {
  const PixelSize size{4, 3};
  StageWriter writer;
  TracedLayer layer{HdrImage(4, 3), HdrImage(4, 3)};
  layer.mean.values[7] = -0.0f;
  layer.mean.values[20] = .5f;
  writer.write(layer);
  const std::string bytes = writer.take();
  const auto parse = [&](std::string_view text, PixelSize pixels) {
    return parse_stage<TracedLayer>(text, pixels, "test");
  };
  ASSERT_TRUE(parse(bytes, size));
  EXPECT_EQ(std::memcmp(parse(bytes, size)->mean.values.data(), layer.mean.values.data(), 36 * 4), 0)
      << "a zero keeps its sign";
  EXPECT_FALSE(parse(bytes, PixelSize{3, 4}));
  EXPECT_FALSE(parse(bytes + "x", size));
  for (std::size_t cut = 0; cut < bytes.size(); ++cut) EXPECT_FALSE(parse(bytes.substr(0, cut), size)) << cut;
  layer.mean.values[7] = std::numeric_limits<float>::quiet_NaN();
  writer.write(layer);
  EXPECT_FALSE(parse(writer.take(), size));
  writer.write(BackgroundPlan{PathMap(12, 1U << 31), {}, {}, {}});
  EXPECT_FALSE(parse_stage<BackgroundPlan>(writer.take(), size, "test")) << "paths without an end";
}

// What the standard error layer says is what two rooms differ by: over four of each. The ratio errs by some
// .07.
TEST(CompensatedRoom, KnowsItsError) {
  const Stage stage(load_cafe(), "G0", {"GS"}, 48, 36);
  const BackgroundPlan plan =
      plan_background(stage.world, stage.primary, make_params(2.5), test::no_progress());
  ASSERT_TRUE(plan.by_sets);
  double squares = 0, errors = 0;
  for (std::uint64_t seed = 2; seed <= 8; seed += 2) {
    const auto trace = [&](std::uint64_t its_seed) {
      return trace_planned_backgrounds(stage.room(), plan, make_params(2.5, its_seed), test::no_progress())[0]
          .layer;
    };
    const TracedLayer a = trace(seed), b = trace(seed + 1);
    for (std::size_t i = 0; i < stage.coverage.pixel_count(); ++i) {
      if (stage.coverage.values[i] > 0) continue;
      squares += std::pow(a.mean.pixel(i)[1] - b.mean.pixel(i)[1], 2);
      errors += std::pow(a.standard_error.pixel(i)[1], 2) + std::pow(b.standard_error.pixel(i)[1], 2);
    }
  }
  EXPECT_NEAR(squares / errors, 1, 0.25);
}

TEST(CompensatedRoom, OfATargetThatFewPathsMeetIsPathTraced) {
  const Stage stage(load_cafe(), "G0", {"GS"}, 40, 30);
  EXPECT_FALSE(plan_background(stage.world, stage.primary, make_params(60), test::no_progress()).by_sets);
}

}  // namespace
}  // namespace equilux
