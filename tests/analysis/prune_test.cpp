// What goes on to the material experiment, by hand; and when a selection is frozen.
#include "analysis/prune.h"

#include <gtest/gtest.h>

#include "tests/analysis/columns.h"

namespace equilux::tests {
namespace {

std::vector<int> levels_after(std::optional<int> cut) {
  Threshold threshold;
  threshold.cut = cut;
  return keep_levels(threshold, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
}

TEST(Pruning, keeps_the_first_surviving_level_every_second_and_always_the_last) {
  EXPECT_EQ(levels_after(5), (std::vector<int>{5, 7, 9, 10}));
  EXPECT_EQ(levels_after(6), (std::vector<int>{6, 8, 10}));
  EXPECT_EQ(levels_after(9), (std::vector<int>{9, 10}));
  EXPECT_EQ(levels_after(10), (std::vector<int>{10}));
  EXPECT_EQ(levels_after(0), (std::vector<int>{0, 2, 4, 6, 8, 10}));
}

TEST(Pruning, drops_a_column_without_a_cut) { EXPECT_TRUE(levels_after(std::nullopt).empty()); }

TEST(Pruning, of_cuts_at_each_of_the_eleven_levels_keeps_the_sum_of_their_halves) {
  std::size_t kept = 0;
  for (int cut = 0; cut <= 10; ++cut) {
    const std::size_t expected = static_cast<std::size_t>((10 - cut) / 2 + 1 + (cut % 2));
    EXPECT_EQ(levels_after(cut).size(), expected) << cut;
    kept += expected;
  }
  EXPECT_EQ(kept, 41U);
}

// The number follows from the planted cuts, counted here by the closed form (10 - cut) / 2 + 1 + cut mod 2.
TEST(Pruning, of_the_papers_study_leaves_what_its_planted_cuts_say) {
  const PlantedStudy planted = make_planted_study("paper", 200, 1, 3, 0.0);
  std::size_t expected = 0;
  for (const auto& [column, truth] : planted.truth.by_column) {
    const int cut = truth.artifact_free_from;
    expected += cut > 10 ? 0 : static_cast<std::size_t>((10 - cut) / 2 + 1 + cut % 2);
  }
  EXPECT_EQ(enumerate_selected_cells(planted.selection, planted.study).size(), expected);
  EXPECT_LT(expected, enumerate_cells(planted.study).size());
}

TEST(Pruning, writes_status_and_cut_of_each_column_in_the_order_of_the_study) {
  const Study study = load_protocol("pocket");
  Tally tally = tally_answers({}, study);
  const auto columns = enumerate_columns(study);
  const auto set = [&](std::size_t column, int level, Count count) {
    tally[Cell{columns[column], level, false}] = count;
  };
  for (int level = 4; level < 8; ++level) set(0, level, {6, 12});
  for (int level = 7; level < 11; ++level) set(1, level, {12, 12});
  for (int level = 3; level < 7; ++level) set(2, level, {level < 5 ? 12 : 6, 12});
  const Selection selection = make_selection(study, tally, SubjectKind::kPerson, Rule::kPaper, "digest");
  ASSERT_EQ(selection.columns.size(), columns.size());
  EXPECT_EQ(selection.columns[0].status, "censored_low");
  EXPECT_EQ(selection.columns[0].levels, (std::vector<int>{4, 6, 8, 10}));
  EXPECT_EQ(selection.columns[1].status, "none");
  EXPECT_TRUE(selection.columns[1].levels.empty());
  EXPECT_EQ(selection.columns[2].artifact_cut, 5);
  EXPECT_EQ(selection.columns[3].status, "untested");
  EXPECT_TRUE(selection.columns[3].levels.empty());
  const std::string text = format_selection(selection, study);
  EXPECT_NE(text.find("8 of 88 conditions go on (rule paper, person answers)"), std::string::npos) << text;
}

TEST(Pruning, again_after_a_session_used_the_selection_changes_nothing) {
  const Study study = load_protocol("pocket");
  const Tally none = tally_answers({}, study);
  const Selection first = make_selection(study, none, SubjectKind::kPerson, Rule::kPaper, "one");
  const Selection other = make_selection(study, none, SubjectKind::kPerson, Rule::kPaper, "two");
  const std::string used = digest_selection(first);
  EXPECT_EQ(decide_pruning(first, std::nullopt, {}), PruneOutcome::kWritten);
  EXPECT_EQ(decide_pruning(first, first, {}), PruneOutcome::kUnchanged);
  EXPECT_EQ(decide_pruning(other, first, {}), PruneOutcome::kWritten);
  EXPECT_EQ(decide_pruning(first, first, {used}), PruneOutcome::kFrozenEqual);
  EXPECT_EQ(decide_pruning(other, first, {used}), PruneOutcome::kFrozenOther);
}

TEST(Pruning, restores_a_lost_selection_that_was_used_but_writes_no_other_in_its_place) {
  const Study study = load_protocol("pocket");
  const Tally none = tally_answers({}, study);
  const Selection first = make_selection(study, none, SubjectKind::kPerson, Rule::kPaper, "one");
  const Selection other = make_selection(study, none, SubjectKind::kPerson, Rule::kPaper, "two");
  const std::string used = digest_selection(first);
  EXPECT_EQ(decide_pruning(first, std::nullopt, {used}), PruneOutcome::kWritten);
  EXPECT_EQ(decide_pruning(other, std::nullopt, {used}), PruneOutcome::kMissingOther);
}

}  // namespace
}  // namespace equilux::tests
