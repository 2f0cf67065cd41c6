// Cuts with a part of their shadow rays against the same cuts with all.
#include <algorithm>
#include <bit>
#include <gtest/gtest.h>
#include <set>

#include "tests/renderer/cafe_lights.h"
#include "tests/support/statistics.h"

namespace equilux {
namespace {

using test::Cafe;

const std::vector<double> kClamps{test::kAllClamps[0], test::kAllClamps[5], test::kAllClamps[9]};

// One tree, whose cuts go by the plain sum.
class CutRoulettes : public testing::TestWithParam<std::size_t> {
 protected:
  ShadedPoints cut(const CutRoulette& roulette, CutRecord& record) const {
    return shade_lightcut(cafe_.world, points_, tree_, cafe_.materials, kClamps,
                          {0.02, 1e-5, &base_, false, GetParam(), roulette}, &record);
  }

  // One of the materials has colour.
  Cafe cafe_ = [] {
    Cafe cafe("G2", 90, 1500, Emission::kFull, {"MS", "BR", "LG"});
    cafe.materials[1].rho_d = {0.5f, 0.2f, 0.05f};
    return cafe;
  }();
  // Three in a pixel, so that without neighbours there are groups of more than one point.
  std::vector<ShadingPoint> points_ = [this] {
    std::vector<ShadingPoint> points = cafe_.points;
    for (std::size_t i = 0; i < points.size(); ++i) points[i].pixel = static_cast<std::uint32_t>(i / 3);
    return points;
  }();
  LightTree tree_ = make_light_tree(cafe_.vpls, {7, 4});
  ShadedPoints base_ = cafe_.sum(kClamps);
};
INSTANTIATE_TEST_SUITE_P(AloneAndTogether, CutRoulettes, testing::Values(0, 1, 5, 16));

// 400 keys; every material, level, point and channel on its own, level .001 over all 810 of four widths by
// Bonferroni.
TEST_P(CutRoulettes, LeaveEveryExpectationAsItIs) {
  constexpr std::size_t kKeys = 400;
  CutRecord whole;
  const ShadedPoints truth = cut({}, whole);
  std::vector<std::vector<double>> differences(3 * truth.radiance.size());
  double rays = 0, squares = 0, light = 0;
  for (std::size_t key = 0; key < kKeys; ++key) {
    CutRecord record;
    const ShadedPoints found = cut({0.008, make_stream_key(key, "roulette-test")}, record);
    EXPECT_EQ(record.sizes, whole.sizes);
    rays += static_cast<double>(record.shadow_rays) / kKeys;
    for (std::size_t i = 0; i < truth.radiance.size(); ++i) {
      const Vec3 difference = found.radiance[i] - truth.radiance[i];
      differences[3 * i].push_back(difference.x);
      differences[3 * i + 1].push_back(difference.y);
      differences[3 * i + 2].push_back(difference.z);
      squares += std::pow(luminance(difference) / (luminance(truth.radiance[i]) + 1e-5), 2) / kKeys;
      light += 1;
    }
  }
  // Light that is next to never drawn shows in no standard error.
  constexpr double kUnseen = 1e-4;
  double largest = 0;
  std::size_t moved = 0;
  for (std::size_t i = 0; i < differences.size(); ++i) {
    const test::Mean mean = test::mean_of(differences[i]);
    const double unseen = kUnseen * (luminance(truth.radiance[i / 3]) + 1e-5);
    if (!(mean.standard_error > unseen / 5)) {
      EXPECT_LT(std::abs(mean.mean), 2 * unseen) << i;
      continue;
    }
    ++moved;
    largest = std::max(largest, std::abs(mean.mean / mean.standard_error));
  }
  EXPECT_GT(moved, differences.size() / 2);
  EXPECT_LT(largest, 5.1);
  const double error = std::sqrt(squares / (light / kKeys));
  EXPECT_LT(error, 0.06);
  EXPECT_GT(error, 0.001) << "nothing was left out";
  EXPECT_LT(rays, 0.7 * static_cast<double>(whole.shadow_rays));
  RecordProperty("largest_t", std::to_string(largest));
  RecordProperty("error", std::to_string(error));
}

// Light that is above every threshold keeps its rays and its value, bit by bit.
TEST_P(CutRoulettes, OfAShareOfNextToNothingTakeAllRays) {
  CutRecord whole, record;
  const ShadedPoints truth = cut({}, whole),
                     found = cut({1e-12, make_stream_key(1, "roulette-test")}, record);
  EXPECT_EQ(record.sizes, whole.sizes);
  EXPECT_LE(record.shadow_rays, whole.shadow_rays);
  for (std::size_t i = 0; i < truth.radiance.size(); ++i) {
    EXPECT_EQ(found.radiance[i].x, truth.radiance[i].x) << i;
    EXPECT_EQ(found.radiance[i].y, truth.radiance[i].y) << i;
    EXPECT_EQ(found.radiance[i].z, truth.radiance[i].z) << i;
  }
}

// A lane's rays are as many as their probabilities add up to, to within one, whatever the start is. A group's
// points have sixteen lanes between them.
TEST_P(CutRoulettes, TakeAboutAsManyRaysFromEveryStart) {
  const std::size_t widest = GetParam() == 0 ? 3 : GetParam();
  const std::size_t lanes = 16 / std::bit_ceil(widest) * points_.size() + 16;
  std::vector<double> rays;
  for (std::size_t key = 0; key < 50; ++key) {
    CutRecord record;
    cut({0.02, make_stream_key(key, "roulette-test")}, record);
    rays.push_back(static_cast<double>(record.shadow_rays));
  }
  const auto [least, most] = std::minmax_element(rays.begin(), rays.end());
  EXPECT_GT(*most, *least);
  EXPECT_LE(*most - *least, static_cast<double>(lanes));
  RecordProperty("points", std::to_string(points_.size()));
  RecordProperty("range", std::to_string(*most - *least));
}

// Sixteen times the same point in a group, with four keys. Some draws come to the same rays; one start for
// all points of a key would leave 4 values, one for all keys of a point 16.
TEST_P(CutRoulettes, DrawForEachPointAndKeyByItself) {
  points_.assign(16, points_[points_.size() / 2]);
  base_ = {base_.levels, 0, {}, 0};
  base_.points = points_.size();
  const ShadedPoints one =
      shade_all_vpls(cafe_.world, {points_[0]}, cafe_.vpls, cafe_.materials, kClamps, [](double) {});
  for (const Vec3 light : one.radiance) base_.radiance.insert(base_.radiance.end(), points_.size(), light);
  std::set<float> found;
  for (std::size_t key = 0; key < 4; ++key) {
    CutRecord record;
    const ShadedPoints cut_light = cut({0.02, make_stream_key(key, "roulette-test")}, record);
    for (std::size_t i = 0; i < points_.size(); ++i)
      found.insert(cut_light.radiance[cut_light.index(2, 1, i)].y);
  }
  EXPECT_GT(found.size(), 24u);
}

}  // namespace
}  // namespace equilux
