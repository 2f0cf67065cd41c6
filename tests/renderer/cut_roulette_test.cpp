// Cuts with a part of their shadow rays against the same cuts with all.
#include <gtest/gtest.h>

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

  Cafe cafe_{"G2", 90, 1500, Emission::kFull, {"MS", "BR", "LG"}};
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

// 400 keys; every material, level, point and channel on its own, level .001 over all 25 hundred by
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
  double largest = 0;
  std::size_t moved = 0;
  for (const auto& of_value : differences) {
    const test::Mean mean = test::mean_of(of_value);
    if (mean.standard_error == 0) {
      EXPECT_EQ(mean.mean, 0);
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

// The rays of many cuts that follow one another are as many as their probabilities add up to, to within one a
// lane, whatever the start is.
TEST_P(CutRoulettes, TakeAboutAsManyRaysFromEveryStart) {
  std::vector<double> rays;
  for (std::size_t key = 0; key < 50; ++key) {
    CutRecord record;
    cut({0.02, make_stream_key(key, "roulette-test")}, record);
    rays.push_back(static_cast<double>(record.shadow_rays));
  }
  const auto [least, most] = std::minmax_element(rays.begin(), rays.end());
  EXPECT_LE(*most - *least, static_cast<double>(16 * points_.size()));
  EXPECT_LT(*most / *least, 1.1);
}

}  // namespace
}  // namespace equilux
