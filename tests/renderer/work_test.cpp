// Shares of work: each thing once, none longer than it must be.
#include "renderer/work.h"

#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/random.h"
#include "tests/renderer/test_scene.h"

namespace equilux {
namespace {

std::map<WorldKey, WorldCosts> make_costs(const Study& study) {
  std::map<WorldKey, WorldCosts> costs;
  double size = 1;
  for (const Object& object : enumerate_objects(study)) {
    if (costs.contains(world_of(object))) continue;
    WorldCosts& world = costs[world_of(object)] = {1e4 * size, {}, 1e7, 0, 0, {}};
    for (const char* material : {"MS", "MR", "BS", "BR", "GS"}) world.object[material] = 3e6 * size;
    size *= 1.3;
  }
  return costs;
}

Study load_paper() { return load_study(std::filesystem::path(EQUILUX_SOURCE_DIR) / "protocols/paper.json"); }

TEST(Work, IsSplitSoThatEachPictureFallsToOneShare) {
  const Study study = load_paper();
  const Wanted wanted = enumerate_wanted(study, "*");
  const auto items = list_work(make_costs(study), wanted);
  for (const int count : {1, 2, 3, 7, 16, 79, 80, 200}) {
    std::vector<std::string> keys;
    const auto shares = split_work(items, count);
    ASSERT_EQ(shares.size(), static_cast<std::size_t>(count));
    for (const auto& share : shares) {
      const Wanted part = join_work(share);
      for (const Family& family : part.families) keys.push_back(format_key(family));
      for (const Condition& condition : part.conditions) {
        keys.push_back(format_key(condition));
        EXPECT_TRUE(std::count(part.families.begin(), part.families.end(), family_of(condition)))
            << "a cut needs its reference: " << keys.back();
      }
    }
    EXPECT_EQ(keys.size(), wanted.families.size() + wanted.conditions.size());
    std::sort(keys.begin(), keys.end());
    EXPECT_EQ(std::adjacent_find(keys.begin(), keys.end()), keys.end()) << count;
  }
}

// A ball seen from outside never meets itself, and from inside with every ray.
TEST(Work, CostsMoreWhereTheObjectMeetsItself) {
  const Study study = load_paper();
  test::SceneText text;
  const auto shape_of = [&] {
    const Scene scene = test::make_scene(text);
    return estimate_costs(study, scene, make_world(scene, "G0", Illumination::kIndirect), {}).shape;
  };
  const auto expect_shape = [&](double self_occlusion) {
    const ShapeCosts shape = shape_of(), meant = cost_of_shape(self_occlusion);
    EXPECT_EQ(shape.sums, meant.sums);
    EXPECT_EQ(shape.cuts, meant.cuts);
    EXPECT_EQ(shape.references, meant.references);
  };
  expect_shape(0);
  text.camera = R"({"position":[0,-0.5,0],"target":[0,0,0],"up":[0,0,1],"vertical_fov_degrees":40})";
  expect_shape(1);
  text.camera = R"({"position":[0,-9,0],"target":[0,-10,0],"up":[0,0,1],"vertical_fov_degrees":40})";
  expect_shape(0);
}

TEST(Work, OfAnObjectGoesWithItsShape) {
  const Study study = load_paper();
  auto costs = make_costs(study);
  const auto cost_of = [&](const std::string& only) {
    const Wanted wanted = enumerate_wanted(study, only);
    return sum_work(list_work(costs, {{}, wanted.conditions}));
  };
  const double plain = cost_of("G0-MS-ind-1k-*-v0"), cut = cost_of("G0-MS-ind-5M-*-v0"),
               other = cost_of("G0-MS-dir-*");
  costs.at({"G0", Illumination::kIndirect}).shape = {2, 3, 4};
  EXPECT_DOUBLE_EQ(cost_of("G0-MS-ind-1k-*-v0") - plain, kPairCost * 1e3 * 1e4);
  EXPECT_DOUBLE_EQ(cost_of("G0-MS-ind-5M-*-v0") - cut,
                   2 * (cost_of_cuts(5000000, 1e4) + cost_of_measuring(5000000)));
  EXPECT_EQ(cost_of("G0-MS-dir-*"), other) << "the same object in another world";
}

// By trying every way to cut a list in runs.
double find_least_longest(const std::vector<WorkItem>& items, std::size_t first, int runs) {
  if (runs == 1) return sum_work({items.begin() + static_cast<std::ptrdiff_t>(first), items.end()});
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t end = first; end <= items.size(); ++end) {
    const double head = sum_work({items.begin() + static_cast<std::ptrdiff_t>(first),
                                  items.begin() + static_cast<std::ptrdiff_t>(end)});
    if (head >= least) break;
    least = std::min(least, std::max(head, find_least_longest(items, end, runs - 1)));
  }
  return least;
}

// 60 lists of random costs, seed 5; one product in three is shared with the item before.
TEST(Work, HasAsItsLongestShareTheShortestThatThereIs) {
  RandomStream random(5, "work-test", 0);
  for (int list = 0; list < 60; ++list) {
    std::vector<WorkItem> items;
    int group = 0;
    for (int i = 0; i < 9; ++i) {
      WorkItem item;
      item.own = random.next_float();
      if (random.next_float() < 0.33f) ++group;
      item.shared[std::to_string(group)] = 2 * random.next_float();
      if (i > 0 && items.back().shared.contains(std::to_string(group))) item.shared = items.back().shared;
      items.push_back(item);
    }
    for (const int runs : {1, 2, 4}) {
      double longest = 0;
      for (const auto& share : split_work(items, runs)) longest = std::max(longest, sum_work(share));
      EXPECT_NEAR(longest, find_least_longest(items, 0, runs), 1e-9) << list << " in " << runs;
    }
  }
}

// As split_work, but that each item is tried on a copy of what is paid.
std::vector<std::vector<WorkItem>> split_slowly(const std::vector<WorkItem>& items, std::size_t count) {
  const auto add = [](const WorkItem& item, std::set<std::string>& paid) {
    double work = item.own;
    for (const auto& [key, cost] : item.shared) work += paid.insert(key).second ? cost : 0;
    return work;
  };
  const auto fill = [&](double most) {
    std::vector<std::vector<WorkItem>> runs;
    std::set<std::string> paid;
    double work = 0;
    for (const WorkItem& item : items) {
      std::set<std::string> then = paid;
      const double more = add(item, then);
      const bool begins = runs.empty() || work + more > most;
      if (begins) runs.emplace_back();
      if (begins) paid.clear();
      work = begins ? add(item, paid) : work + more;
      if (!begins) paid = std::move(then);
      runs.back().push_back(item);
    }
    return runs;
  };
  double low = 0, high = sum_work(items);
  for (int step = 0; step < 50; ++step) {
    const double middle = (low + high) / 2;
    (fill(middle).size() <= count ? high : low) = middle;
  }
  auto runs = fill(high);
  runs.resize(count);
  return runs;
}

std::vector<std::vector<std::string>> list_families(const std::vector<std::vector<WorkItem>>& shares) {
  std::vector<std::vector<std::string>> keys;
  for (const auto& share : shares) {
    keys.emplace_back();
    for (const WorkItem& item : share) keys.back().push_back(format_key(item.family));
  }
  return keys;
}

TEST(Work, OfTheFourStudiesIsSplitAsItWasByTryingOnCopies) {
  for (const char* name : {"paper", "validation", "normalisation", "pocket"}) {
    const Study study =
        load_study(std::filesystem::path(EQUILUX_SOURCE_DIR) / "protocols" / (std::string(name) + ".json"));
    auto costs = make_costs(study);
    for (auto& [key, world] : costs) world.object["LG"] = 4e6;
    const auto items = list_work(costs, enumerate_wanted(study, "*"));
    for (const int count : {1, 3, 16, 100})
      EXPECT_EQ(list_families(split_work(items, count)),
                list_families(split_slowly(items, static_cast<std::size_t>(count))))
          << name << " in " << count;
  }
}

// Random costs, seed 7; products are shared by two, ten or fifty neighbours.
std::vector<WorkItem> draw_work(std::size_t count) {
  RandomStream random(7, "work-test", 1);
  std::vector<WorkItem> items(count);
  for (std::size_t i = 0; i < count; ++i) {
    items[i].family.object.geometry = fmt::format("G{}", i);
    items[i].own = random.next_float();
    for (const std::size_t group : {i / 2, i / 10, i / 50})
      items[i].shared[std::to_string(group) + "-" + std::to_string(i % 3)] = 5 * random.next_float();
  }
  return items;
}

TEST(Work, ThatIsDrawnIsSplitAsItWasByTryingOnCopies) {
  const auto items = draw_work(300);
  for (const int count : {1, 2, 17, 299, 400})
    EXPECT_EQ(list_families(split_work(items, count)),
              list_families(split_slowly(items, static_cast<std::size_t>(count))))
        << count;
}

TEST(Work, HasASpeedAlsoWhereTheCameraSeesNothing) {
  Scene scene = load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/cafe.json");
  scene.camera.position = {1000, 1000, 1000};
  scene.camera.target = {1001, 1001, 1001};
  EXPECT_GT(measure_speed(load_paper(), scene), 0);
}

TEST(Work, CountsWhatIsSharedOnce) {
  const Study study = load_paper();
  const auto costs = make_costs(study);
  const auto cost_of = [&](const std::string& only) {
    return sum_work(list_work(costs, enumerate_wanted(study, only)));
  };
  const double one = cost_of("G0-MS-ind-ref-v0"), other = cost_of("G0-GS-ind-ref-v0"),
               both = cost_of("G0-[MG]S-ind-ref-v0");
  EXPECT_DOUBLE_EQ(both, one + other - 1e7) << "the room is traced for both";
  EXPECT_DOUBLE_EQ(cost_of("G0-MS-ind-ref-v?"), 2 * one) << "views share no room";
  const Wanted cells = enumerate_wanted(study, "G0-MS-ind-5M-*-v0");
  const auto items = list_work(costs, {{}, cells.conditions});
  ASSERT_EQ(items.size(), 1u);
  EXPECT_FALSE(items[0].has_reference);
  EXPECT_DOUBLE_EQ(sum_work(items), kVplCost * 5e6 + cost_of_cuts(5000000, 1e4) + cost_of_measuring(5000000))
      << "one cut for eleven levels";
}

}  // namespace
}  // namespace equilux
