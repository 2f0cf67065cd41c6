// The comparison of two renderers on made-up pictures: equal ones agree, biased ones do not.
#include "tests/peer/compare.h"

#include <gtest/gtest.h>
#include <random>

namespace equilux::test {
namespace {

constexpr int kWidth = 24, kHeight = 18;
constexpr double kLevel = 0.01 / 42;  // of one test, for .01 over 14 regions in 3 channels

/// Pictures that brighten from left to right, with relative noise of 5 % a pixel.
Pictures make_pictures(std::size_t count, unsigned seed, double scale) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 0.05);
  Pictures pictures(count, HdrImage(kWidth, kHeight));
  for (HdrImage& picture : pictures) {
    for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
      for (int c = 0; c < 3; ++c) {
        const double mean = (c + 1) * (1 + 0.1 * static_cast<double>(i % kWidth));
        picture.pixel(i)[c] = static_cast<float>(scale * mean * (1 + noise(random)));
      }
    }
  }
  return pictures;
}

HdrImage make_half_coverage() {
  HdrImage coverage(kWidth, kHeight, 1);
  for (std::size_t i = 0; i < coverage.pixel_count(); ++i) coverage.values[i] = i % kWidth < 12 ? 1 : 0;
  return coverage;
}

int count_differences(const std::vector<Agreement>& rows) {
  int count = 0;
  for (const Agreement& row : rows) count += row.p < kLevel;
  return count;
}

TEST(PeerComparison, DividesThePictureIntoCellsAndTheObject) {
  const auto regions = make_regions(make_half_coverage(), 4, 3);
  ASSERT_EQ(regions.size(), 14u);
  for (std::size_t i = 0; i < std::size_t{kWidth} * kHeight; ++i) {
    int cells = 0;
    for (std::size_t r = 0; r < 12; ++r) cells += regions[r].weights[i] > 0;
    EXPECT_EQ(cells, 1) << "each pixel is in one cell";
  }
  EXPECT_EQ(regions.back().name, "object");
  EXPECT_DOUBLE_EQ(regions.back().weights[0], 1.0 / (12 * kHeight));
  EXPECT_EQ(regions.back().weights[kWidth - 1], 0);
}

// Seeds 1 and 2, ten pictures each; by the level a false alarm comes once in 100 such pairs.
TEST(PeerComparison, PassesPicturesThatDifferByNoiseAlone) {
  const auto rows = compare_regions(make_pictures(10, 1, 1), make_pictures(10, 2, 1),
                                    make_regions(make_half_coverage(), 4, 3));
  EXPECT_EQ(rows.size(), 42u);
  EXPECT_EQ(count_differences(rows), 0);
}

// Mutant: one renderer is too bright by 1.4 times what each test says it sees in 95 of 100 runs.
TEST(PeerComparison, FindsTheBiasThatItSaysItSees) {
  const auto regions = make_regions(make_half_coverage(), 4, 3);
  const auto rows = compare_regions(make_pictures(10, 1, 1), make_pictures(10, 2, 1), regions);
  double visible = 0;
  for (const Agreement& row : rows) visible = std::max(visible, row.visible_bias(kLevel));
  EXPECT_LT(visible, 0.04);
  const auto mutant =
      compare_regions(make_pictures(10, 1, 1), make_pictures(10, 2, 1 + 1.4 * visible), regions);
  EXPECT_GE(count_differences(mutant), 40);
}

// Without noise every difference is certain: only the margin decides.
TEST(PeerComparison, PassesADifferenceWithinTheMarginAndNoneBeyond) {
  const auto regions = make_regions(make_half_coverage(), 4, 3);
  const Pictures ours(2, make_pictures(1, 1, 1).front());
  const auto differences_at = [&](double scale) {
    const Pictures theirs(2, make_pictures(1, 1, scale).front());
    return count_differences(compare_regions(ours, theirs, regions));
  };
  EXPECT_EQ(differences_at(1), 0);
  EXPECT_EQ(differences_at(1 + 0.9 * kMargin), 0);
  EXPECT_EQ(differences_at(1 - 1.1 * kMargin), 42);
}

TEST(PeerComparison, MeasuresTheErrorOfAPixel) {
  // Luminance of three channels of independent 5 %: sqrt(sum (w_c m_c)^2) / sum w_c m_c of it.
  const double r = 0.2126, g = 2 * 0.7152, b = 3 * 0.0722;
  const double expected = 0.05 * std::sqrt(r * r + g * g + b * b) / (r + g + b);
  EXPECT_NEAR(measure_pixel_error(make_pictures(40, 3, 1), make_pictures(40, 4, 1)), expected,
              0.05 * expected);
}

}  // namespace
}  // namespace equilux::test
