// Answers as a matrix: persons and their sessions, and weighted counts one by one and many at once.
#include "analysis/response_matrix.h"

#include <gtest/gtest.h>

#include "analysis/weighted_counts.h"
#include "base/error.h"
#include "tests/analysis/answered.h"

namespace equilux::tests {
namespace {

TEST(ResponseMatrix, adds_up_the_sessions_of_a_person_and_keeps_those_without_a_code_apart) {
  const ResponseMatrix sessions = make_response_matrix(make_two_cells(3, 4, 0, 0).artifact);
  const ResponseMatrix grouped = group_by_person(sessions, {{1, "P1"}, {2, ""}, {4, "P1"}});
  EXPECT_EQ(grouped.subjects(), 3U);
  const auto row = std::find(grouped.persons.begin(), grouped.persons.end(), "P1") - grouped.persons.begin();
  EXPECT_EQ(grouped.sessions.at(static_cast<std::size_t>(row)), 1) << "of 1 and 4";
  EXPECT_EQ(grouped.asked.at(static_cast<std::size_t>(row)), 2);
  EXPECT_EQ(grouped.correct.at(static_cast<std::size_t>(row)), 1) << "the fourth was wrong";
  EXPECT_EQ(count_weighted(grouped, {1, 1, 1}), count_weighted(sessions, {1, 1, 1, 1}));
}

// 300 sessions of one code, of which 280 are right: more than a byte counts.
TEST(ResponseMatrix, adds_up_as_many_sessions_of_a_person_as_there_are) {
  const ResponseMatrix sessions = make_response_matrix(make_two_cells(280, 300, 0, 0).artifact);
  const ResponseMatrix grouped = group_by_person(sessions, make_codes(300, 300));
  ASSERT_EQ(grouped.subjects(), 1U);
  EXPECT_EQ(grouped.asked.at(0), 300);
  EXPECT_EQ(grouped.correct.at(0), 280);
  EXPECT_EQ(count_weighted(grouped, {2}), (std::vector<Count>{{560, 600}}));
}

TEST(ResponseMatrix, counts_what_the_tally_counts) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 6, 0.3);
  const ResponseMatrix matrix = make_response_matrix(planted.artifact);
  const Tally tally = tally_answers(planted.artifact, planted.study);
  const auto counts = count_weighted(matrix, std::vector<std::uint32_t>(matrix.subjects(), 1));
  EXPECT_EQ(matrix.subjects(), 12U);
  for (std::size_t c = 0; c < counts.size(); ++c) EXPECT_EQ(counts[c], tally.at(matrix.cells[c]));
}

// A matrix of persons of one or several sessions, with cells that some were not asked, and weights whose sums
// fit into 16 bits or do not. Seed 5, 200 matrices.
TEST(WeightedCounts, of_many_resamples_are_those_of_each) {
  RandomStream random(5, "matrices", 0);
  int all_asked = 0;
  for (int round = 0; round < 200; ++round) {
    ResponseMatrix matrix;
    const std::size_t subjects = random.next_below(6), width = 1 + random.next_below(5);
    const std::uint64_t gaps = random.next_below(2), sessions = 1 + random.next_below(3);
    all_asked += gaps == 0 && sessions == 1 ? 1 : 0;
    matrix.cells.resize(width);
    matrix.sessions.resize(subjects);
    for (std::size_t i = 0; i < subjects * width; ++i) {
      const auto asked = static_cast<std::uint16_t>(sessions - (gaps ? random.next_below(sessions + 1) : 0));
      matrix.asked.push_back(asked);
      matrix.correct.push_back(static_cast<std::uint16_t>(random.next_below(asked + std::uint64_t{1})));
    }
    const std::uint64_t below = round % 2 == 0 ? 4 : 40000;
    std::vector<Lanes> weights(subjects);
    for (auto& lanes : weights) {
      for (std::size_t lane = 0; lane < kLanes; ++lane)
        lanes.add(lane, static_cast<std::uint32_t>(random.next_below(below)));
    }
    const auto counted = WeightedCounts(matrix).count(weights);
    ASSERT_EQ(counted.size(), width);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      std::vector<std::uint32_t> single;
      for (const auto& lanes : weights) single.push_back(lanes[lane]);
      const auto expected = count_weighted(matrix, single);
      for (std::size_t c = 0; c < width; ++c) ASSERT_EQ(counted[c].of(lane), expected[c]);
    }
  }
  EXPECT_GT(all_asked, 10) << "or the short way is not tried";
}

TEST(ResponseMatrix, names_a_cell_that_a_session_answered_twice) {
  std::vector<AnswerRow> answers = make_two_cells(3, 4, 0, 0).artifact;
  answers.push_back(answers.front());
  EXPECT_THROW(make_response_matrix(answers), InputError);
}

TEST(ResponseMatrix, of_nothing_is_empty) {
  EXPECT_EQ(make_response_matrix({}).subjects(), 0U);
  EXPECT_TRUE(count_weighted(make_response_matrix({}), {}).empty());
}

}  // namespace
}  // namespace equilux::tests
