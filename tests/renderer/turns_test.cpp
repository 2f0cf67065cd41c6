// Renderings that are added and rooms that are exchanged, by closed forms.
#include "renderer/turns.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace equilux {
namespace {

constexpr int kWidth = 2, kHeight = 1;

HdrImage even(float value) {
  HdrImage image(kWidth, kHeight);
  std::fill(image.values.begin(), image.values.end(), value);
  return image;
}

// One object, whose own error is given, in a room of this error.
FamilyLayers make_layers(float direct, float indirect, double object_error, double room_error, double paths) {
  FamilyLayers layers;
  layers.background = even(9);
  layers.direct = even(direct);
  layers.indirect = even(indirect);
  layers.standard_error = even(static_cast<float>(std::hypot(object_error, room_error)));
  layers.paths = paths;
  return layers;
}

RegionCheck make_region(double mean, double error, double traced, double traced_error) {
  return {"r1c1", {mean, error, 2}, {traced, traced_error, 2}, 0};
}

SetMeasures make_sets(RegionCheck region) {
  SetMeasures sets;
  sets.regions.push_back(std::move(region));
  return sets;
}

// Over the target's square, if both err as is foreseen.
double variance_of(double miss, const Addition& addition) {
  return std::pow((1 - addition.share) * miss, 2) + std::pow(addition.share * addition.target, 2);
}

TEST(Turns, AnAdditionBringsAnyMissUnderTheTargetByTheMarginAndNoWeightDoesBetter) {
  for (const double miss : {1.0001, 1.05, 1.5, 4.0, 1e6}) {
    const Addition addition = find_addition(miss);
    EXPECT_NEAR(variance_of(miss, addition), 1 / (kTurnMargin * kTurnMargin), 1e-9) << miss;
    for (const double share : {addition.share - .01, addition.share + .01})
      EXPECT_GT(variance_of(miss, {addition.target, share}), variance_of(miss, addition)) << miss;
  }
}

TEST(Turns, TheSmallerTheMissTheWiderTheTargetOfWhatIsAdded) {
  EXPECT_NEAR(find_addition(1.05).target, 1.82, .01);
  EXPECT_NEAR(find_addition(1.05).share, .25, .005);
  EXPECT_GT(find_addition(1.01).target, find_addition(1.5).target);
  EXPECT_NEAR(find_addition(1e6).target, 1 / kTurnMargin, 1e-6) << "all of it anew";
  EXPECT_NEAR(find_addition(1e6).share, 1, 1e-6);
}

TEST(Turns, WhatIsAddedErrsByItselfAndTheRoomAsItDid) {
  FamilyLayers layers = make_layers(1, 10, .3, .4, 100);
  const TracedLayer room{even(9), even(.4f)};
  add_turn(layers, make_layers(2, 20, .6, .4, 50), room, .25);
  EXPECT_FLOAT_EQ(layers.background.values[0], 9);
  EXPECT_FLOAT_EQ(layers.direct.values[0], 1.25f);
  EXPECT_FLOAT_EQ(layers.indirect.values[0], 12.5f);
  EXPECT_NEAR(layers.standard_error.values[0], std::sqrt(.225 * .225 + .15 * .15 + .16), 1e-6);
  EXPECT_EQ(layers.paths, 150);
  ASSERT_EQ(layers.added.size(), 1u);
  EXPECT_EQ(layers.added[0].share, .25);
  EXPECT_EQ(layers.added[0].paths, 50);
  EXPECT_FALSE(layers.added[0].sets);
}

TEST(Turns, ChecksOfBothAreOfTheWeightedMean) {
  FamilyLayers layers = make_layers(0, 10, .3, 0, 100);
  layers.sets = make_sets(make_region(10, .4, 11, .8));
  FamilyLayers other = make_layers(0, 20, .6, 0, 50);
  other.sets = make_sets(make_region(20, .6, 19, .4));
  add_turn(layers, other, {even(9), even(0)}, .5);
  const RegionCheck& region = layers.sets->regions[0];
  EXPECT_DOUBLE_EQ(region.light.mean, 15);
  EXPECT_DOUBLE_EQ(region.traced.mean, 15);
  EXPECT_NEAR(region.light.standard_error, std::hypot(.2, .3), 1e-12);
  EXPECT_NEAR(region.traced.standard_error, std::hypot(.4, .2), 1e-12);
  EXPECT_EQ(region.light.pixels, 2u);
  EXPECT_EQ(layers.added[0].sets->regions[0].light.mean, 20) << "as it was by itself";
}

TEST(Turns, AnAdditionByPathsLeavesTheChecksOfTheSets) {
  FamilyLayers layers = make_layers(0, 10, .3, 0, 100);
  layers.sets = make_sets(make_region(10, .4, 11, .8));
  add_turn(layers, make_layers(0, 20, .6, 0, 50), {even(9), even(0)}, .5);
  EXPECT_EQ(layers.sets->regions[0].light.mean, 10);
  EXPECT_FLOAT_EQ(layers.indirect.values[0], 15);
}

TEST(Turns, AnotherRoomHasAnErrorOfItsOwn) {
  FamilyLayers layers = make_layers(1, 10, .3, .4, 100);
  exchange_room(layers, {even(9), even(.4f)}, {even(7), even(.1f)});
  EXPECT_FLOAT_EQ(layers.background.values[1], 7);
  EXPECT_NEAR(layers.standard_error.values[1], std::hypot(.3, .1), 1e-6);
  EXPECT_FLOAT_EQ(layers.indirect.values[1], 10);
}

}  // namespace
}  // namespace equilux
