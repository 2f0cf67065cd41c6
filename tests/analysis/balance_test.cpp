// Balance: the program's own schedules keep the rule, by counts taken from their trials; mutants do not.
#include "analysis/balance.h"

#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>

#include "analysis/report.h"
#include "experiment/schedule.h"
#include "tests/analysis/brief.h"
#include "tests/analysis/columns.h"

namespace equilux::tests {
namespace {

// Sessions of the pocket study as make_schedule makes them, all answered.
ExperimentEvidence make_scheduled(int subjects, const std::function<void(int, TrialRow&)>& change = {}) {
  const Study study = load_protocol("pocket");
  const auto cells = enumerate_artifact_cells(study, load_windows(study.windows_path, study));
  ExperimentEvidence evidence;
  for (int i = 0; i < subjects; ++i) {
    SessionRow row;
    row.id = i + 1;
    row.participant = fmt::format("P{}", i);
    row.complete = true;
    auto trials = make_schedule(study, Experiment::kArtifact, cells, SubjectKind::kPlanted, 7, i);
    for (TrialRow& trial : trials) {
      trial.answer = trial.test_side;
      if (change) change(i, trial);
      if (trial.answer) evidence.answers.push_back({row.id, i, trial.cell, true});
    }
    evidence.finished.push_back(row);
    evidence.summaries.push_back(summarise_session(row, make_brief(trials)));
  }
  return evidence;
}

TEST(Balance, of_the_programs_schedules_is_what_the_rule_says) {
  for (const int subjects : {1, 6, 12, 13}) {
    const Balance balance = find_balance(make_scheduled(subjects));
    EXPECT_EQ(balance.sessions.measured, static_cast<std::size_t>(subjects));
    EXPECT_EQ(balance.cells.measured, 32U);
    EXPECT_LE(balance.sessions.largest, 1);
    EXPECT_EQ(balance.sessions.over, 0U);
    EXPECT_EQ(balance.cells.largest, subjects % 4 == 0 ? 0 : 1) << subjects;
    EXPECT_EQ(balance.cells.over, 0U);
    EXPECT_EQ(balance.most_answers, 1);
  }
}

// The mutant: one picture of one session on its other side, in a study of four.
TEST(Balance, sees_one_picture_on_the_wrong_side) {
  const Balance balance = find_balance(make_scheduled(4, [](int session, TrialRow& trial) {
    if (session == 2 && trial.number == 5)
      trial.test_side = trial.test_side == Side::kLeft ? Side::kRight : Side::kLeft;
  }));
  EXPECT_EQ(balance.sessions.largest, 2);
  EXPECT_EQ(balance.sessions.over, 1U);
  EXPECT_EQ(balance.cells.largest, 2);
  EXPECT_EQ(balance.cells.over, 1U);
}

// One trial in the middle of the second of four sessions: its cell has an answer less of one combination, and
// nothing else changes.
TEST(Balance, leaves_out_a_trial_without_an_answer_and_keeps_the_others_in_their_cells) {
  const Balance whole = find_balance(make_scheduled(4));
  const Balance balance = find_balance(make_scheduled(4, [](int session, TrialRow& trial) {
    if (session == 1 && trial.number == 9) trial.answer.reset();
  }));
  EXPECT_EQ(balance.sessions.measured, 4U);
  EXPECT_EQ(balance.sessions.largest, whole.sessions.largest) << "it was shown all the same";
  EXPECT_EQ(whole.cells.largest, 0);
  EXPECT_EQ(balance.cells.largest, 1);
  EXPECT_EQ(balance.cells.over, 0U);
}

TEST(Balance, of_sessions_whose_views_are_not_known_is_not_measured) {
  const Balance balance =
      find_balance(make_scheduled(3, [](int, TrialRow& trial) { trial.test_key = "G0"; }));
  EXPECT_EQ(balance.sessions.measured, 0U);
  EXPECT_EQ(balance.cells.measured, 0U);
}

TEST(Balance, counts_the_answers_of_one_code_together) {
  ExperimentEvidence evidence = make_scheduled(4);
  evidence.finished[1].participant = evidence.finished[2].participant = "P0";
  EXPECT_EQ(find_balance(evidence).most_answers, 3);
  for (SessionRow& row : evidence.finished) row.participant = "";
  EXPECT_EQ(find_balance(evidence).most_answers, 1) << "nobody knows who they were";
  EXPECT_EQ(find_balance({}).most_answers, 0);
}

TEST(Balance, that_breaks_the_rule_is_warned_of_and_stands_on_the_page) {
  const Study study = load_protocol("pocket");
  Evidence evidence;
  evidence.artifact = make_scheduled(4, [](int, TrialRow& trial) { trial.test_side = Side::kLeft; });
  const Report report = make_report(study, evidence, Rule::kPaper, {}, {1, 10, 10});
  std::string warnings;
  for (const std::string& warning : report.warnings) warnings += warning + "\n";
  EXPECT_NE(warnings.find("in 4 of 4 sessions (by 16 at most), and of 32 of 32 cells over sessions"),
            std::string::npos)
      << warnings;
  EXPECT_NE(format_page({report}).find("16 (of 4), over one in 4"), std::string::npos);
}

}  // namespace
}  // namespace equilux::tests
