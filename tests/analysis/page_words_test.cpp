// What the page says of studies that are small, unfinished or added up from several folders.
#include <gtest/gtest.h>

#include "analysis/page_sections.h"
#include "analysis/plan.h"
#include "analysis/views.h"
#include "analysis/warnings.h"
#include "tests/analysis/planted_report.h"

namespace equilux::tests {
namespace {

// Of the pocket study's first columns one is left free of artifacts from C5 on, one at no level.
Report report_artifacts(const std::vector<std::map<int, int>>& columns) {
  PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  planted.artifact.clear();
  const auto all = enumerate_columns(planted.study);
  for (int subject = 0; subject < 12; ++subject) {
    for (std::size_t c = 0; c < columns.size(); ++c) {
      for (const auto& [level, k] : columns[c])
        planted.artifact.push_back({subject + 1, subject, Cell{all[c], level, false}, subject < k});
    }
  }
  planted.material.clear();
  Evidence evidence{
      SubjectKind::kPerson, make_evidence(planted, Experiment::kArtifact, SubjectKind::kPerson, 12), {}};
  return make_report(planted.study, std::move(evidence), Rule::kPaper, {}, {1, 10, 10});
}

TEST(PageWords, without_material_sessions_say_that_columns_wait_and_not_that_none_has_a_verdict) {
  const std::map<int, int> open{{3, 12}, {4, 12}, {5, 2}, {6, 2}}, lost{{7, 12}, {8, 12}, {9, 12}, {10, 12}};
  const std::string all = format_rule_differences(report_artifacts(std::vector(8, open)));
  EXPECT_TRUE(has(all, "neither rule has a verdict yet.")) << all;
  const std::string some =
      format_rule_differences(report_artifacts({open, open, lost, lost, lost, lost, lost, lost}));
  EXPECT_TRUE(has(some, "of 8 columns 2 wait for its answers")) << some;
  const std::string one =
      format_rule_differences(report_artifacts({open, lost, lost, lost, lost, lost, lost, lost}));
  EXPECT_TRUE(has(one, "of 8 columns 1 waits for its answers")) << one;
  const std::string none = format_rule_differences(report_artifacts(std::vector(8, lost)));
  EXPECT_FALSE(has(none, "verdict")) << none;
}

TEST(PageWords, of_a_study_without_trends_do_not_say_that_its_factors_have_one_level) {
  Report report = make_planted_report(make_planted_study("pocket", 12, 14, 1, 0.02));
  ASSERT_FALSE(report.trends.empty());
  report.trends.clear();
  EXPECT_TRUE(has(format_trends(report), "No trend is asked for in this study.")) << format_trends(report);
}

// The levels of the first column that isotonic would have kept were not tested.
TEST(PageWords, of_folders_that_pruned_by_several_rules_name_no_one_rule) {
  PlantedStudy planted = answer_column({{3, 12}, {4, 5}, {5, 9}, {6, 3}}, {{6, 7}, {8, 7}, {10, 14}});
  Report report = make_planted_report(planted);
  EXPECT_TRUE(has(format_rule_differences(report), "were chosen by one rule (<i>paper</i>). These levels"));
  report.selections = {{"a", "paper", "d", "e"}, {"b", "isotonic", "f", "e"}};
  report.selection->rule = "";
  const std::string pooled = format_rule_differences(report);
  EXPECT_TRUE(has(pooled, "were chosen in each folder by its own rule. These levels")) << pooled;
  EXPECT_FALSE(has(pooled, "by one rule"));
}

// Free of artifacts from C4, the same material up to C5, and the study has neither.
TEST(PageWords, plant_no_equivalence_at_a_level_that_the_study_does_not_have) {
  PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0);
  std::erase_if(planted.study.clamp_levels, [](int level) { return level == 4 || level == 5; });
  for (auto& [column, truth] : planted.truth.by_column) truth = {4, 5};
  planted.artifact = planted.material = {};
  Evidence evidence{SubjectKind::kPlanted, {}, {}};
  ReportSources sources;
  sources.truth = planted.truth;
  const auto recover = [&] {
    return format_recovery(make_report(planted.study, evidence, Rule::kPaper, sources, {1, 10, 10}));
  };
  EXPECT_EQ(find_true_width(planted.study, planted.truth), 0);
  EXPECT_FALSE(has(recover(), "<td>+</td>")) << recover();
  for (auto& [column, truth] : sources.truth->by_column) truth = {4, 6};
  EXPECT_EQ(find_true_width(planted.study, *sources.truth), 1);
  EXPECT_TRUE(has(recover(), "<td>+</td>")) << recover();
}

Report report_balance(const Spread& sessions, const Spread& cells) {
  Report report;
  report.artifact_balance = {sessions, cells, 1};
  return report;
}

TEST(PageWords, of_balance_name_only_what_breaks_the_rule) {
  const auto warn = [](const Spread& sessions, const Spread& cells) {
    const auto warnings = find_answer_warnings(report_balance(sessions, cells));
    return warnings.empty() ? "" : warnings.front();
  };
  const Spread well{7, 1, 0}, ill{7, 4, 3};
  EXPECT_EQ(warn(well, well), "");
  EXPECT_TRUE(
      has(warn(ill, ill),
          "differ by more than 1 in 3 of 7 sessions (by 4 at most), and of 3 of 7 cells over sessions "
          "(by 4 at most). Subjects left out, and logs added up, leave such gaps in cells; in a "
          "session nothing should."))
      << warn(ill, ill);
  EXPECT_TRUE(
      has(warn(well, ill), "differ by more than 1 in 3 of 7 cells over sessions (by 4 at most). Subj"))
      << warn(well, ill);
  EXPECT_FALSE(has(warn(well, ill), "of 7 sessions (")) << warn(well, ill);
  EXPECT_TRUE(has(warn(ill, well), "in 3 of 7 sessions (by 4 at most). In a session nothing"))
      << warn(ill, well);
  EXPECT_FALSE(has(warn(ill, well), "cells")) << warn(ill, well);
}

TEST(PageWords, speak_of_one_session_in_the_singular) {
  Report report;
  report.evidence.artifact.unfinished = 1;
  report.evidence.artifact.unanswered = 1;
  report.evidence.artifact.summaries.resize(1);
  report.evidence.artifact.summaries[0].answered = 1;
  EXPECT_EQ(find_answer_warnings(report),
            (std::vector<std::string>{
                "1 artifact session was not finished (0 ended early by the experimenter, 1 left unfinished): "
                "its 1 answer is left out.",
                "1 trial of finished artifact sessions has no answer: it is left out."}));
  report.artifact_subjects.sessions.resize(1);
  report.artifact_subjects.sessions[0].marks = {SubjectMark::kFast};
  report.artifact_subjects.order.subjects = 1;
  const std::string page = format_subjects(report);
  for (const char* told : {"1 marked session counts all the same. Without it no", "Each of the 1 session<",
                           "artifact: 1 subject with answers in both halves of a finished session, too few",
                           "material: 0 subjects with answers in both halves"})
    EXPECT_TRUE(has(page, told)) << told << page;
}

TEST(PageWords, of_a_small_p_have_one_sign) {
  Report report;
  report.artifact_subjects.order = {20, 0.2, Interval{0.1, 0.3}, 0.00001, {}};
  EXPECT_TRUE(has(format_subjects(report), ", p&nbsp;&lt; 0.0001 by sign")) << format_subjects(report);
  report.artifact_subjects.order.p = 0.25;
  EXPECT_TRUE(has(format_subjects(report), ", p&nbsp;=&nbsp;0.2500 by sign")) << format_subjects(report);
}

// Of the second trial nobody has an answer; the views of the others are known all the same.
TEST(PageWords, of_views_count_the_trials_that_were_answered) {
  ExperimentEvidence evidence;
  const Column column = enumerate_columns(load_protocol("pocket")).front();
  evidence.answers = {{1, 0, {column, 4, false}, true}, {1, 0, {column, 6, false}, false}};
  SessionSummary summary;
  summary.session = 1;
  summary.complete = true;
  summary.answered = 2;
  summary.combos = {0, 2 + kUnansweredCombo, 3};
  evidence.summaries = {summary};
  const auto views = count_by_view(evidence);
  ASSERT_TRUE(views);
  EXPECT_EQ((*views)[0], (Count{1, 1}));
  EXPECT_EQ((*views)[1], (Count{0, 1}));
  evidence.summaries[0].combos.clear();
  EXPECT_FALSE(count_by_view(evidence));
}

}  // namespace
}  // namespace equilux::tests
