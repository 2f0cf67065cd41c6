// Two thresholds to green, red and the verdict.
#include "analysis/equivalence.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "analysis/tables.h"
#include "tests/analysis/columns.h"

namespace equilux::tests {
namespace {

// One column of the pocket study with these counts; all others untested.
class Bench {
 public:
  Bench() : study(load_protocol("pocket")), column(enumerate_columns(study).front()) {
    artifact = tally_answers({}, study);
    material = artifact;
  }
  void set(Tally& tally, const std::vector<std::pair<int, Count>>& counts) {
    for (const auto& [level, count] : counts) tally[Cell{column, level, false}] = count;
  }
  ColumnFinding find(const Selection* selection = nullptr) const {
    return find_equivalence(study, artifact, material, selection).front();
  }

  Study study;
  Column column;
  Tally artifact;
  Tally material;
};

std::string regions_of(const RuleFinding& finding) {
  std::string text;
  for (const Region region : finding.regions) text += "AMBE?"[static_cast<int>(region)];
  return text;
}

TEST(Equivalence, exists_where_a_level_is_artifact_free_and_unchanged) {
  Bench bench;
  bench.set(bench.artifact, {{3, {12, 12}}, {4, {10, 12}}, {5, {5, 12}}, {6, {6, 12}}});
  bench.set(bench.material, {{5, {7, 14}}, {7, {8, 14}}, {9, {12, 14}}, {10, {14, 14}}});
  const auto paper = bench.find().under(Rule::kPaper);
  EXPECT_EQ(regions_of(paper), "AAAAAEEE?MM");
  EXPECT_EQ(paper.verdict, Verdict::kExists);
  EXPECT_EQ(paper.green, (std::vector<int>{5, 6, 7}));
  EXPECT_EQ(paper.supported, std::vector<int>{5}) << "5 of 12 and 7 of 14; 7 was not in the window";
  EXPECT_TRUE(paper.untested.empty());
}

// Of a true 70 % 7 of 14 come with probability .093, of 75 % with .038; of 80 % 6 of 12 with .019, of 75 %
// with .054.
TEST(Equivalence, is_supported_against_the_proportion_at_which_cells_are_flagged) {
  Bench bench;
  bench.set(bench.artifact, {{3, {12, 12}}, {4, {12, 12}}, {5, {5, 12}}, {6, {6, 12}}});
  bench.set(bench.material, {{5, {7, 14}}, {6, {5, 14}}, {9, {14, 14}}, {10, {14, 14}}});
  const auto supported_at = [&](int percent) {
    return find_equivalence(bench.study, bench.artifact, bench.material, nullptr, percent)
        .front()
        .under(Rule::kPaper)
        .supported;
  };
  EXPECT_EQ(supported_at(70), std::vector<int>{});
  EXPECT_EQ(supported_at(75), std::vector<int>{5});
  EXPECT_EQ(supported_at(80), (std::vector<int>{5, 6}));
}

TEST(Equivalence, has_none_where_the_first_surviving_level_has_changed) {
  Bench bench;
  bench.set(bench.artifact, {{3, {12, 12}}, {4, {10, 12}}, {5, {5, 12}}, {6, {6, 12}}});
  bench.set(bench.material, {{5, {14, 14}}, {7, {14, 14}}, {9, {14, 14}}, {10, {14, 14}}});
  const auto paper = bench.find().under(Rule::kPaper);
  EXPECT_EQ(regions_of(paper), "AAAAAMMMMMM");
  EXPECT_EQ(paper.verdict, Verdict::kNone);
}

// Under `isotonic` C8 to C10 are pooled to 17 of 36 and free: pruning by `paper` asked nobody about them.
TEST(Equivalence, of_a_dropped_column_is_untested_under_a_rule_that_would_have_kept_levels) {
  Bench bench;
  bench.set(bench.artifact, {{7, {12, 12}}, {8, {4, 12}}, {9, {4, 12}}, {10, {9, 12}}});
  const Selection selection =
      make_selection(bench.study, bench.artifact, SubjectKind::kPerson, Rule::kPaper, "digest");
  const ColumnFinding finding = bench.find(&selection);
  EXPECT_TRUE(finding.dropped);
  EXPECT_EQ(finding.under(Rule::kPaper).verdict, Verdict::kNone);
  EXPECT_EQ(finding.under(Rule::kIsotonic).artifact.cut, 8);
  EXPECT_EQ(finding.under(Rule::kIsotonic).verdict, Verdict::kUntested);
}

// 9 of 12 is flagged at 75 %, not at 80 %: a level would be left there, and nobody was asked about it. 10 of
// 12 is flagged at all three.
TEST(Equivalence, of_a_dropped_column_is_untested_at_a_cut_that_would_not_have_dropped_it) {
  Bench bench;
  const auto verdict_at = [&](std::int64_t last, int percent) {
    bench.set(bench.artifact, {{7, {12, 12}}, {8, {12, 12}}, {9, {12, 12}}, {10, {last, 12}}});
    const Selection selection =
        make_selection(bench.study, bench.artifact, SubjectKind::kPerson, Rule::kPaper, "digest");
    return find_equivalence(bench.study, bench.artifact, bench.material, &selection, percent)
        .front()
        .under(Rule::kPaper)
        .verdict;
  };
  EXPECT_EQ(verdict_at(9, 70), Verdict::kNone);
  EXPECT_EQ(verdict_at(9, 75), Verdict::kNone);
  EXPECT_EQ(verdict_at(9, 80), Verdict::kUntested);
  EXPECT_EQ(verdict_at(10, 80), Verdict::kNone);
}

TEST(Equivalence, of_a_column_that_waits_for_its_material_answers_is_untested) {
  Bench bench;
  bench.set(bench.artifact, {{3, {12, 12}}, {4, {10, 12}}, {5, {5, 12}}, {6, {6, 12}}});
  EXPECT_EQ(bench.find().under(Rule::kPaper).verdict, Verdict::kUntested);
  EXPECT_EQ(regions_of(bench.find().under(Rule::kPaper)), "AAAAA??????");
}

TEST(Equivalence, of_a_column_without_answers_is_untested_and_never_green) {
  const auto paper = Bench().find().under(Rule::kPaper);
  EXPECT_EQ(paper.verdict, Verdict::kUntested);
  EXPECT_EQ(regions_of(paper), "???????????");
}

TEST(Equivalence, with_artifacts_at_every_level_needs_no_material_answers_to_be_none) {
  Bench bench;
  bench.set(bench.artifact, {{7, {12, 12}}, {8, {12, 12}}, {9, {12, 12}}, {10, {12, 12}}});
  EXPECT_EQ(bench.find().under(Rule::kPaper).verdict, Verdict::kNone);
}

TEST(Equivalence, says_which_levels_the_other_rule_would_have_kept) {
  Bench bench;
  bench.set(bench.artifact, {{3, {12, 12}}, {4, {5, 12}}, {5, {9, 12}}, {6, {3, 12}}});
  bench.set(bench.material, {{6, {7, 14}}, {8, {7, 14}}, {10, {14, 14}}});
  const ColumnFinding finding = bench.find();
  EXPECT_TRUE(finding.under(Rule::kPaper).untested.empty());
  EXPECT_EQ(finding.under(Rule::kIsotonic).artifact.cut, 4);
  EXPECT_EQ(finding.under(Rule::kIsotonic).untested, std::vector<int>{4});
  EXPECT_EQ(finding.under(Rule::kIsotonic).green, (std::vector<int>{6, 7, 8}));
}

TEST(Equivalence, shows_a_level_with_artifacts_and_a_changed_material_as_both) {
  Bench bench;
  bench.set(bench.artifact, {{3, {12, 12}}, {4, {5, 12}}, {5, {9, 12}}, {6, {3, 12}}});
  bench.set(bench.material, {{4, {14, 14}}, {6, {14, 14}}, {8, {14, 14}}, {10, {14, 14}}});
  EXPECT_EQ(regions_of(bench.find().under(Rule::kPaper)), "AAAABBMMMMM");
}

TEST(Equivalence, is_the_same_in_findings_table_and_text) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 5, 0.02);
  const auto findings = find_in(planted);
  const Table table = make_ee_table(findings);
  ASSERT_EQ(table.rows.size(), 8U);
  EXPECT_EQ(
      (std::vector<std::string>(table.columns.begin(), table.columns.begin() + 6)),
      (std::vector<std::string>{"geometry", "material", "illumination", "vpls", "ee_paper", "ee_isotonic"}));
  std::size_t marks = 0;
  for (std::size_t i = 0; i < findings.size(); ++i) {
    const bool exists = !findings[i].under(Rule::kPaper).green.empty();
    EXPECT_EQ(table.rows[i][4], exists ? "true" : "false");
    marks += exists ? 1 : 0;
  }
  std::string text = format_ee_text(planted.study, findings, Rule::kPaper);
  text.resize(text.find("  + some"));
  EXPECT_EQ(static_cast<std::size_t>(std::count(text.begin(), text.end(), '+')), marks) << text;
}

TEST(Tables, list_every_cell_of_both_experiments_with_empty_proportions_where_nobody_was_asked) {
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 6, 0.02);
  const Tally artifact = tally_answers(planted.artifact, planted.study);
  const Tally material = tally_answers(planted.material, planted.study);
  const Table table = make_cells_table(planted.study, artifact, material);
  EXPECT_EQ(format_csv(table).substr(0, 82),
            "experiment,geometry,material,illumination,vpls,clamp,k,n,proportion,p_guess\nartifa");
  EXPECT_EQ(table.rows.size(), 2U * 88U);
  std::int64_t answers = 0;
  for (const auto& row : table.rows) {
    answers += std::stoll(row[7]);
    EXPECT_EQ(row[7] == "0", row[8].empty());
    EXPECT_EQ(row[7] == "0", row[9].empty());
  }
  EXPECT_EQ(answers, count_answers(artifact) + count_answers(material));
  EXPECT_EQ(parse_csv(format_csv(table), "cells.csv"), table);
}

TEST(Tables, of_a_normalised_study_call_its_cells_so) {
  const Study study = load_protocol("normalisation");
  const Tally none = tally_answers({}, study);
  const Table table = make_cells_table(study, none, none);
  EXPECT_EQ(table.rows.size(), 2U * 132U);
  EXPECT_EQ(table.rows.front()[5], "C0n");
}

TEST(Tables, of_the_validation_study_leave_a_dot_where_it_has_no_column) {
  const Study study = load_protocol("validation");
  const Tally none = tally_answers({}, study);
  const std::string text = format_ee_text(study, find_equivalence(study, none, none, nullptr), Rule::kPaper);
  EXPECT_NE(text.find("marks: 1k, 100k, 5M, 25M"), std::string::npos) << text;
  EXPECT_NE(text.find("  Bunny   .???  .???  .??.  .??.  .??.  ???.\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace equilux::tests
