// The files of a report: figures, the same bytes when reported again, and what an older report leaves.

#include <chrono>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <set>
#include <thread>

#include "analysis/answers_export.h"
#include "analysis/figure.h"
#include "base/error.h"
#include "base/program.h"
#include "tests/analysis/answered_folders.h"

namespace equilux::tests {
namespace {
namespace fs = std::filesystem;

TEST_F(Folders, make_a_figure_for_each_illumination_and_one_of_plain_above_normalised) {
  make_answered_folder(temporary_ / "paper", "paper", 4, 3, 3);
  const auto reports = load({"paper", "n"});
  const auto figures = make_figures(reports);
  std::vector<std::string> names;
  for (const Figure& figure : figures) names.push_back(figure.name);
  EXPECT_EQ(names, (std::vector<std::string>{"figure-paper-ind", "figure-paper-dir",
                                             "figure-normalisation-ind", "figure-paper+normalisation"}));
  EXPECT_EQ(figures[0].panels.size(), 20U);
  EXPECT_EQ(figures[3].width, 4U);
  EXPECT_EQ(figures[3].panels.size(), 8U);
  const std::string text = format_figure(figures[3], Rule::kPaper, FigureFormat::kPdf, "it's.pdf");
  EXPECT_NE(text.find("set output 'it''s.pdf'"), std::string::npos);
}

std::size_t count_parts(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

// What follows the line that opens a block of cells with this drawing in the panel: its rows.
std::size_t count_cells(const std::string& text, const std::string& label) {
  std::size_t count = 0;
  for (auto at = text.find(", $b"); at != std::string::npos; at = text.find(", $b", at + 1)) {
    const std::string block = text.substr(at + 2, text.find(' ', at + 2) - at - 2);
    if (!text.substr(at).starts_with(", " + block + " using 1:2:('" + label + "')")) continue;
    const auto begin = text.rfind(block + " << EOD\n", at);
    count += count_parts(text.substr(begin, text.find("\nEOD", begin) - begin), " 0.5 0.5");
  }
  return count;
}

// Of each E and (E): whether both experiments were asked there; and of each frame: whether it is supported.
TEST_F(Folders, make_figures_that_say_whose_answers_they_show_and_tell_tested_levels_from_inferred_ones) {
  auto reports = load({"a"});
  std::size_t asked = 0, inferred = 0, supported = 0;
  for (const ColumnFinding& column : reports[0].findings) {
    const RuleFinding& under = column.under(Rule::kPaper);
    supported += under.supported.size();
    for (const int level : under.green) {
      const auto i = static_cast<std::size_t>(level);
      ++(column.artifact[i].count.n > 0 && column.material[i].count.n > 0 ? asked : inferred);
    }
  }
  ASSERT_GT(asked, 0U);
  ASSERT_GT(inferred, 0U);
  ASSERT_GT(supported, 0U);
  const auto format = [&] {
    return format_figure(make_figures(reports)[0], Rule::kPaper, FigureFormat::kSvg, "x.svg");
  };
  const std::string text = format();
  EXPECT_EQ(count_cells(text, "E"), asked);
  EXPECT_EQ(count_cells(text, "(E)"), inferred);
  EXPECT_EQ(count_parts(text, " 0.42 0.40\n"), supported);
  EXPECT_NE(text.find("PLANTED SUBJECTS"), std::string::npos);
  EXPECT_NE(text.find("rule paper"), std::string::npos);
  EXPECT_EQ(count_parts(text, "set xlabel 'VPLs'"), 4U);
  EXPECT_EQ(count_parts(text, "set ylabel 'clamp level, C10 most clamped'"), 4U);
  reports[0].evidence.kind = SubjectKind::kPerson;
  EXPECT_EQ(format().find("PLANTED"), std::string::npos);
  EXPECT_NE(format().find("answers of persons"), std::string::npos);
}

// A normalised study of the name of an illumination.
TEST_F(Folders, make_no_two_figures_of_one_name) {
  auto reports = load({"n"});
  Report plain = reports[0];
  plain.study.name = "main";
  plain.study.normalise = false;
  reports[0].study.name = "ind";
  reports.push_back(std::move(plain));
  std::vector<std::string> names;
  for (const Figure& figure : make_figures(reports)) names.push_back(figure.name);
  EXPECT_THAT(names, testing::UnorderedElementsAre("figure-ind-ind", "figure-main-ind", "figure-main+ind"));
}

TEST_F(Folders, are_drawn_by_gnuplot_as_svg_and_pdf) {
  const ReportFiles files = draw_figures(load({"a"}));
  ASSERT_EQ(files.size(), 2U);
  EXPECT_TRUE(files.at("figure-pocket-ind.pdf").starts_with("%PDF"));
  for (const char* word : {"G0 MS", "G2 GS", "100k", "C10"})
    EXPECT_NE(files.at("figure-pocket-ind.svg").find(word), std::string::npos) << word;
}

// A second and more between them, which a time of day would show.
TEST_F(Folders, reported_twice_give_the_same_bytes_in_every_file) {
  AnalyzeParams params = make_params({temporary_ / "a"}, temporary_ / "one");
  params.plot = true;
  ASSERT_EQ(run_report(params), 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  params.out = temporary_ / "two";
  ASSERT_EQ(run_report(params), 0);
  const auto one = read_files(temporary_ / "one"), two = read_files(temporary_ / "two");
  ASSERT_EQ(one.size(), two.size());
  EXPECT_TRUE(one.contains("figure-pocket-ind.pdf") && one.contains(kReportList));
  for (const auto& [name, bytes] : one) EXPECT_TRUE(bytes == two.at(name)) << name;
}

TEST_F(Folders, exported_again_replace_other_answers_only_when_told_to) {
  const fs::path out = temporary_ / "answers";
  const auto run = [&](const std::string& name, bool force) {
    AnalyzeParams params = make_params({temporary_ / name}, out);
    params.force = force;
    EXPECT_EQ(run_export(params), kExitOk);
    return read_files(out);
  };
  const auto refusal_of = [&](const std::string& name) {
    return message_of<InputError>([&] { run(name, false); });
  };
  const auto first = run("a", false);
  EXPECT_EQ(run("a", false), first);
  EXPECT_EQ(refusal_of("b"), (out / "answers.csv").string() +
                                 ": expected a free name or a file with the same bytes, got one with others; "
                                 "--force replaces an earlier export");
  EXPECT_EQ(read_files(out), first);
  EXPECT_NE(run("b", true), first);
  save_text(out / "csv-metadata.json", "{}");
  const auto edited = read_files(out);
  EXPECT_THAT(refusal_of("b"), testing::HasSubstr("csv-metadata.json: expected a free name"));
  EXPECT_EQ(read_files(out), edited);
}

// Each report as the program writes it, one after another into one folder.
TEST_F(Folders, reported_again_with_fewer_figures_or_studies_leave_no_file_of_the_report_before) {
  const auto report = [&](const std::vector<fs::path>& folders, Rule rule, bool plot, const fs::path& out) {
    AnalyzeParams params = make_params(folders, out);
    params.rule = rule;
    params.plot = plot;
    testing::internal::CaptureStdout();
    EXPECT_EQ(run_report(params), kExitOk);
    return testing::internal::GetCapturedStdout();
  };
  const fs::path a = temporary_ / "a", n = temporary_ / "n", out = temporary_ / "out";
  report({a, n}, Rule::kPaper, true, out);
  EXPECT_TRUE(is_file(out / "figure-normalisation-ind.pdf"));
  EXPECT_TRUE(is_file(out / "graph-normalisation-G0-MR-ind.svg"));
  report({a}, Rule::kIsotonic, true, out);
  EXPECT_FALSE(is_file(out / "figure-normalisation-ind.pdf"));
  EXPECT_FALSE(is_file(out / "graph-normalisation-G0-MR-ind.svg"));
  EXPECT_TRUE(is_file(out / "figure-pocket-ind.svg"));
  save_text(out / "notes.txt", "mine");
  const std::string said = report({a}, Rule::kIsotonic, false, out);
  EXPECT_NE(said.find("not of this report, left as found: notes.txt"), std::string::npos) << said;
  fs::remove(out / "notes.txt");
  report({a}, Rule::kIsotonic, false, temporary_ / "fresh");
  EXPECT_EQ(read_files(out), read_files(temporary_ / "fresh"));
}

}  // namespace
}  // namespace equilux::tests
