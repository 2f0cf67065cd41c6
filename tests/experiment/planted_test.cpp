// Planted subjects see what was planted, and their draws depend on nothing else than they say.
#include "experiment/planted.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>

#include "experiment/schedule.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"

namespace equilux {
namespace {

const Column kColumn = make_fake_trials(1)[0].cell.column;

Truth make_truth(double lapse_rate, double side_bias, int artifact_free_from, int material_same_to) {
  Truth truth;
  truth.lapse_rate = lapse_rate;
  truth.side_bias = side_bias;
  truth.by_column[kColumn] = {artifact_free_from, material_same_to};
  return truth;
}

TrialRow make_trial(int number, int level, Side side) {
  TrialRow trial;
  trial.number = number;
  trial.cell = {kColumn, level, false};
  trial.test_side = side;
  return trial;
}

TEST(Planted, SeesArtifactsOnTheLessClampedSide) {
  const Truth truth = make_truth(0, 0.5, 4, 7);
  for (int level = 0; level < kClampLevelCount; ++level) {
    EXPECT_EQ(is_visible(truth, Experiment::kArtifact, {kColumn, level, false}), level < 4) << level;
    EXPECT_EQ(is_visible(truth, Experiment::kMaterial, {kColumn, level, false}), level > 7) << level;
  }
}

TEST(Planted, CanSeeSomethingAtEveryLevelOrAtNone) {
  for (int level = 0; level < kClampLevelCount; ++level) {
    const Cell cell{kColumn, level, false};
    EXPECT_TRUE(is_visible(make_truth(0, 0.5, 11, -1), Experiment::kArtifact, cell));
    EXPECT_TRUE(is_visible(make_truth(0, 0.5, 11, -1), Experiment::kMaterial, cell));
    EXPECT_FALSE(is_visible(make_truth(0, 0.5, 0, 10), Experiment::kArtifact, cell));
    EXPECT_FALSE(is_visible(make_truth(0, 0.5, 0, 10), Experiment::kMaterial, cell));
  }
}

// Seed 21; 400 trials. Without lapses every visible trial is correct: exact.
TEST(Planted, IsAlwaysCorrectWhereVisibleWithoutLapses) {
  const Truth truth = make_truth(0, 0.5, 6, 6);
  for (int number = 0; number < 400; ++number) {
    const Side side = number % 3 == 0 ? Side::kRight : Side::kLeft;
    EXPECT_EQ(
        choose_planted_side(truth, {21, Experiment::kArtifact, 0}, make_trial(number, number % 6, side)),
        side);
    EXPECT_EQ(
        choose_planted_side(truth, {21, Experiment::kMaterial, 0}, make_trial(number, 7 + number % 4, side)),
        side);
  }
}

// |k - n p| within z standard deviations: the two-sided binomial test in its normal form.
void expect_binomial(int count, int trials, double probability, double z) {
  const double sigma = std::sqrt(trials * probability * (1 - probability));
  EXPECT_NEAR(count, trials * probability, z * sigma + 0.5);
}

// Seed 22; 10,000 guesses for each bias, of 100 subjects; level 0.01 % for each (two-sided, 3.89 sigma).
TEST(Planted, GuessesLeftWithItsBias) {
  for (const double bias : {0.0, 0.3, 0.5, 0.8, 1.0}) {
    const Truth truth = make_truth(0, bias, 0, 10);
    int left = 0;
    for (int i = 0; i < 10000; ++i) {
      const PlantedSubject subject{22, Experiment::kArtifact, i / 100};
      left += choose_planted_side(truth, subject, make_trial(i % 100, 5, Side::kRight)) == Side::kLeft;
    }
    expect_binomial(left, 10000, bias, 3.89);
  }
}

// Seed 23; 10,000 visible trials, test picture right, bias 1, so that left means lapse; level 0.01 %.
TEST(Planted, LapsesAtItsRate) {
  for (const double rate : {0.02, 0.25, 1.0}) {
    const Truth truth = make_truth(rate, 1.0, 11, -1);
    int lapses = 0;
    for (int i = 0; i < 10000; ++i) {
      const PlantedSubject subject{23, Experiment::kMaterial, i / 100};
      lapses += choose_planted_side(truth, subject, make_trial(i % 100, 5, Side::kRight)) == Side::kLeft;
    }
    expect_binomial(lapses, 10000, rate, 3.89);
  }
}

// Seed 24; lapse and guess are drawn from two streams: among lapses, guesses keep their bias. About 5,000
// lapses of 10,000 trials; level 0.01 %.
TEST(Planted, GuessesAsOftenLeftAfterALapse) {
  const Truth truth = make_truth(0.5, 0.5, 11, -1);
  int wrong = 0;
  for (int i = 0; i < 10000; ++i) {
    const PlantedSubject subject{24, Experiment::kArtifact, i / 100};
    wrong += choose_planted_side(truth, subject, make_trial(i % 100, 5, Side::kRight)) == Side::kLeft;
  }
  expect_binomial(wrong, 10000, 0.25, 3.89);
}

std::vector<Side> guess_all(const PlantedSubject& subject) {
  const Truth truth = make_truth(0, 0.5, 0, 10);
  std::vector<Side> sides;
  for (int number = 0; number < 64; ++number) {
    sides.push_back(choose_planted_side(truth, subject, make_trial(number, 5, Side::kLeft)));
  }
  return sides;
}

// Seeds and indices as written; 64 guesses each: two lists agree by chance once in 2^64.
TEST(Planted, DrawsFromSeedExperimentIndexAndTrialAlone) {
  const PlantedSubject subject{31, Experiment::kArtifact, 2};
  const auto sides = guess_all(subject);
  EXPECT_EQ(guess_all(subject), sides);
  EXPECT_NE(guess_all({32, Experiment::kArtifact, 2}), sides);
  EXPECT_NE(guess_all({31, Experiment::kMaterial, 2}), sides);
  EXPECT_NE(guess_all({31, Experiment::kArtifact, 3}), sides);
}

TEST(Planted, DrawsTheSameForAnyPictureInThatPlace) {
  const Truth truth = make_truth(0.5, 0.5, 6, 6);
  const PlantedSubject subject{33, Experiment::kArtifact, 0};
  for (int number = 0; number < 100; ++number) {
    TrialRow plain = make_trial(number, 8, Side::kLeft);
    TrialRow dressed = make_trial(number, 10, Side::kRight);
    dressed.test_key = "other";
    dressed.pair_key = "keys";
    dressed.answer = Side::kRight;
    EXPECT_EQ(choose_planted_side(truth, subject, plain), choose_planted_side(truth, subject, dressed));
  }
}

// Seed 34; 20,000 response times. The median's standard error is 1.2533 x 0.405 / sqrt(20000) = 0.36 % in the
// logarithm: 4 of them are allowed.
TEST(Planted, TakesAboutOneAndAHalfSeconds) {
  std::vector<double> seconds;
  for (int i = 0; i < 20000; ++i) {
    const PlantedSubject subject{34, Experiment::kArtifact, i / 100};
    seconds.push_back(1e-9 * static_cast<double>(draw_planted_response_time_ns(subject, i % 100)));
  }
  std::sort(seconds.begin(), seconds.end());
  EXPECT_GE(seconds.front(), 0.2);
  EXPECT_LE(seconds.back(), 30.0);
  EXPECT_NEAR(std::log(seconds[10000] / 1.5), 0, 0.0144);
}

}  // namespace
}  // namespace equilux
