// Practice, catch trials and the familiarisation over the studies that come along.
#include "experiment/extra_trials.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <set>

#include "tests/experiment/fake_study.h"

namespace equilux {
namespace {

using ::testing::Contains;
using ::testing::IsEmpty;
using ::testing::SizeIs;

SessionProtocol make_protocol(int practice, int catches) {
  SessionProtocol protocol;
  protocol.practice_trials = practice;
  if (catches > 0) protocol.catch_trials = CatchTrials{catches, catches};
  return protocol;
}

class ExtraTrials : public ::testing::TestWithParam<std::tuple<std::string, Experiment>> {
 protected:
  std::vector<TrialRow> make_counted(std::int64_t index) const {
    return make_schedule(study_, experiment_, cells_, SubjectKind::kPerson, 100 + index, index);
  }
  std::vector<TrialRow> make(const SessionProtocol& protocol, std::int64_t index) const {
    return add_extra_trials(make_counted(index), study_, protocol, experiment_, SubjectKind::kPerson,
                            100 + index, index);
  }

  Study study_ = load_protocol(std::get<0>(GetParam()));
  Experiment experiment_ = std::get<1>(GetParam());
  std::vector<Cell> cells_ = enumerate_artifact_cells(study_, load_windows(study_.windows_path, study_));
};

INSTANTIATE_TEST_SUITE_P(Schedule, ExtraTrials,
                         ::testing::Combine(::testing::Values("pocket", "paper", "validation",
                                                              "normalisation"),
                                            ::testing::Values(Experiment::kArtifact, Experiment::kMaterial)),
                         [](const auto& chosen) {
                           return std::get<0>(chosen.param) + "_" +
                                  format_experiment(std::get<1>(chosen.param));
                         });

bool is_same_pair(const TrialRow& a, const TrialRow& b) {
  return a.test_key == b.test_key && a.pair_key == b.pair_key && a.upper_key == b.upper_key &&
         a.test_side == b.test_side;
}

// Subjects 0 to 9, seeds 100 to 109.
TEST_P(ExtraTrials, LeaveTheCountedTrialsAndTheirOrderAlone) {
  for (std::int64_t index = 0; index < 10; ++index) {
    const auto counted = make_counted(index), all = make(make_protocol(5, 6), index);
    ASSERT_EQ(all.size(), counted.size() + 11);
    std::size_t next = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      EXPECT_EQ(all[i].number, static_cast<int>(i));
      EXPECT_EQ(all[i].phase == Phase::kPractice, i < 5);
      if (all[i].phase != Phase::kMain) continue;
      ASSERT_LT(next, counted.size());
      EXPECT_TRUE(is_same_pair(all[i], counted[next++]));
    }
    EXPECT_EQ(next, counted.size());
  }
}

TEST_P(ExtraTrials, CatchTrialsComeOneInEachStretch) {
  for (std::int64_t index = 0; index < 10; ++index) {
    const auto all = make(make_protocol(0, 4), index);
    std::size_t counted = 0, catches = 0;
    const std::size_t total = all.size() - 4;
    for (const TrialRow& trial : all) {
      if (trial.phase == Phase::kMain) {
        ++counted;
        continue;
      }
      EXPECT_EQ(trial.phase, Phase::kCatch);
      EXPECT_GE(counted, total * catches / 4);
      EXPECT_LE(counted, total * (catches + 1) / 4);
      ++catches;
    }
    EXPECT_EQ(catches, 4u);
  }
}

TEST_P(ExtraTrials, ShowTheMostObviousLevelOfTheFewestVplsThatAreNotCounted) {
  const std::set<Cell> counted(cells_.begin(), cells_.end());
  for (const TrialRow& trial : make(make_protocol(9, 9), 3)) {
    if (trial.phase == Phase::kMain) continue;
    EXPECT_EQ(trial.cell.clamp_level, experiment_ == Experiment::kArtifact ? study_.clamp_levels.front()
                                                                           : study_.clamp_levels.back());
    for (const Column& column : enumerate_columns(study_)) {
      if (column.object != trial.cell.column.object) continue;
      if (counted.contains({column, trial.cell.clamp_level, study_.normalise})) continue;
      EXPECT_LE(trial.cell.column.vpl_count, column.vpl_count);
    }
    EXPECT_NE(trial.test_key, trial.pair_key);
  }
}

// All columns counted at every other level and the last, as pruning keeps them, and one column whole.
TEST_P(ExtraTrials, ShowNothingThatIsCounted) {
  const Column whole = enumerate_columns(study_).front();
  cells_.clear();
  for (const Cell& cell : enumerate_cells(study_)) {
    if (cell.clamp_level % 2 == 0 || cell.column == whole) cells_.push_back(cell);
  }
  SessionProtocol protocol = make_protocol(20, 20);
  protocol.examples = 5;
  std::set<std::string> counted;
  for (const Cell& cell : cells_)
    counted.insert({format_key(Condition{cell, 0}), format_key(Condition{cell, 1})});
  for (const TrialRow& trial : make(protocol, 3)) {
    if (trial.phase == Phase::kMain) continue;
    EXPECT_FALSE(counted.contains(trial.test_key)) << trial.test_key;
    EXPECT_EQ(trial.cell.clamp_level, experiment_ == Experiment::kArtifact ? 1 : 9) << "the next best";
    if (trial.cell.column.object == whole.object) {
      EXPECT_GT(trial.cell.column.vpl_count, whole.vpl_count);
    }
  }
  for (const std::string& key : enumerate_extra_keys(study_, protocol, experiment_, cells_))
    EXPECT_FALSE(counted.contains(key)) << key;
}

// Better a picture that is counted than no practice.
TEST_P(ExtraTrials, ShowTheMostObviousWhereEverythingIsCounted) {
  const auto all = enumerate_obvious_cells(study_, experiment_, enumerate_cells(study_));
  EXPECT_EQ(all, enumerate_obvious_cells(study_, experiment_, {}));
  EXPECT_EQ(all.size(), enumerate_objects(study_).size());
}

TEST_P(ExtraTrials, BalanceSidesAndViews) {
  std::map<std::pair<Side, char>, int> counts;
  for (const TrialRow& trial : make(make_protocol(8, 0), 0)) {
    if (trial.phase == Phase::kPractice) ++counts[{trial.test_side, trial.test_key.back()}];
  }
  EXPECT_THAT(counts, SizeIs(4));
  for (const auto& [combo, count] : counts) EXPECT_EQ(count, 2);
}

TEST_P(ExtraTrials, ShowOnlyWhatIsListedBeforehand) {
  SessionProtocol protocol = make_protocol(8, 8);
  protocol.shows_objects = true;
  protocol.examples = 3;
  const auto keys = enumerate_extra_keys(study_, protocol, experiment_, cells_);
  for (std::int64_t index = 0; index < 10; ++index) {
    for (const TrialRow& trial : make(protocol, index)) {
      if (trial.phase == Phase::kMain) continue;
      EXPECT_THAT(keys, Contains(trial.test_key));
      EXPECT_THAT(keys, Contains(trial.pair_key));
      if (!trial.upper_key.empty()) {
        EXPECT_THAT(keys, Contains(trial.upper_key));
      }
    }
  }
  for (const FamiliarPage& page : enumerate_familiar_pages(study_, protocol, experiment_, cells_))
    EXPECT_THAT(keys, Contains(page.left_key));
  EXPECT_THAT(enumerate_extra_keys(study_, {}, experiment_, cells_), IsEmpty());
}

TEST_P(ExtraTrials, DifferBetweenSubjectsAndRepeatForOne) {
  std::set<std::string> orders;
  for (std::int64_t index = 0; index < 8; ++index) {
    std::string order, again;
    for (const TrialRow& trial : make(make_protocol(4, 4), index)) {
      if (trial.phase != Phase::kMain)
        order += fmt::format("{} {} {};", trial.number, trial.test_key, trial.pair_key);
    }
    for (const TrialRow& trial : make(make_protocol(4, 4), index)) {
      if (trial.phase != Phase::kMain)
        again += fmt::format("{} {} {};", trial.number, trial.test_key, trial.pair_key);
    }
    EXPECT_EQ(order, again);
    orders.insert(order);
  }
  EXPECT_GE(orders.size(), 7u);
}

TEST_P(ExtraTrials, TheFamiliarisationShowsEveryObjectThenLabelledPairs) {
  SessionProtocol protocol;
  protocol.shows_objects = true;
  protocol.examples = 2;
  const auto pages = enumerate_familiar_pages(study_, protocol, experiment_, cells_);
  const std::size_t objects = enumerate_objects(study_).size();
  ASSERT_EQ(pages.size(), objects + 2);
  std::set<std::string> shown;
  for (std::size_t i = 0; i < pages.size(); ++i) {
    EXPECT_EQ(pages[i].right_key.empty(), i < objects);
    if (i < objects) shown.insert(pages[i].left_key);
  }
  EXPECT_EQ(shown.size(), objects);
}

}  // namespace
}  // namespace equilux
