// The rules of pairing and balance, as invariants over studies, seeds and subjects.
#include "experiment/schedule.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>

#include "tests/experiment/fake_study.h"
#include "tests/experiment/schedule_checks.h"

namespace equilux {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<Cell> artifact_cells(const Study& study) {
  return enumerate_artifact_cells(study, load_windows(study.windows_path, study));
}

// Every second level: about what pruning leaves. `dropped` cells fewer, so that counts leave all rests.
std::vector<Cell> material_cells(const Study& study, std::size_t dropped) {
  std::vector<Cell> cells;
  for (const Cell& cell : enumerate_cells(study)) {
    if (cell.clamp_level % 2 == 0) cells.push_back(cell);
  }
  cells.resize(cells.size() - dropped);
  return cells;
}

std::vector<Cell> cells_of(const Study& study, Experiment experiment, std::size_t dropped = 0) {
  return experiment == Experiment::kArtifact ? artifact_cells(study) : material_cells(study, dropped);
}

std::vector<Cell> sorted_cells(const std::vector<TrialRow>& trials) {
  std::vector<Cell> cells;
  for (const TrialRow& trial : trials) cells.push_back(trial.cell);
  std::sort(cells.begin(), cells.end());
  return cells;
}

class EveryStudy : public ::testing::TestWithParam<std::tuple<std::string, Experiment>> {
 protected:
  Study study_ = load_protocol(std::get<0>(GetParam()));
  Experiment experiment_ = std::get<1>(GetParam());
};

INSTANTIATE_TEST_SUITE_P(Schedule, EveryStudy,
                         ::testing::Combine(::testing::Values("pocket", "paper", "validation",
                                                              "normalisation"),
                                            ::testing::Values(Experiment::kArtifact, Experiment::kMaterial)),
                         [](const auto& chosen) {
                           return std::get<0>(chosen.param) + "_" +
                                  format_experiment(std::get<1>(chosen.param));
                         });

// Seeds 1 to 6 of the study, 30 subjects each, session seeds 100 to 129; exact, so there is no level.
TEST_P(EveryStudy, KeepsTheRulesOfPairingAndBalance) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    study_.seed = seed;
    const auto cells = cells_of(study_, experiment_, seed % 4);
    BalanceOverSubjects balance(study_, experiment_);
    for (std::int64_t index = 0; index < 30; ++index) {
      const auto trials = make_schedule(study_, experiment_, cells, SubjectKind::kPerson,
                                        100 + static_cast<std::uint64_t>(index), index);
      ASSERT_THAT(check_pairing(study_, experiment_, trials), IsEmpty()) << "seed " << seed;
      ASSERT_THAT(check_session_balance(trials), IsEmpty()) << "seed " << seed << ", index " << index;
      ASSERT_THAT(balance.add(trials), IsEmpty()) << "seed " << seed << ", index " << index;
    }
  }
}

TEST_P(EveryStudy, ShowsEachCellOnceToEachSubject) {
  auto cells = cells_of(study_, experiment_);
  std::sort(cells.begin(), cells.end());
  for (std::int64_t index = 0; index < 5; ++index) {
    const auto trials = make_schedule(study_, experiment_, cells, SubjectKind::kPlanted, 7, index);
    EXPECT_EQ(sorted_cells(trials), cells);
  }
}

// 40 subjects: eight blocks of the five materials that there are at most, ten of view and side.
TEST_P(EveryStudy, ShowsInTheEndExactlyWhatItMayShow) {
  const auto cells = cells_of(study_, experiment_);
  std::set<std::string> shown;
  for (std::int64_t index = 0; index < 40; ++index) {
    const auto keys =
        enumerate_shown(make_schedule(study_, experiment_, cells, SubjectKind::kPerson, 3, index));
    EXPECT_TRUE(std::is_sorted(keys.begin(), keys.end()));
    shown.insert(keys.begin(), keys.end());
  }
  const auto showable = enumerate_showable(study_, experiment_, cells);
  EXPECT_EQ(std::vector<std::string>(shown.begin(), shown.end()), showable);
}

TEST(Schedule, CountsArtifactTrialsAsThePaperDoes) {
  EXPECT_EQ(artifact_cells(load_protocol("paper")).size(), 480u);
  EXPECT_EQ(artifact_cells(load_protocol("validation")).size(), 168u);
  EXPECT_EQ(artifact_cells(load_protocol("normalisation")).size(), 48u);
  EXPECT_EQ(artifact_cells(load_protocol("pocket")).size(), 32u);
}

TEST(Schedule, TestsFourAdjacentLevelsOfTheWindow) {
  const Study study = load_protocol("pocket");
  const Windows windows = load_windows(study.windows_path, study);
  const auto cells = enumerate_artifact_cells(study, windows);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const int first = windows.by_column.at(cells[i].column).first_level;
    EXPECT_EQ(cells[i].clamp_level, first + static_cast<int>(i % kWindowLevels));
  }
}

TEST(Schedule, ShowsNormalisedPicturesOfANormalisedStudy) {
  const Study study = load_protocol("normalisation");
  const auto trials =
      make_schedule(study, Experiment::kArtifact, artifact_cells(study), SubjectKind::kPerson, 1, 0);
  for (const TrialRow& trial : trials) EXPECT_TRUE(parse_condition(trial.test_key, "trial").cell.normalised);
}

TEST(Schedule, TurnsThePairWhereTheStudySaysSo) {
  Study study = load_protocol("pocket");
  study.view_mode = ViewMode::kPairTurned;
  for (std::int64_t index = 0; index < 8; ++index) {
    const auto trials =
        make_schedule(study, Experiment::kMaterial, material_cells(study, 0), SubjectKind::kPerson, 1, index);
    EXPECT_THAT(check_pairing(study, Experiment::kMaterial, trials), IsEmpty());
  }
}

bool same_trials(const std::vector<TrialRow>& a, const std::vector<TrialRow>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const TrialRow& x, const TrialRow& y) {
    return x.cell == y.cell && x.test_key == y.test_key && x.pair_key == y.pair_key &&
           x.upper_key == y.upper_key && x.test_side == y.test_side;
  });
}

TEST(Schedule, IsAFunctionOfItsArguments) {
  const Study study = load_protocol("pocket");
  const auto cells = artifact_cells(study);
  const auto make = [&](SubjectKind kind, std::uint64_t seed, std::int64_t index) {
    return make_schedule(study, Experiment::kArtifact, cells, kind, seed, index);
  };
  const auto trials = make(SubjectKind::kPerson, 5, 2);
  EXPECT_TRUE(same_trials(trials, make(SubjectKind::kPerson, 5, 2)));
  EXPECT_FALSE(same_trials(trials, make(SubjectKind::kPlanted, 5, 2)));
  EXPECT_FALSE(same_trials(trials, make(SubjectKind::kPerson, 6, 2)));
  EXPECT_FALSE(same_trials(trials, make(SubjectKind::kPerson, 5, 3)));
}

TEST(Schedule, DrawsOnlyTheOrderFromTheSessionsSeed) {
  const Study study = load_protocol("pocket");
  const auto cells = artifact_cells(study);
  const auto by_cell = [&](std::uint64_t seed) {
    auto trials = make_schedule(study, Experiment::kArtifact, cells, SubjectKind::kPerson, seed, 4);
    std::sort(trials.begin(), trials.end(), [](const auto& a, const auto& b) { return a.cell < b.cell; });
    return trials;
  };
  EXPECT_TRUE(same_trials(by_cell(1), by_cell(2)));
}

// Chi-squared over which of 32 cells comes first and which last: 6,400 sessions, session seed 11, 200
// expected in each cell, 31 degrees of freedom, level 0.1 % for each of the two.
TEST(Schedule, DrawsAllOrdersEvenly) {
  const Study study = load_protocol("pocket");
  const auto cells = artifact_cells(study);
  std::map<Cell, std::array<int, 2>> counts;
  for (std::int64_t index = 0; index < 6400; ++index) {
    const auto trials = make_schedule(study, Experiment::kArtifact, cells, SubjectKind::kPerson, 11, index);
    ++counts[trials.front().cell][0];
    ++counts[trials.back().cell][1];
  }
  for (std::size_t end = 0; end < 2; ++end) {
    double chi_squared = 0;
    for (const Cell& cell : cells) chi_squared += std::pow(counts[cell][end] - 200.0, 2) / 200;
    EXPECT_LT(chi_squared, 61.098);
  }
}

// What a subject could learn from the place in the session: a side must not follow from it. 4,000 sessions of
// the first trial, session seed 12: left is Binomial(4000, 1/2), level 0.1 % (two-sided, 3.29 sigma).
TEST(Schedule, DoesNotTellTheSideByThePlace) {
  const Study study = load_protocol("pocket");
  const auto cells = artifact_cells(study);
  int left = 0;
  for (std::int64_t index = 0; index < 4000; ++index) {
    const auto trials = make_schedule(study, Experiment::kArtifact, cells, SubjectKind::kPerson, 12, index);
    left += trials.front().test_side == Side::kLeft ? 1 : 0;
  }
  EXPECT_NEAR(left, 2000, 3.29 * std::sqrt(1000.0));
}

// Mutants: the checks above must see each of them.
class Mutant : public ::testing::Test {
 protected:
  Study study_ = load_protocol("pocket");
  std::vector<TrialRow> artifact_ =
      make_schedule(study_, Experiment::kArtifact, artifact_cells(study_), SubjectKind::kPerson, 1, 0);
  std::vector<TrialRow> material_ =
      make_schedule(study_, Experiment::kMaterial, material_cells(study_, 0), SubjectKind::kPerson, 1, 0);
  Breaches pairing_of_artifact() { return check_pairing(study_, Experiment::kArtifact, artifact_); }
};

TEST_F(Mutant, WithOneSideTurnedIsUnbalanced) {
  artifact_[3].test_side = artifact_[3].test_side == Side::kLeft ? Side::kRight : Side::kLeft;
  EXPECT_THAT(check_session_balance(artifact_), Contains(HasSubstr("half left, half right")));
}

TEST_F(Mutant, WithTheSameSidesForEverySubjectIsUnbalanced) {
  BalanceOverSubjects balance(study_, Experiment::kArtifact);
  EXPECT_THAT(balance.add(artifact_), IsEmpty());
  EXPECT_THAT(balance.add(artifact_), Contains(HasSubstr("view x side")));
}

TEST_F(Mutant, WithTheSameMaterialTwiceIsUnbalanced) {
  study_ = load_protocol("paper");
  const auto cells = artifact_cells(study_);
  auto first = make_schedule(study_, Experiment::kArtifact, cells, SubjectKind::kPerson, 1, 0);
  auto second = make_schedule(study_, Experiment::kArtifact, cells, SubjectKind::kPerson, 1, 1);
  const auto same_cell = std::find_if(second.begin(), second.end(),
                                      [&](const auto& trial) { return trial.cell == first[0].cell; });
  Family pair = parse_family(same_cell->pair_key, "mutant");
  pair.object.material = parse_family(first[0].pair_key, "mutant").object.material;
  same_cell->pair_key = format_key(pair);
  BalanceOverSubjects balance(study_, Experiment::kArtifact);
  EXPECT_THAT(balance.add(first), IsEmpty());
  EXPECT_THAT(balance.add(second), Contains(HasSubstr("reference materials")));
}

TEST_F(Mutant, WithTheSameViewTwiceBreaksThePairing) {
  Family pair = parse_family(artifact_[0].pair_key, "mutant");
  pair.view = 1 - pair.view;
  artifact_[0].pair_key = format_key(pair);
  EXPECT_THAT(pairing_of_artifact(), Contains(HasSubstr("different views")));
}

TEST_F(Mutant, WithTheSameMaterialBesideBreaksThePairing) {
  Family pair = parse_family(artifact_[0].pair_key, "mutant");
  pair.object.material = artifact_[0].cell.column.object.material;
  artifact_[0].pair_key = format_key(pair);
  EXPECT_THAT(pairing_of_artifact(), Contains(HasSubstr("different materials")));
}

TEST_F(Mutant, WithTheUpperReferenceNotTurnedBreaksTheTriple) {
  material_[0].upper_key = material_[0].pair_key;
  EXPECT_THAT(check_pairing(study_, Experiment::kMaterial, material_),
              Contains(HasSubstr("view of the upper picture")));
}

}  // namespace
}  // namespace equilux
