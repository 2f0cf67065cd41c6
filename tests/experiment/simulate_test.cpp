// Planted subjects through whole studies: the log they leave, however often and in whatever steps.
#include "experiment/simulate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>

#include "base/error.h"
#include "experiment/open_session.h"
#include "experiment/planted.h"
#include "experiment/withdraw.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/raw_database.h"

namespace equilux {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

SimulateParams params_of(Experiment experiment, int subjects, std::uint64_t seed = 5) {
  SimulateParams params;
  params.experiment = experiment;
  params.subjects = subjects;
  params.seed = seed;
  return params;
}

void expect_counts(const SimulateCounts& counts, int kept, int resumed, int added) {
  EXPECT_EQ(counts.kept, kept);
  EXPECT_EQ(counts.resumed, resumed);
  EXPECT_EQ(counts.added, added);
}

class Simulate : public ::testing::Test {
 protected:
  TemporaryFolder first_, second_;
  StudyFolder folder_ = make_fake_study(first_.path());
  StudyFolder other_ = make_fake_study(second_.path());
};

TEST_F(Simulate, FinishesEverySessionItAdds) {
  expect_counts(simulate_subjects(folder_, params_of(Experiment::kArtifact, 3)), 0, 0, 3);
  const TrialLog log(folder_.responses());
  const auto sessions = log.load_sessions();
  ASSERT_EQ(sessions.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(sessions[i].complete);
    EXPECT_EQ(sessions[i].kind, SubjectKind::kPlanted);
    EXPECT_EQ(sessions[i].subject_index, static_cast<std::int64_t>(i));
    EXPECT_EQ(sessions[i].participant, fmt::format("planted-5-{}", i));
    EXPECT_EQ(log.load_trials(sessions[i].id).size(), 32u);
  }
}

TEST_F(Simulate, ChangesNothingWhenRunAgain) {
  simulate_subjects(folder_, params_of(Experiment::kArtifact, 3));
  const auto content = load_whole_content(folder_.responses());
  expect_counts(simulate_subjects(folder_, params_of(Experiment::kArtifact, 3)), 3, 0, 0);
  EXPECT_EQ(load_whole_content(folder_.responses()), content);
}

TEST_F(Simulate, GivesTheSameInStepsAsAtOnce) {
  expect_counts(simulate_subjects(folder_, params_of(Experiment::kArtifact, 4)), 0, 0, 4);
  expect_counts(simulate_subjects(folder_, params_of(Experiment::kArtifact, 12)), 4, 0, 8);
  simulate_subjects(other_, params_of(Experiment::kArtifact, 12));
  EXPECT_EQ(load_shared_content(folder_.responses()), load_shared_content(other_.responses()));
  EXPECT_EQ(load_events(folder_.responses()), load_events(other_.responses()));
}

TEST_F(Simulate, KeepsSeedsApart) {
  simulate_subjects(folder_, params_of(Experiment::kArtifact, 2, 5));
  expect_counts(simulate_subjects(folder_, params_of(Experiment::kArtifact, 3, 6)), 0, 0, 3);
  const auto sessions = TrialLog(folder_.responses()).load_sessions();
  ASSERT_EQ(sessions.size(), 5u);
  EXPECT_EQ(sessions[2].participant, "planted-6-2");
  EXPECT_EQ(sessions[2].subject_index, 2);
}

// Its index is free again, its code is not.
TEST_F(Simulate, GoesOnWithAnotherCodeAfterAWithdrawal) {
  const SimulateParams params = params_of(Experiment::kArtifact, 3);
  simulate_subjects(folder_, params);
  const auto trials = TrialLog(folder_.responses()).load_trials(2);
  for (const auto& [code, next] :
       {std::pair{"planted-5-1", "planted-5-1-2"}, {"planted-5-1-2", "planted-5-1-3"}}) {
    withdraw_participant(folder_.responses(), code);
    expect_counts(simulate_subjects(folder_, params), 2, 0, 1);
    const TrialLog log(folder_.responses());
    const SessionRow row = log.load_sessions().back();
    EXPECT_EQ(row.participant, next);
    EXPECT_EQ(row.subject_index, 1);
    EXPECT_TRUE(row.complete);
    const auto again = log.load_trials(row.id);
    ASSERT_EQ(again.size(), trials.size());
    for (std::size_t i = 0; i < trials.size(); ++i) EXPECT_EQ(again[i].answer, trials[i].answer) << i;
  }
  expect_counts(simulate_subjects(folder_, params), 3, 0, 0);
  save_fake_selection(folder_, SubjectKind::kPlanted, {5});
  simulate_subjects(folder_, params_of(Experiment::kMaterial, 3));
  EXPECT_EQ(RawDatabase(folder_.responses()).value("SELECT count(*) FROM participant"), "3");
}

struct Interruption {};

TEST_F(Simulate, LeavesTheSameAnswersAfterAnInterruptionAtAnyTrial) {
  simulate_subjects(other_, params_of(Experiment::kArtifact, 2));
  for (const int stop : {0, 1, 17, 30, 31}) {
    TemporaryFolder again;
    const StudyFolder folder = make_fake_study(again.path());
    SimulateParams params = params_of(Experiment::kArtifact, 2);
    params.acknowledge = [&](std::int64_t, int trial) {
      if (trial == stop) throw Interruption{};
    };
    EXPECT_THROW(simulate_subjects(folder, params), Interruption);
    expect_counts(simulate_subjects(folder, params_of(Experiment::kArtifact, 2)), 0, 1, 1);
    EXPECT_EQ(load_shared_content(folder.responses()), load_shared_content(other_.responses())) << stop;
    const RawDatabase database(folder.responses());
    EXPECT_EQ(database.value("SELECT count(*) FROM event WHERE kind = 'resume'"), "1");
    const std::string shown_twice =
        "SELECT count(*) FROM (SELECT 1 FROM event WHERE kind = 'showing' GROUP BY session, trial"
        " HAVING count(*) = 2)";
    EXPECT_EQ(database.value(shown_twice), stop == 31 ? "0" : "1") << "the waiting pair is shown again";
  }
}

// k of n for each cell.
std::map<Cell, std::pair<int, int>> tally(const StudyFolder& folder, Experiment experiment) {
  std::map<Cell, std::pair<int, int>> counts;
  for (const AnswerRow& row : TrialLog(folder.responses()).load_answers(SubjectKind::kPlanted, experiment)) {
    counts[row.cell].first += row.correct ? 1 : 0;
    ++counts[row.cell].second;
  }
  return counts;
}

// No lapses, and guessers who always press left: with 12 subjects, six of them with the test picture left, a
// cell has 12 of 12 where the difference is visible and 6 of 12 where not. Exact; seed 5.
TEST_F(Simulate, BringsBackWhatWasPlantedCellByCell) {
  save_fake_truth(folder_, 0.0, 1.0, "C4", "C5", folder_.truth());
  const Truth truth = load_truth(folder_.truth(), load_folder_study(folder_));
  simulate_subjects(folder_, params_of(Experiment::kArtifact, 12));
  save_fake_selection(folder_, SubjectKind::kPlanted, {3, 4, 5, 6, 8, 10});
  simulate_subjects(folder_, params_of(Experiment::kMaterial, 12));
  for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
    const auto counts = tally(folder_, experiment);
    EXPECT_EQ(counts.size(), experiment == Experiment::kArtifact ? 32u : 48u);
    for (const auto& [cell, count] : counts) {
      EXPECT_EQ(count.second, 12) << format_key(cell);
      EXPECT_EQ(count.first, is_visible(truth, experiment, cell) ? 12 : 6) << format_key(cell);
    }
  }
}

TEST_F(Simulate, SharesPlantedParticipantsBetweenTheExperiments) {
  simulate_subjects(folder_, params_of(Experiment::kArtifact, 2));
  save_fake_selection(folder_, SubjectKind::kPlanted, {5});
  simulate_subjects(folder_, params_of(Experiment::kMaterial, 3));
  EXPECT_EQ(RawDatabase(folder_.responses()).value("SELECT count(*) FROM participant"), "3");
}

TEST_F(Simulate, WantsASelectionForTheMaterialExperiment) {
  simulate_subjects(folder_, params_of(Experiment::kArtifact, 1));
  EXPECT_THAT([&] { simulate_subjects(folder_, params_of(Experiment::kMaterial, 1)); },
              ThrowsMessage<InputError>(
                  HasSubstr("`equilux-analyze prune " + folder_.root.string() + " --kind planted`")));
}

// A log locks the pictures of its folder, so none may be left by a session that could not begin.
TEST_F(Simulate, MakesNoLogWhereNoSessionCanBegin) {
  EXPECT_THROW(simulate_subjects(folder_, params_of(Experiment::kMaterial, 1)), InputError);
  save_fake_selection(folder_, SubjectKind::kPlanted, {5});
  std::filesystem::remove_all(folder_.picture_folder());
  EXPECT_THROW(simulate_subjects(folder_, params_of(Experiment::kArtifact, 1)), InputError);
  EXPECT_THROW(simulate_subjects(folder_, params_of(Experiment::kMaterial, 1)), InputError);
  EXPECT_FALSE(std::filesystem::exists(folder_.responses()));
}

TEST_F(Simulate, WantsASelectionOfTodaysArtifactAnswers) {
  simulate_subjects(folder_, params_of(Experiment::kArtifact, 1));
  save_fake_selection(folder_, SubjectKind::kPlanted, {5});
  simulate_subjects(folder_, params_of(Experiment::kArtifact, 2));
  EXPECT_THAT([&] { simulate_subjects(folder_, params_of(Experiment::kMaterial, 1)); },
              ThrowsMessage<InputError>(HasSubstr("/answers_digest")));
}

TEST_F(Simulate, GoesOnWithASelectionOnceItIsUsed) {
  simulate_subjects(folder_, params_of(Experiment::kArtifact, 1));
  save_fake_selection(folder_, SubjectKind::kPlanted, {5});
  simulate_subjects(folder_, params_of(Experiment::kMaterial, 1));
  simulate_subjects(folder_, params_of(Experiment::kArtifact, 2));
  expect_counts(simulate_subjects(folder_, params_of(Experiment::kMaterial, 2)), 1, 0, 1);
}

TEST_F(Simulate, RefusesAnotherTruthInTheSameFolder) {
  simulate_subjects(folder_, params_of(Experiment::kArtifact, 1));
  SimulateParams params = params_of(Experiment::kArtifact, 2);
  params.truth = folder_.root / "other-truth.json";
  save_fake_truth(folder_, 0.0, 0.5, "C4", "C5", *params.truth);
  EXPECT_THAT([&] { simulate_subjects(folder_, params); }, ThrowsMessage<InputError>(HasSubstr("truth")));
}

}  // namespace
}  // namespace equilux
