// Places of pictures, worked out by hand.
#include "experiment/app/layout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"

namespace equilux {
namespace {

constexpr Size kPaper{560, 420};
constexpr Size kPocket{280, 210};

bool overlap(const Rectangle& a, const Rectangle& b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

bool is_within(const Rectangle& a, Size framebuffer) {
  return a.x >= 0 && a.y >= 0 && a.x + a.width <= framebuffer.width && a.y + a.height <= framebuffer.height;
}

TEST(LayoutTest, PicturesOfThePaperNeed1136By930Pixels) {
  EXPECT_EQ(find_least_framebuffer(kPaper), (Size{1136, 930}));
}

TEST(LayoutTest, SmallPicturesStillLeaveRoomForTheQuestion) {
  EXPECT_EQ(find_least_framebuffer(kPocket), (Size{kQuestionWidth, 510}));
}

TEST(LayoutTest, ThreePicturesFillTheLeastFramebufferToItsEdges) {
  const Layout layout = make_layout({1136, 930}, kPaper, Experiment::kMaterial);
  EXPECT_EQ(layout.left, (Rectangle{0, 510, 560, 420}));
  EXPECT_EQ(layout.right, (Rectangle{576, 510, 560, 420}));
  EXPECT_EQ(layout.upper, (Rectangle{288, 0, 560, 420}));
  EXPECT_EQ(layout.question, (Rectangle{0, 420, 1136, 90}));
}

TEST(LayoutTest, OnePixelTooFewIsRefusedWithBothSizes) {
  for (const Size small : {Size{1135, 930}, Size{1136, 929}}) {
    try {
      make_layout(small, kPaper, Experiment::kArtifact);
      ADD_FAILURE() << small.width << " x " << small.height << " was taken";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("1136 x 930"));
      EXPECT_THAT(error.what(), testing::HasSubstr(fmt::format("got {} x {}", small.width, small.height)));
    }
  }
}

TEST(LayoutTest, TheLowerPairStandsAtTheSamePlaceInBothExperiments) {
  for (const Size screen : {Size{1280, 1024}, Size{1921, 1081}, Size{3840, 2160}}) {
    const Layout artifact = make_layout(screen, kPaper, Experiment::kArtifact);
    const Layout material = make_layout(screen, kPaper, Experiment::kMaterial);
    EXPECT_EQ(artifact.left, material.left);
    EXPECT_EQ(artifact.right, material.right);
    EXPECT_EQ(artifact.question, material.question);
    EXPECT_FALSE(artifact.upper.has_value());
    EXPECT_TRUE(material.upper.has_value());
  }
}

TEST(LayoutTest, NothingOverlapsOrLeavesTheScreenAtAnySize) {
  for (const Size picture : {kPaper, kPocket, Size{1, 1}, Size{301, 199}}) {
    const Size least = find_least_framebuffer(picture);
    for (int extra = 0; extra < 40; ++extra) {
      const Size screen{least.width + extra, least.height + 2 * extra + 1};
      const Layout layout = make_layout(screen, picture, Experiment::kMaterial);
      const std::vector<Rectangle> places{layout.left, layout.right, *layout.upper, layout.question};
      for (std::size_t i = 0; i < places.size(); ++i) {
        EXPECT_TRUE(is_within(places[i], screen)) << i << " at " << extra;
        for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(overlap(places[i], places[j])) << i << ", " << j;
      }
    }
  }
}

TEST(LayoutTest, APlainWindowHasAMarginAndRoomForPagesWhereTheScreenAllows) {
  EXPECT_EQ(choose_window_size(kPaper, {1920, 1080}), (Size{1200, 994}));
  EXPECT_EQ(choose_window_size(kPaper, {1160, 940}), (Size{1160, 940}));
  EXPECT_EQ(choose_window_size(kPaper, {640, 480}), (Size{1136, 930}));
  EXPECT_EQ(choose_window_size(kPocket, {1920, 1080}), kPageSize);
  EXPECT_EQ(choose_window_size(kPocket, {800, 600}), (Size{800, 600}));
}

TEST(LayoutTest, APointBelongsToThePictureWhosePixelItIsIn) {
  const Layout layout = make_layout({1136, 930}, kPaper, Experiment::kMaterial);
  EXPECT_EQ(find_side(layout, 0, 510), Side::kLeft);
  EXPECT_EQ(find_side(layout, 559.9, 929.9), Side::kLeft);
  EXPECT_EQ(find_side(layout, 576, 510), Side::kRight);
  EXPECT_EQ(find_side(layout, 560, 600), std::nullopt);  // the gap
  EXPECT_EQ(find_side(layout, 100, 509.9), std::nullopt);
  EXPECT_EQ(find_side(layout, 500, 200), std::nullopt);  // the reference
}

}  // namespace
}  // namespace equilux
