// The tables of a report: every column explained, the same numbers in all.
#include "analysis/report_tables.h"

#include <array>
#include <boost/math/special_functions/beta.hpp>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>

#include "analysis/answers_export.h"
#include "analysis/interim.h"
#include "analysis/trend_bounds.h"
#include "analysis/views.h"
#include "base/error.h"
#include "tests/analysis/answered_folders.h"

namespace equilux::tests {
namespace {
namespace fs = std::filesystem;

TEST_F(Folders, make_tables_whose_every_column_is_explained) {
  const auto reports = load({"a", "n"});
  auto tables = make_report_tables(reports);
  tables.push_back({"answers.csv", make_answers_table(reports)});
  std::size_t columns = 0;
  const Json metadata = make_csv_metadata(tables);
  for (const Json& table : metadata.at("tables").as_array()) {
    for (const Json& column : table.at("tableSchema").at("columns").as_array()) {
      EXPECT_GT(column.at("dc:description").as_string().size(), 5U);
      ++columns;
    }
  }
  std::size_t expected = 0;
  for (const ReportTable& table : tables) expected += table.table.columns.size();
  EXPECT_EQ(columns, expected);
  EXPECT_THROW(find_entry("cells.csv", "mood"), CheckFailure);
}

std::int64_t sum_column(const Table& table, const std::string& column) {
  std::int64_t sum = 0;
  for (const auto& row : table.rows) sum += std::stoll(row[place_of(table, column)]);
  return sum;
}

TEST_F(Folders, have_the_same_sums_in_every_file) {
  const StudyFolder damaged{temporary_ / "b"};
  erase_answer(damaged, 1, 3);
  const auto reports = load({"a", "b", "n"});
  const auto tables = make_report_tables(reports);
  const Table answers = make_answers_table(reports);
  EXPECT_EQ(sum_column(find_table(tables, "cells.csv"), "n"), std::ssize(answers.rows));
  EXPECT_EQ(sum_column(find_table(tables, "cells.csv"), "k"), sum_column(answers, "correct"));
  EXPECT_EQ(sum_column(find_table(tables, "subjects.csv"), "answered"), std::ssize(answers.rows));
  EXPECT_EQ(sum_column(find_table(tables, "subjects.csv"), "correct"), sum_column(answers, "correct"));
  const Json json = make_report_json(reports);
  EXPECT_EQ(json.at("cells").as_array().size(), find_table(tables, "cells.csv").rows.size());
  EXPECT_EQ(json.at("ee").as_array().size(), 8U + 12U);
  for (const Json& row : json.at("ee").as_array()) {
    const std::string& status = row.at("status_paper").as_string();
    EXPECT_EQ(row.at("ee_paper"), status == "untested" ? Json(nullptr) : Json(status == "exists"));
  }
  EXPECT_EQ(parse_json(format_json(json), "report.json"), json);
}

// Before the material experiment nothing is known of EE but where every level has artifacts.
TEST_F(Folders, leave_ee_empty_where_it_is_untested) {
  make_answered_folder(temporary_ / "half", "pocket", 4, 12, 0);
  const auto reports = load({"half"});
  const auto tables = make_report_tables(reports);
  const Table& ee = find_table(tables, "ee.csv");
  std::size_t untested = 0;
  for (const auto& row : ee.rows) {
    const std::string status = row[place_of(ee, "status_paper")];
    untested += status == "untested" ? 1 : 0;
    EXPECT_EQ(row[place_of(ee, "ee_paper")], status == "untested" ? "" : "false");
  }
  EXPECT_GT(untested, 0U);
  const Json json = make_report_json(reports);
  for (const Json& row : json.at("ee").as_array())
    EXPECT_EQ(row.at("ee_isotonic").is_null(), row.at("status_isotonic").as_string() == "untested");
}

TEST_F(Folders, leave_out_a_trial_without_an_answer_and_say_so) {
  const StudyFolder folder{temporary_ / "b"};
  const Report whole = load({"b"})[0];
  erase_answer(folder, 1, 3);
  const Report report = load({"b"})[0];
  EXPECT_THAT(report.warnings,
              testing::Contains("1 trial of finished artifact sessions has no answer: it is left out."));
  EXPECT_EQ(count_answers(report.artifact), count_answers(whole.artifact) - 1);
  EXPECT_EQ(report.material, whole.material);
  const InterimFindings interim = load_interim(folder, report.study, SubjectKind::kPlanted);
  for (std::size_t c = 0; c < interim.columns.size(); ++c)
    EXPECT_EQ(interim.columns[c].artifact, report.findings[c].artifact);
  EXPECT_NE(format_page({report}).find("AND answer IS NOT NULL GROUP BY cell"), std::string::npos);
  EXPECT_THAT(load({"a", "b"})[0].warnings, testing::Contains(testing::HasSubstr("has no answer")));
}

// A person without whom a verdict is another, or some level free of artifacts, is named once for each such
// column.
TEST_F(Folders, name_in_subjects_whom_the_flips_of_ee_count) {
  const auto tables = make_report_tables(load({"b", "n"}));
  const Table &subjects = find_table(tables, "subjects.csv"), &ee = find_table(tables, "ee.csv");
  std::int64_t all = 0;
  for (const std::string rule : {"paper", "isotonic"}) {
    std::int64_t named = 0, counted = 0, of_free = 0;
    for (const auto& row : subjects.rows) {
      const std::string& keys = row[place_of(subjects, "turns_" + rule)];
      named += keys.empty() ? 0 : 1 + std::count(keys.begin(), keys.end(), ' ');
    }
    for (const auto& row : ee.rows) {
      const std::string& flips = row[place_of(ee, "flips_" + rule)];
      counted += flips.empty() ? 0 : std::stoll(flips);
      const std::string& free = row[place_of(ee, "free_flips_" + rule)];
      of_free += free.empty() ? 0 : std::stoll(free);
    }
    EXPECT_EQ(named, counted + of_free) << rule;
    all += named;
  }
  EXPECT_GT(all, 0);
}

TEST_F(Folders, say_in_every_row_whose_answers_it_has) {
  const auto kinds_of = [](const Table& table) {
    std::set<std::string> kinds;
    for (const auto& row : table.rows) kinds.insert(row.at(place_of(table, "kind")));
    return kinds;
  };
  auto reports = load({"a", "n"});
  for (const char* kind : {"planted", "person"}) {
    for (const ReportTable& table : make_report_tables(reports))
      EXPECT_THAT(kinds_of(table.table), testing::ElementsAre(kind)) << table.file;
    EXPECT_THAT(kinds_of(make_answers_table(reports)), testing::ElementsAre(kind));
    for (Report& report : reports) report.evidence.kind = SubjectKind::kPerson;
  }
}

TEST_F(Folders, trace_what_the_page_alone_would_say) {
  Report report = load({"a"})[0];
  report.flipped_without_marked = {report.findings[2].column, report.findings[5].column};
  const Json study = make_report_json({report}).at("studies").at(0);
  EXPECT_EQ(study.at("flipped_without_marked"),
            make_json({format_key(report.findings[2].column), format_key(report.findings[5].column)}));
  // Half of Beta(1/2, 1/2) and more lies below one half: by numbers, cell by cell.
  for (const auto& [name, tally] :
       {std::pair("artifact", &report.artifact), {"material", &report.material}}) {
    double most = 0;
    for (const auto& [cell, count] : *tally) {
      if (count.n == 0) continue;
      const double a = static_cast<double>(count.k) + .5, b = static_cast<double>(count.n - count.k) + .5;
      const double over = boost::math::ibetac(a, b, .75);
      most = std::max(most, over / boost::math::ibetac(a, b, .5) - over);
    }
    EXPECT_NEAR(study.at(name).at("prior_cut_off_adds_at_most").as_double(), most, 1e-12) << name;
  }
  const std::string page = format_page({report});
  EXPECT_NE(page.find("report.json (<code>flipped_without_marked</code>)"), std::string::npos);
  EXPECT_NE(page.find("report.json (<code>prior_cut_off_adds_at_most</code>)"), std::string::npos);
}

// Of three trends that compare something the least p is thrice itself, then twice the next, and no less.
TEST(LeastHolm, corrects_the_least_p_of_trends_that_compare_something) {
  std::vector<Trend> trends(4);
  const double least[] = {.01, .5, .02, .015};
  for (std::size_t i = 0; i < 4; ++i) {
    trends[i].p_least = least[i];
    trends[i].status = i == 1 ? TrendStatus::kNoPairs : TrendStatus::kTested;
  }
  const std::vector<double> holm = find_least_holm(trends);
  ASSERT_EQ(holm.size(), 4U);
  EXPECT_DOUBLE_EQ(holm[0], .03);
  EXPECT_DOUBLE_EQ(holm[1], 1);
  EXPECT_DOUBLE_EQ(holm[2], .03);
  EXPECT_DOUBLE_EQ(holm[3], .03);
}

// Trials go v0, v0, ... in these folders: one more view by hand.
TEST_F(Folders, count_correct_answers_by_view) {
  RawDatabase(StudyFolder{temporary_ / "a"}.responses())
      .query("UPDATE trial SET test_key = replace(test_key, '-v0', '-v1') WHERE trial % 3 = 1");
  const Report report = load({"a"})[0];
  std::array<Count, 2> expected{};
  std::map<std::int64_t, int> trials;
  for (const CountedAnswer& answer : report.evidence.material.answers.rows()) {
    Count& count = expected[trials[answer.session]++ % 3 == 1 ? 1 : 0];
    ++count.n;
    count.k += answer.correct ? 1 : 0;
  }
  ASSERT_TRUE(count_by_view(report.evidence.material));
  EXPECT_EQ(*count_by_view(report.evidence.material), expected);
  EXPECT_EQ(make_report_json({report}).at("studies").at(0).at("material").at("by_view").at("v1").at("k"),
            Json(expected[1].k));
  const std::string row =
      fmt::format("<tr><td>material</td><td class=\"number\">{} of {}</td>", expected[0].k, expected[0].n);
  EXPECT_NE(format_page({report}).find(row), std::string::npos);
  erase_answer(StudyFolder{temporary_ / "a"}, 1, 3);
  const Report damaged = load({"a"})[0];
  const auto whole = count_by_view(report.evidence.artifact), rest = count_by_view(damaged.evidence.artifact);
  ASSERT_TRUE(whole && rest);
  EXPECT_EQ((*rest)[0].n, (*whole)[0].n - 1) << "the fourth trial was of v0";
  EXPECT_EQ((*rest)[1], (*whole)[1]);
  EXPECT_TRUE(count_by_view(damaged.evidence.material));
  EXPECT_FALSE(count_by_view(ExperimentEvidence{}));
}

TEST_F(Folders, write_no_number_that_is_not_finite) {
  for (const ReportTable& table : make_report_tables(load({"a", "b", "n"}))) {
    for (const auto& row : table.table.rows) {
      for (const std::string& field : row) {
        EXPECT_NE(field, "nan");
        EXPECT_NE(field, "-nan");
        EXPECT_NE(field, "inf");
      }
    }
  }
}

}  // namespace
}  // namespace equilux::tests
