// k of n by cells, and the integer cut of a cell.
#include "analysis/tally.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <numeric>

#include "base/error.h"
#include "tests/analysis/columns.h"

namespace equilux::tests {
namespace {

// k / n >= 3 / 4 with both sides as reduced fractions over a common denominator, not by the program's
// formula.
bool is_at_least_three_quarters(std::int64_t k, std::int64_t n) {
  const std::int64_t common = std::lcm(n, std::int64_t{4});
  return k * (common / n) >= 3 * (common / 4);
}

using Flag = std::function<bool(const Count&)>;

bool agrees_with_rationals(const Flag& flag) {
  for (std::int64_t n = 1; n <= 250; ++n) {
    for (std::int64_t k = 0; k <= n; ++k) {
      if (flag({k, n}) != is_at_least_three_quarters(k, n)) return false;
    }
  }
  return !flag({0, 0});
}

TEST(Tally, flags_a_cell_exactly_where_the_rational_is_at_least_three_quarters) {
  EXPECT_TRUE(agrees_with_rationals([](const Count& count) { return is_flagged(count); }));
}

TEST(Tally, the_check_of_the_cut_fails_on_cuts_off_by_one) {
  EXPECT_FALSE(agrees_with_rationals([](const Count& c) { return c.n > 0 && 4 * c.k > 3 * c.n; }));
  EXPECT_FALSE(agrees_with_rationals([](const Count& c) { return c.n > 0 && 4 * c.k >= 3 * c.n - 1; }));
  EXPECT_FALSE(agrees_with_rationals([](const Count& c) { return c.n > 0 && 4 * (c.k + 1) >= 3 * c.n; }));
  EXPECT_FALSE(agrees_with_rationals([](const Count& c) { return c.n > 0 && 3 * c.k >= 2 * c.n; }));
  EXPECT_FALSE(agrees_with_rationals([](const Count& c) { return 4 * c.k >= 3 * c.n; }));
}

TEST(Tally, nine_of_twelve_and_eleven_of_fourteen_are_the_first_to_be_flagged) {
  EXPECT_FALSE(is_flagged({8, 12}));
  EXPECT_TRUE(is_flagged({9, 12}));
  EXPECT_FALSE(is_flagged({10, 14}));
  EXPECT_TRUE(is_flagged({11, 14}));
}

TEST(Tally, covers_every_cell_of_the_study_and_counts_each_answer_once) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  const Tally tally = tally_answers(planted.artifact, planted.study);
  EXPECT_EQ(tally.size(), enumerate_cells(planted.study).size());
  EXPECT_EQ(count_answers(tally), 8 * 4 * 12);
  std::int64_t correct = 0;
  for (const auto& [cell, count] : tally) correct += count.k;
  EXPECT_EQ(correct, std::count_if(planted.artifact.begin(), planted.artifact.end(),
                                   [](const AnswerRow& row) { return row.correct; }));
}

TEST(Tally, is_the_same_for_every_order_of_rows_and_differs_once_an_answer_is_dropped) {
  PlantedStudy planted = make_planted_study("pocket", 12, 14, 2, 0.02);
  const Tally tally = tally_answers(planted.artifact, planted.study);
  RandomStream random(7, "permutation", 0);  // 20 permutations of 384 rows
  for (int i = 0; i < 20; ++i) {
    shuffle(planted.artifact, random);
    ASSERT_EQ(tally_answers(planted.artifact, planted.study), tally);
  }
  planted.artifact.pop_back();
  EXPECT_NE(tally_answers(planted.artifact, planted.study), tally);
}

TEST(Tally, refuses_a_cell_that_the_study_does_not_have) {
  const Study study = load_protocol("pocket");
  const AnswerRow row{1, 0, parse_cell("G3-MS-ind-1k-C4", "test"), true};
  EXPECT_THROW(tally_answers({row}, study), InputError);
}

TEST(Tally, refuses_a_cell_that_one_session_answered_twice) {
  const Study study = load_protocol("pocket");
  const AnswerRow row{1, 0, parse_cell("G0-MS-ind-1k-C4", "test"), true};
  EXPECT_THROW(tally_answers({row, row}, study), InputError);
}

}  // namespace
}  // namespace equilux::tests
