// Subjects: marks by their rules, agreement by hand, the order effect against its exact distribution.
#include "analysis/subjects.h"

#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>

#include "tests/analysis/columns.h"
#include "tests/experiment/fake_trials.h"

namespace equilux::tests {
namespace {

SessionRow make_finished(std::int64_t id) {
  SessionRow row;
  row.id = id;
  row.participant = fmt::format("P{}", id);
  row.complete = true;
  return row;
}

// Trials i = 0, 1, ..: the test picture left and right in turn; correct where `correct(i)`.
std::vector<BriefTrial> make_trials(int count, const std::function<bool(int)>& correct,
                                    double seconds = 1.5) {
  std::vector<BriefTrial> trials;
  for (int i = 0; i < count; ++i) {
    BriefTrial trial;
    trial.number = i;
    trial.test_side = i % 2 == 0 ? Side::kLeft : Side::kRight;
    const bool left = (trial.test_side == Side::kLeft) == correct(i);
    trial.answer = left ? Side::kLeft : Side::kRight;
    trial.response_time_ns = static_cast<std::int64_t>(seconds * 1e9);
    trials.push_back(trial);
  }
  return trials;
}

TEST(Subjects, summary_counts_sides_halves_and_times) {
  const auto summary = summarise_session(make_finished(3), make_trials(10, [](int i) { return i < 5; }));
  EXPECT_EQ(summary.scheduled, 10);
  EXPECT_EQ(summary.answered, 10);
  EXPECT_EQ(summary.first_half, (Count{5, 5}));
  EXPECT_EQ(summary.second_half, (Count{0, 5}));
  EXPECT_EQ(summary.left, 3 + 3);
  EXPECT_EQ(summary.median_response_s, 1.5);
  EXPECT_EQ(summary.caught, (Count{0, 0}));
}

TEST(Subjects, summary_is_the_same_for_rows_in_any_order) {
  auto trials = make_trials(21, [](int i) { return i % 3 == 0; });
  const auto before = summarise_session(make_finished(1), trials);
  RandomStream random(5, "permutation", 0);
  shuffle(trials, random);
  const auto after = summarise_session(make_finished(1), trials);
  EXPECT_EQ(before.first_half, after.first_half);
  EXPECT_EQ(before.median_response_s, after.median_response_s);
}

TEST(Subjects, an_aborted_session_keeps_its_counts_and_is_not_marked) {
  auto trials = make_trials(40, [](int) { return true; });
  for (std::size_t i = 10; i < 40; ++i) trials[i].answer.reset();
  SessionRow row = make_finished(1);
  row.complete = false;
  const auto summary = summarise_session(row, trials);
  EXPECT_EQ(summary.scheduled, 40);
  EXPECT_EQ(summary.answered, 10);
  EXPECT_TRUE(find_subjects({summary}, {}).front().marks.empty());
}

TEST(Subjects, of_no_answers_have_no_numbers) {
  const auto finding = find_subjects({summarise_session(make_finished(1), {})}, {}).front();
  EXPECT_FALSE(finding.p_side || finding.agreement || finding.summary.median_response_s);
  EXPECT_TRUE(finding.marks.empty());
}

std::vector<SubjectMark> marks_of(const std::vector<BriefTrial>& trials) {
  return find_subjects({summarise_session(make_finished(1), trials)}, {}).front().marks;
}

TEST(Subjects, who_press_one_side_or_at_once_are_marked) {
  EXPECT_TRUE(marks_of(make_trials(40, [](int i) { return i % 4 < 2; })).empty());
  EXPECT_EQ(marks_of(make_trials(40, [](int i) { return i % 2 == 0; })),
            std::vector<SubjectMark>{SubjectMark::kSideBias});
  EXPECT_EQ(marks_of(make_trials(
                40, [](int) { return true; }, 0.2)),
            std::vector<SubjectMark>{SubjectMark::kFast});
}

TEST(Subjects, who_miss_more_than_a_quarter_of_catch_trials_are_marked) {
  SessionSummary summary = summarise_session(make_finished(1), make_trials(40, [](int) { return true; }));
  summary.caught = {3, 4};
  EXPECT_TRUE(find_subjects({summary}, {}).front().marks.empty());
  summary.caught = {2, 4};
  EXPECT_EQ(find_subjects({summary}, {}).front().marks, std::vector<SubjectMark>{SubjectMark::kCatch});
  summary.caught = {0, 3};
  EXPECT_TRUE(find_subjects({summary}, {}).front().marks.empty()) << "too few to say";
}

TEST(Subjects, are_held_to_the_catch_trials_that_their_protocol_asks_for) {
  SessionSummary summary = summarise_session(make_finished(1), make_trials(40, [](int) { return true; }));
  const auto is_marked = [&](Count caught, std::int64_t pass) {
    summary.caught = caught;
    summary.catch_pass = pass;
    return !find_subjects({summary}, {}).front().marks.empty();
  };
  EXPECT_FALSE(is_marked({10, 12}, 10));
  EXPECT_TRUE(is_marked({10, 12}, 11)) << "though more than three quarters are right";
  EXPECT_FALSE(is_marked({1, 4}, 1)) << "though three quarters are wrong";
  EXPECT_TRUE(is_marked({0, 1}, 1)) << "though one is few";
}

TEST(Subjects, answers_under_the_least_time_are_counted_and_their_number_told) {
  auto trials = make_trials(6, [](int) { return true; });
  trials[1].too_fast = trials[4].too_fast = true;
  trials[5].phase = Phase::kPractice;
  trials[5].too_fast = true;
  const auto summary = summarise_session(make_finished(1), trials);
  EXPECT_EQ(summary.too_fast, 2) << "practice is not counted";
  EXPECT_EQ(summary.answered, 5);
}

// 12 subjects of whom eleven agree on 40 cells with a lapse each, one answers by coins.
std::vector<AnswerRow> make_agreeing(bool with_stranger) {
  std::vector<AnswerRow> answers;
  RandomStream random(9, "stranger", 0);
  const Study study = load_protocol("pocket");
  const auto cells = enumerate_cells(study);
  for (int subject = 0; subject < 12; ++subject) {
    for (std::size_t c = 0; c < 40; ++c) {
      const bool usual = (c % 2 == 0) != (c == static_cast<std::size_t>(3 * subject % 40) ||
                                          c == static_cast<std::size_t>(subject * subject % 40));
      const bool coin = random.next_below(2) == 0;
      answers.push_back({subject + 1, subject, cells[c], with_stranger && subject == 11 ? coin : usual});
    }
  }
  return answers;
}

TEST(Subjects, who_disagree_with_the_rest_are_marked) {
  for (const bool with_stranger : {false, true}) {
    const ResponseMatrix matrix = make_response_matrix(make_agreeing(with_stranger));
    std::vector<SessionSummary> summaries;
    for (int i = 1; i <= 12; ++i)
      summaries.push_back(
          summarise_session(make_finished(i), make_trials(40, [](int j) { return j % 4 < 2; })));
    const auto findings = find_subjects(summaries, matrix);
    for (std::size_t i = 0; i < 12; ++i) {
      EXPECT_EQ(!findings[i].marks.empty(), with_stranger && i == 11) << i << " " << *findings[i].agreement;
    }
  }
}

TEST(Agreement, is_the_share_of_cells_where_a_subject_goes_with_the_majority_of_others) {
  const Study study = load_protocol("pocket");
  const auto cells = enumerate_cells(study);
  std::vector<AnswerRow> answers;
  const bool right[3][2] = {{true, true}, {true, true}, {false, true}};
  for (int s = 0; s < 3; ++s) {
    for (int c = 0; c < 2; ++c) answers.push_back({s, s, cells[static_cast<std::size_t>(c)], right[s][c]});
  }
  const ResponseMatrix matrix = make_response_matrix(answers);
  const auto agreement = find_agreement(matrix);
  for (std::size_t s = 0; s < 3; ++s) {
    // The third differs from both others in the first cell; for them that cell's others are tied.
    EXPECT_EQ(agreement[s], matrix.sessions[s] == 2 ? 0.5 : 1.0);
  }
}

SessionSummary with_halves(int first, int second) {
  SessionSummary summary;
  summary.complete = true;
  summary.first_half = {first, 10};
  summary.second_half = {second, 10};
  summary.first_half_s = 2.0;
  summary.second_half_s = 1.0;
  return summary;
}

// All eight got better by 1 of 10: of 256 sign flips two are as far.
TEST(OrderEffect, of_eight_who_all_got_better_has_the_exact_p) {
  const std::vector<SessionSummary> summaries(8, with_halves(5, 6));
  const OrderEffect effect = find_order_effect(summaries, 1);
  EXPECT_EQ(effect.subjects, 8U);
  EXPECT_NEAR(*effect.correct, 0.1, 1e-12);
  EXPECT_NEAR(effect.interval->lower, 0.1, 1e-12);
  EXPECT_NEAR(effect.interval->upper, 0.1, 1e-12);
  EXPECT_DOUBLE_EQ(*effect.p, 2.0 / 256);
  EXPECT_DOUBLE_EQ(*effect.speed, 0.5);
}

// P1 got better by 1 of 10 and worse by 3 of 10 in two sessions: as one subject, worse by 1.
TEST(OrderEffect, takes_the_sessions_of_one_person_for_one_subject) {
  std::vector<SessionSummary> summaries{with_halves(5, 6), with_halves(5, 2), with_halves(5, 8)};
  summaries[0].participant = summaries[1].participant = "P1";
  summaries[2].participant = "P2";
  const OrderEffect effect = find_order_effect(summaries, 1);
  EXPECT_EQ(effect.subjects, 2U);
  EXPECT_NEAR(*effect.correct, 0.1, 1e-12);
}

// Beyond 16 subjects by draws: 20 of whom 10 got better and 10 worse, equally; every flip is as far as none.
TEST(OrderEffect, of_many_who_cancel_out_has_p_one) {
  std::vector<SessionSummary> summaries;
  for (int i = 0; i < 20; ++i) summaries.push_back(i % 2 == 0 ? with_halves(5, 6) : with_halves(6, 5));
  EXPECT_EQ(find_order_effect(summaries, 1).p, 1.0);
}

TEST(OrderEffect, of_none_or_one_has_no_test) {
  EXPECT_FALSE(find_order_effect({}, 1).correct);
  EXPECT_FALSE(find_order_effect({with_halves(5, 5)}, 1).p);
}

}  // namespace
}  // namespace equilux::tests
