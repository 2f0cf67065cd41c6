// What tests of the window's sessions share: a small study, where its pictures must stand, and answers.
#pragma once

#include <gtest/gtest.h>

#include "tests/e2e/small_study.h"
#include "tests/e2e/watched_session.h"
#include "tests/experiment/fake_study.h"

namespace equilux {

// For a screen of 1280 x 1024. The block of three pictures and question is 510 or 930 pixels high, in the
// middle.
inline constexpr ScreenPlan kSmallPlan{280, 210, {352, 557}, {648, 557}, {500, 257}, 467, 557, {}};
inline constexpr ScreenPlan kPaperPlan{560, 420, {72, 557}, {648, 557}, {360, 47}, 467, 557, {}};

class AppTest : public testing::Test {
 protected:
  StudyFolder make_study(const ScreenPlan& plan) {
    return make_small_study(folder_.path() / "study", plan.picture_width, plan.picture_height);
  }
  static std::vector<std::string> arguments_for(const StudyFolder& folder, const std::string& experiment) {
    return {folder.root.string(), "--experiment", experiment, "--participant", "P01"};
  }

  TemporaryFolder folder_;
};

// Sides that do not depend on what is right.
inline Side choose_side(int trial) { return trial % 3 == 0 ? Side::kRight : Side::kLeft; }

// Answers the trials from `first` to `end`, clicks and keys in turn.
inline void answer_all(WatchedSession& session, const std::vector<TrialRow>& trials, int first, int end) {
  for (int i = first; i < end; ++i) {
    session.wait_for_trial(trials[static_cast<std::size_t>(i)]);
    if (testing::Test::HasFatalFailure()) return;
    if (i % 2 == 0) {
      session.answer_by_click(choose_side(i));
    } else {
      session.answer_by_key(choose_side(i));
    }
  }
}

}  // namespace equilux
