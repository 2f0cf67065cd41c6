// What an experimenter reads between two subjects.
#include "experiment/status.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiment/session_outcome.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"
#include "tests/experiment/unprivileged.h"

namespace equilux {
namespace {

using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;

class Status : public ::testing::Test {
 protected:
  TemporaryFolder temporary_;
  StudyFolder folder_ = make_fake_study(temporary_.path());
};

TEST_F(Status, TellsCompleteUnfinishedAndAbortedSessionsApart) {
  {
    TrialLog log(folder_.responses(), true);
    answer_all(log, log.append_session(make_fake_session(0), make_fake_trials(3)), 3);
    log.append_answer(log.append_session(make_fake_session(1), make_fake_trials(3)), {0, Side::kLeft, 9}, 1,
                      1);
    log.append_event(log.append_session(make_fake_session(2), make_fake_trials(3)), "abort", 5,
                     "felt unwell");
    log.append_event(log.append_session(make_fake_session(3), make_fake_trials(3)), "interrupt", 5,
                     "the window was closed");
  }
  const std::string status = format_status(folder_);
  EXPECT_THAT(status, ContainsRegex("person +artifact +0 +P0 +complete +3/3"));
  EXPECT_THAT(status, ContainsRegex("person +artifact +1 +P1 +unfinished +1/3"));
  EXPECT_THAT(status, ContainsRegex("person +artifact +2 +P2 +aborted +0/3.*aborted: felt unwell"));
  EXPECT_THAT(status,
              ContainsRegex("person +artifact +3 +P3 +unfinished +0/3.*interrupted: the window was closed"));
}

TEST_F(Status, TellsWhatHappenedToTheScreen) {
  TrialLog log(folder_.responses(), true);
  const auto id = log.append_session(make_fake_session(), make_fake_trials(2));
  for (const char* kind : {"slow_frame", "focus_lost", "focus_gained", "slow_frame", "pause", "continue"})
    log.append_event(id, kind, 5);
  EXPECT_THAT(format_status(folder_), HasSubstr("Z  focus_lost 1, slow_frame 2\n"));
}

TEST_F(Status, CountsTooFastAnswersAndCatchTrials) {
  auto trials = make_fake_trials(4);
  trials[1].phase = trials[2].phase = trials[3].phase = Phase::kCatch;
  TrialLog log(folder_.responses(), true);
  log.append_session(make_fake_session(), trials);
  log.append_answer(1, {0, Side::kRight, 9, true}, 1, 1);
  log.append_answer(1, {1, trials[1].test_side, 9, true}, 2, 1);
  log.append_answer(1, {2, Side::kRight, 9}, 3, 1);  // wrong: it stood left
  EXPECT_THAT(format_status(folder_), ContainsRegex("unfinished +3/4 +2 +1/2 "));
}

TEST_F(Status, TellsTheNextIndexOfEachExperimentAndKind) {
  TrialLog log(folder_.responses(), true);
  for (const int index : {0, 1, 3}) log.append_session(make_fake_session(index), {});
  log.append_session(make_fake_session(0, SubjectKind::kPlanted, Experiment::kMaterial), {});
  EXPECT_THAT(format_status(folder_), HasSubstr("Next free index, artifact: person 2, planted 0.\n"
                                                "Next free index, material: person 0, planted 1.\n"));
}

TEST_F(Status, TellsTheStationByWhichAWithdrawalNamesExports) {
  TrialLog log(folder_.responses(), true);
  log.append_session(make_fake_session(0), {});
  EXPECT_THAT(format_status(folder_),
              HasSubstr("Station of this log: " + log.load_station().substr(0, 8) + ".\n"));
}

TEST_F(Status, TellsTheNextIndexOfTheStationThatTheLogIs) {
  TrialLog log(folder_.responses(), true);
  SessionRow row = make_fake_session(1);
  row.fields["lane"] = "2/3";
  log.append_session(row, {});
  EXPECT_THAT(format_status(folder_),
              AllOf(HasSubstr("Next free index, artifact: person 4.\n"),
                    HasSubstr("Station of this log: " + log.load_station().substr(0, 8) + ", 2/3.\n")));
}

TEST_F(Status, IsToldOfAFolderThatCanOnlyBeRead) {
  { TrialLog(folder_.responses(), true).append_session(make_fake_session(), {}); }
  const ReadOnlyFolder read_only(folder_.root);
  EXPECT_THAT(format_status(folder_), HasSubstr("P0"));
}

TEST(SessionOutcome, AnAbortCountsUntilTheSessionGoesOn) {
  const auto state = [](const std::vector<std::string>& kinds) {
    std::vector<EventRow> events;
    for (const std::string& kind : kinds) events.push_back({std::nullopt, kind, 0, "", "reason"});
    return find_outcome(SessionRow{}, {}, events).state;
  };
  EXPECT_EQ(state({}), SessionState::kUnfinished);
  EXPECT_EQ(state({"showing", "abort"}), SessionState::kAborted);
  EXPECT_EQ(state({"abort", "focus-lost"}), SessionState::kAborted) << "of the window, and not of going on";
  EXPECT_EQ(state({"abort", "resume"}), SessionState::kUnfinished);
  EXPECT_EQ(state({"abort", "resume", "showing", "abort"}), SessionState::kAborted);
  EXPECT_EQ(state({"showing", "interrupt"}), SessionState::kUnfinished) << "nobody ended it";
  EXPECT_EQ(state({"abort", "resume", "interrupt"}), SessionState::kUnfinished);
  EXPECT_EQ(state({"interrupt", "resume", "abort"}), SessionState::kAborted);
}

TEST(SessionOutcome, TellsWhatBrokeOffTheLastSittingUntilTheSessionGoesOn) {
  const auto interruption = [](const std::vector<std::string>& kinds) {
    std::vector<EventRow> events;
    for (const std::string& kind : kinds) events.push_back({std::nullopt, kind, 0, "", "why " + kind});
    return find_outcome(SessionRow{}, {}, events).interruption;
  };
  EXPECT_EQ(interruption({"showing"}), "");
  EXPECT_EQ(interruption({"showing", "interrupt"}), "why interrupt");
  EXPECT_EQ(interruption({"interrupt", "resume"}), "");
  EXPECT_EQ(interruption({"interrupt", "resume", "interrupt"}), "why interrupt");
}

TEST(DescribeUnfinished, TellsWhichSessionHowFarAndWhetherItWasEnded) {
  SessionRow row = make_fake_session(4);
  row.id = 7;
  std::vector<TrialRow> trials = make_fake_trials(3);
  trials[0].answer = Side::kLeft;
  std::vector<EventRow> events;
  EXPECT_EQ(describe_unfinished(row, trials, events),
            "Goes on with session 7, begun 2026-01-31T12:00:00.000Z: 1 of 3 answered. Consent and questions "
            "are not asked again.");
  events.push_back({std::nullopt, "abort", 1, "", "felt sick"});
  EXPECT_THAT(describe_unfinished(row, trials, events),
              testing::HasSubstr("answered, ended early (felt sick)."));
}

}  // namespace
}  // namespace equilux
