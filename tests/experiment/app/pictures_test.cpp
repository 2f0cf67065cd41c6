// In what order a trial's pictures are read.
#include "experiment/app/pictures.h"

#include <gtest/gtest.h>

#include "tests/experiment/fake_trials.h"

namespace equilux {
namespace {

using Keys = std::vector<std::string>;

// Were the test picture read first wherever it stands, a large file would tell its side by a later onset.
TEST(PicturesTest, AreReadByTheirPlacesAndNotByWhatTheyAre) {
  for (TrialRow trial : make_fake_trials(4)) {
    for (const std::string upper : {"", "G1-MR-ind-ref-v0"}) {
      trial.upper_key = upper;
      const bool is_left = trial.test_side == Side::kLeft;
      Keys keys{is_left ? trial.test_key : trial.pair_key, is_left ? trial.pair_key : trial.test_key};
      if (!upper.empty()) keys.push_back(upper);
      EXPECT_EQ(list_keys_by_place(trial), keys);
      std::swap(trial.test_key, trial.pair_key);
      trial.test_side = is_left ? Side::kRight : Side::kLeft;
      EXPECT_EQ(list_keys_by_place(trial), keys) << "the same places, the other roles";
      std::swap(trial.test_key, trial.pair_key);
      trial.test_side = is_left ? Side::kLeft : Side::kRight;
    }
  }
}

}  // namespace
}  // namespace equilux
