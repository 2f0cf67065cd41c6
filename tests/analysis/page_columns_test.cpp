// What the page says of a single column: cuts beyond the tested levels, what is taken for granted, who was
// asked.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <map>

#include "analysis/csv.h"
#include "analysis/report.h"
#include "tests/analysis/planted_report.h"

namespace equilux::tests {
namespace {

// Artifacts at every tested level, C1 to C4: the rule takes C5 to C10 to be free of them, and all agree.
TEST(Report, says_of_what_was_never_tested_for_artifacts_that_it_is_taken_for_granted) {
  const std::map<int, int> material{{5, 3}, {7, 3}, {9, 3}, {10, 3}};
  const std::string beyond =
      format_page({make_planted_report(answer_column({{1, 12}, {2, 12}, {3, 12}, {4, 12}}, material))});
  EXPECT_TRUE(has(beyond, "in both experiments, 0 have a verdict"));
  EXPECT_TRUE(has(beyond, "(1 more would, but stands on levels alone that were never tested for artifacts"));
  EXPECT_TRUE(has(beyond, "&ge; C5 <span class=\"note\">censored_high</span>"));
  EXPECT_FALSE(has(beyond, "it grants only"));
  const std::string within =
      format_page({make_planted_report(answer_column({{3, 12}, {4, 12}, {5, 1}, {6, 1}}, material))});
  EXPECT_TRUE(has(within, "in both experiments, 1 has a verdict"));
  EXPECT_FALSE(has(within, "never tested for artifacts, of which"));
  EXPECT_TRUE(has(within, "<td>C5</td>"));
  const std::string free =
      format_page({make_planted_report(answer_column({{5, 1}, {6, 1}, {7, 1}, {8, 1}}, material))});
  EXPECT_TRUE(has(free, "&le; C5 <span class=\"note\">censored_low</span>"));
  EXPECT_TRUE(has(free, "8 of 12 becomes 8 of 11 at most")) << "what leaving one out cannot see";
}

// 9 of 12 at C10: without any of the nine who were right, 8 of 11, it is free; without another, 9 of 11, not.
TEST(Report, names_in_subjects_who_turns_a_column_without_candidates) {
  Report report = make_planted_report(answer_column({{7, 12}, {8, 12}, {9, 12}, {10, 9}}, {}));
  for (const std::int64_t session : {9, 10}) {
    SubjectFinding& finding = report.artifact_subjects.sessions.emplace_back();
    finding.summary.session = session;
  }
  const Table subjects = parse_csv(make_report_files({report}).at("subjects.csv"), "test");
  ASSERT_EQ(subjects.columns[subjects.columns.size() - 2], "turns_paper");
  ASSERT_EQ(subjects.rows.size(), 2U);
  EXPECT_EQ(subjects.rows[0][subjects.columns.size() - 2], "G0-MS-ind-1k") << "the ninth subject";
  EXPECT_EQ(subjects.rows[1][subjects.columns.size() - 2], "");
}

// No artifacts from C0 on, of which everybody finds the material changed: nothing untested is in the way.
TEST(Report, takes_nothing_for_granted_below_the_least_clamped_level) {
  const std::map<int, int> material{{0, 14}, {2, 14}, {4, 14}, {10, 14}};
  const auto page = [&](int first) {
    return format_page({make_planted_report(
        answer_column({{first, 0}, {first + 1, 0}, {first + 2, 0}, {first + 3, 0}}, material))});
  };
  const std::string at_end = page(0), beyond = page(1);
  EXPECT_TRUE(has(at_end, "of two or more subjects in both experiments, 1 has a verdict"));
  EXPECT_FALSE(has(at_end, "<td>C0 <span class=\"note\">censored_low"));
  EXPECT_TRUE(has(beyond, "of two or more subjects in both experiments, 0 have a verdict"));
  EXPECT_TRUE(has(beyond, "(1 more would, but stands on levels alone that were never tested"));
  EXPECT_TRUE(has(at_end, "resamples and does not stand on untested levels alone, are 1 of 1 verdicts"));
}

TEST(Report, marks_no_cut_as_beyond_the_most_clamped_level) {
  const std::string page = format_page(
      {make_planted_report(answer_column({{3, 12}, {4, 12}, {5, 1}, {6, 1}}, {{5, 1}, {7, 1}, {10, 1}}))});
  EXPECT_TRUE(has(page, "<td>C10</td><td></td></tr>"));
  EXPECT_FALSE(has(page, "C10 <span class=\"note\">censored_high"));
}

TEST(Report, says_of_one_subject_that_nothing_was_resampled) {
  PlantedStudy planted = answer_column({{3, 12}, {4, 12}, {5, 1}, {6, 1}}, {{5, 1}, {7, 1}, {10, 1}});
  for (auto* answers : {&planted.artifact, &planted.material})
    std::erase_if(*answers, [](const AnswerRow& answer) { return answer.subject_index > 0; });
  const std::string page = format_page({make_planted_report(planted)});
  EXPECT_TRUE(has(page,
                  "No column has answers of two or more subjects in both experiments. In 1 column an "
                  "experiment has one subject alone: nothing was resampled there"));
  EXPECT_FALSE(has(page, "Of 0 columns"));
}

// 12 of 12 at one half: 2^-12 is 0.0002; 14 of 14: 6.1e-5.
TEST(Report, prints_no_p_as_nothing) {
  const std::string page = format_page(
      {make_planted_report(answer_column({{3, 12}, {4, 12}, {5, 1}, {6, 1}}, {{5, 14}, {7, 14}, {10, 14}}))});
  EXPECT_TRUE(has(page, "<td class=\"number\">0.0002</td>"));
  EXPECT_TRUE(has(page, "<td class=\"number\">&lt; 0.0001</td>"));
  EXPECT_FALSE(has(page, ">0.0000<"));
}

TEST(Report, tells_columns_in_which_nobody_was_asked_about_the_material_apart) {
  const auto page = [](const std::map<int, int>& artifact, const std::map<int, int>& material) {
    return format_page({make_planted_report(answer_column(artifact, material))});
  };
  EXPECT_TRUE(has(page({{7, 12}, {8, 12}, {9, 12}, {10, 12}}, {}),
                  "In 1 of the columns without one nobody was asked about the material: no level was left"));
  EXPECT_FALSE(has(page({{7, 12}, {8, 12}, {9, 1}, {10, 1}}, {{9, 14}, {10, 14}}),
                   "columns without one nobody was asked about the material"));
}

TEST(Report, prints_cuts_below_the_tested_levels_and_bounds_where_nobody_was_asked) {
  const Report below =
      make_planted_report(answer_column({{4, 12}, {5, 12}, {6, 12}, {7, 1}}, {{7, 14}, {9, 14}, {10, 14}}));
  EXPECT_TRUE(has(format_page({below}), "<td>&lt; C7 <span class=\"note\">censored_low</span></td>"));
  EXPECT_TRUE(has(make_report_files({below}).at("thresholds.csv"),
                  "paper,,censored_low,true,true,C7 C9 C10,,none,C6\n"));
  const std::string dropped =
      format_page({make_planted_report(answer_column({{7, 12}, {8, 12}, {9, 12}, {10, 10}}, {}))});
  EXPECT_TRUE(has(dropped, "<td>&minus;</td><td>&ndash;</td><td>&le; 0."));
  EXPECT_TRUE(has(dropped, "no level is left free of artifacts</td>"));
}

}  // namespace
}  // namespace equilux::tests
