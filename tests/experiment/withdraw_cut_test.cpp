// A withdrawal that is cut off at any change it makes has erased all or nothing, and once more finishes it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiment/trial_log.h"
#include "experiment/withdraw.h"
#include "tests/experiment/crashed_disk.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"
#include "tests/experiment/old_log.h"
#include "tests/experiment/recording_vfs.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

const std::string kCode = "Withdrawing-4711";
const std::string kMarker = "a thing that only this person said";

class WithdrawCut : public ::testing::Test {
 protected:
  // A log that was of schema 1 once, so that a copy is kept; two sessions of the one who withdraws.
  WithdrawCut() {
    make_old_log(path_, kCode, kMarker);
    TrialLog log(path_);
    SessionRow row = make_fake_session(0, SubjectKind::kPerson, Experiment::kMaterial);
    row.participant = kCode;
    row.fields = {{"remark", kMarker}};
    answer_all(log, log.append_session(row, make_fake_trials(6)), 6);
    answer_all(log, log.append_session(make_fake_session(7), make_fake_trials(6)), 6);
  }
  bool has_text(const std::string& text) const {
    for (const auto& entry : fs::directory_iterator(after_.path())) {
      if (read_bytes(entry.path()).find(text) != std::string::npos) return true;
    }
    return false;
  }
  bool has_bytes() const { return has_text(kCode) || has_text(kMarker); }

  // Of what a cut left: all or nothing; and everything is gone after a second withdrawal.
  void check_cut(std::size_t step) {
    {
      const TrialLog log(cut_path_);
      const auto sessions = log.load_sessions();
      const auto mine = std::count_if(sessions.begin(), sessions.end(),
                                      [](const SessionRow& row) { return row.participant == kCode; });
      EXPECT_TRUE(mine == 0 || mine == 2) << mine << " sessions at step " << step;
      EXPECT_EQ(log.count_withdrawn(), mine == 0 ? 1 : 0) << "step " << step;
      ++(mine == 0 ? erased_ : whole_);
    }
    if (has_bytes()) ++unfinished_;
    EXPECT_NO_THROW(plan_withdrawal(cut_path_, kCode)) << "step " << step;
    withdraw_participant(cut_path_, kCode);
    EXPECT_FALSE(has_bytes()) << "step " << step;
    const TrialLog log(cut_path_);
    EXPECT_EQ(log.load_sessions().size(), 2u);
    EXPECT_EQ(log.load_trials(4).size(), 6u);
    EXPECT_EQ(log.count_withdrawn(), 1);
  }

  TemporaryFolder live_, after_;
  fs::path path_ = live_.path() / "responses.sqlite", cut_path_ = after_.path() / "responses.sqlite";
  int whole_ = 0, erased_ = 0, unfinished_ = 0;
};

// Seed 72: the sectors that a torn write leaves. Every step of a withdrawal, as a kill and as power cuts
// leave it.
TEST_F(WithdrawCut, AtAnyWriteOrSyncHasErasedAllOrNothingAndCanBeFinished) {
  CrashedDisk disk(live_.path());
  std::vector<DiskStep> steps;
  {
    RecordingVfs recording;
    withdraw_participant(path_, kCode);
    steps = recording.steps();
  }
  RandomStream random(72, "withdraw cut", 0);
  int cuts = 0;
  for (std::size_t step = 0; step <= steps.size(); ++step) {
    for (const Unsynced unsynced : {Unsynced::kLost, Unsynced::kKept, Unsynced::kTorn}) {
      disk.leave(after_.path(), unsynced, random);
      check_cut(step);
      ++cuts;
    }
    if (step < steps.size()) disk.take(steps[step]);
  }
  RecordProperty("cuts", cuts);
  RecordProperty("cuts_that_had_erased_nothing", whole_);
  RecordProperty("cuts_that_left_bytes", unfinished_);
  EXPECT_GE(whole_, 20) << "cuts must fall before the commit";
  EXPECT_GE(erased_, 20) << "and after it";
  EXPECT_GT(unfinished_, whole_) << "and before the files are rewritten";
}

}  // namespace
}  // namespace equilux
