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

TEST(Browser, shows_and_prints_the_page_as_it_was_written) {
  if (std::system("chromium --version >/dev/null 2>&1") != 0)  // NOLINT
    GTEST_SKIP() << "needs the Debian package chromium";
  const TempFolder folder;
  const PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  Evidence evidence;
  evidence.kind = SubjectKind::kPlanted;
  evidence.artifact.answers = planted.artifact;
  evidence.material.answers = planted.material;
  const std::string page = format_page(
      {make_report(planted.study, evidence, Rule::kPaper, {planted.selection, {}, {}}, {1, 10, 10})});
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

}  // namespace
}  // namespace equilux::tests
