// The page in a real browser, offline: it opens, draws what it holds, and prints.
#include <cstdlib>
#include <gtest/gtest.h>

#include "analysis/report.h"
#include "base/files.h"
#include "tests/analysis/columns.h"
#include "tests/experiment/child.h"
#include "tests/support/temp_folder.h"

namespace equilux::tests {
namespace {

std::vector<std::string> with_chromium(const TempFolder& folder, std::vector<std::string> words) {
  std::vector<std::string> all = {"chromium",
                                  "--headless=new",
                                  "--no-sandbox",
                                  "--disable-gpu",
                                  "--disable-dev-shm-usage",
                                  "--host-resolver-rules=MAP * ~NOTFOUND",
                                  "--user-data-dir=" + (folder / "profile").string()};
  all.insert(all.end(), words.begin(), words.end());
  return all;
}

int count(const std::string& text, const std::string& word) {
  int found = 0;
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + word.size())) ++found;
  return found;
}

Report make_small_report(const PlantedStudy& planted) {
  Evidence evidence;
  evidence.kind = SubjectKind::kPlanted;
  evidence.artifact.answers = planted.artifact;
  evidence.material.answers = planted.material;
  for (const char* participant : {"planted-1-0", "planted-1-1"}) {
    SessionSummary summary;
    summary.participant = participant;
    summary.complete = true;
    evidence.artifact.summaries.push_back(summary);
  }
  return make_report(planted.study, evidence, Rule::kPaper, {planted.selection, {}, {}}, {1, 10, 10});
}

TEST(Browser, shows_and_prints_the_page_as_it_was_written) {
  if (std::system("chromium --version >/dev/null 2>&1") != 0)  // NOLINT
    GTEST_SKIP() << "needs the Debian package chromium";
  const TempFolder folder;
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  const std::string page = format_page({make_small_report(planted)});
  save_text(folder / "index.html", page);
  const std::string url = "file://" + (folder / "index.html").string();
  const ChildResult shown = Child("/usr/bin/env", with_chromium(folder, {"--dump-dom", url})).wait();
  ASSERT_EQ(shown.exit_code, 0) << shown.err;
  // What a browser would move, close or drop changes the counts.
  for (const char* tag : {"<svg", "<table", "<section", "<details", "class=\"cell\"", "<pattern"})
    EXPECT_EQ(count(shown.out, tag), count(page, tag)) << tag;
  const std::string pdf = (folder / "page.pdf").string();
  const ChildResult printed =
      Child("/usr/bin/env", with_chromium(folder, {"--print-to-pdf=" + pdf, url})).wait();
  ASSERT_EQ(printed.exit_code, 0) << printed.err;
  const std::string bytes = load_text(pdf);
  EXPECT_TRUE(bytes.starts_with("%PDF"));
  EXPECT_GE(count(bytes, "/Type /Page\n") + count(bytes, "/Type /Page "), 2) << "pages";
}

// The text of the printed page, by pdftotext; lines as they stand on the paper.
std::string print_to_text(const TempFolder& folder, const std::string& page) {
  save_text(folder / "index.html", page);
  const std::string pdf = (folder / "page.pdf").string();
  const std::string url = "file://" + (folder / "index.html").string();
  const ChildResult printed =
      Child("/usr/bin/env", with_chromium(folder, {"--print-to-pdf=" + pdf, url})).wait();
  EXPECT_EQ(printed.exit_code, 0) << printed.err;
  return Child("/usr/bin/env", {"pdftotext", "-layout", pdf, "-"}).wait().out;
}

// What is folded on screen: columns, sessions, cells. The mutant is the page without its rule for print.
TEST(Browser, prints_what_is_folded_on_the_screen) {
  if (std::system("chromium --version >/dev/null 2>&1 && command -v pdftotext >/dev/null") != 0)  // NOLINT
    GTEST_SKIP() << "needs the Debian packages chromium and poppler-utils";
  const TempFolder folder;
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  const Report report = make_small_report(planted);
  std::string page = format_page({report});
  const std::string text = print_to_text(folder, page);
  for (const auto* cells : {&report.artifact_cells, &report.material_cells}) {
    for (const auto& [cell, statistics] : *cells) {
      if (statistics.estimate) {
        EXPECT_NE(text.find(format_key(cell)), std::string::npos) << format_key(cell);
      }
    }
  }
  for (const char* words : {"Each of the 8 columns", "Each of the 2 sessions", "planted-1-0", "planted-1-1",
                            "P(over 75", "agreement"})
    EXPECT_NE(text.find(words), std::string::npos) << words << "\n" << text;
  const std::size_t rule = page.find("details::details-content");
  ASSERT_NE(rule, std::string::npos);
  page.replace(rule, 7, "unknown");
  EXPECT_EQ(print_to_text(folder, page).find("planted-1-0"), std::string::npos);
}

}  // namespace
}  // namespace equilux::tests
