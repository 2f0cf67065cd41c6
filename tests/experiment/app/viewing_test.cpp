// Degrees, from closed forms.
#include "experiment/app/viewing.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace equilux {
namespace {

using testing::HasSubstr;

TEST(ViewingTest, ADiagonalGivesSquarePixels) {
  const auto pitch = find_pixel_pitch({1600, 1200}, 0.5, {300, 100});
  ASSERT_TRUE(pitch.has_value());
  EXPECT_DOUBLE_EQ(pitch->x_m, 0.5 / 2000);
  EXPECT_DOUBLE_EQ(pitch->y_m, 0.5 / 2000);
}

TEST(ViewingTest, WithoutADiagonalTheReportedSizeCountsInEachDirection) {
  const auto pitch = find_pixel_pitch({1000, 500}, 0, {400, 300});
  ASSERT_TRUE(pitch.has_value());
  EXPECT_DOUBLE_EQ(pitch->x_m, 0.0004);
  EXPECT_DOUBLE_EQ(pitch->y_m, 0.0006);
}

TEST(ViewingTest, AScreenOfUnknownSizeHasNoPitch) {
  EXPECT_FALSE(find_pixel_pitch({1000, 500}, 0, {0, 0}).has_value());
  EXPECT_FALSE(find_pixel_pitch({1000, 500}, 0, {400, 0}).has_value());
}

TEST(ViewingTest, APictureTwiceAsWideAsItsDistanceSpansNinetyDegrees) {
  const Degrees degrees = find_degrees({2000, 1000}, {0.001, 0.001}, 1);
  EXPECT_NEAR(degrees.wide, 90, 1e-12);
  EXPECT_NEAR(degrees.high, 2 * std::atan(0.5) * 180 / M_PI, 1e-12);
}

// 110.7 pixels per inch are 35 pixels per degree at 18 inches, in the middle of the picture.
TEST(ViewingTest, ThePapersPicturesSpanSixteenByTwelveDegreesOnThePapersScreen) {
  const double pitch = 0.0254 / 110.7;
  const Degrees degrees = find_degrees({560, 420}, {pitch, pitch}, 0.4572);
  EXPECT_NEAR(degrees.wide, 16, 0.1);
  EXPECT_NEAR(degrees.high, 12, 0.1);
  EXPECT_EQ(describe_deviation(degrees, {16, 12}, 0.4572), "");
}

TEST(ViewingTest, MoreThanOneDegreeOffIsSaidWithBothNumbers) {
  EXPECT_EQ(describe_deviation(Degrees{16.99, 11.01}, {16, 12}, 0.4572), "");
  const std::string wide = describe_deviation(Degrees{17.01, 12}, {16, 12}, 0.4572);
  EXPECT_THAT(wide, HasSubstr("17.0 x 12.0"));
  EXPECT_THAT(wide, HasSubstr("16.0 x 12.0"));
  EXPECT_THAT(describe_deviation(Degrees{16, 10.9}, {16, 12}, 0.4572), HasSubstr("16.0 x 10.9"));
}

TEST(ViewingTest, AnUnknownSizeIsSaid) {
  EXPECT_THAT(describe_deviation(std::nullopt, {16, 12}, 0.4572), HasSubstr("not known"));
}

}  // namespace
}  // namespace equilux
