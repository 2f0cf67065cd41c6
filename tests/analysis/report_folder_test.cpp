// A folder in which reports follow one another: what is removed, what is left, and what a cut leaves.
#include "analysis/report_folder.h"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/files.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux::tests {
namespace {
namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const ReportFiles kMany = {{"cells.csv", "many cells"},
                           {"figure-pocket-ind.svg", "drawn"},
                           {"graph-paper-G0-MS-ind.svg", "graph"},
                           {"index.html", "many"}};
const ReportFiles kFew = {{"cells.csv", "few cells"}, {"index.html", "few"}};

class ReportFolder : public ::testing::Test {
 protected:
  // But the list.
  ReportFiles read() const {
    ReportFiles files;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (name != kReportList) files[name] = entry.is_directory() ? "a folder" : load_text(entry.path());
    }
    return files;
  }

  const TempFolder temporary_{find_memory_folder()};
  const fs::path folder_ = temporary_ / "report";
};

TEST_F(ReportFolder, holds_the_last_report_and_nothing_of_those_before) {
  for (const ReportFiles& files : {kMany, kFew, kMany, kFew}) {
    EXPECT_THAT(save_report(files, folder_), IsEmpty());
    EXPECT_EQ(read(), files);
  }
}

TEST_F(ReportFolder, has_the_same_bytes_whatever_stood_there_before) {
  save_report(kFew, folder_);
  const std::string fresh = load_text(folder_ / kReportList);
  save_report(kMany, folder_);
  save_report(kFew, folder_);
  EXPECT_EQ(load_text(folder_ / kReportList), fresh);
}

TEST_F(ReportFolder, keeps_and_names_files_that_no_report_wrote) {
  make_folder(folder_);
  save_text(folder_ / "figure-mine.svg", "mine");
  make_folder(folder_ / "notes");
  save_report(kMany, folder_);
  EXPECT_THAT(save_report(kFew, folder_), ElementsAre("figure-mine.svg", "notes"));
  EXPECT_EQ(read().at("figure-mine.svg"), "mine");
}

TEST_F(ReportFolder, keeps_a_file_of_an_earlier_report_that_was_changed_or_replaced_since) {
  save_report(kMany, folder_);
  save_text(folder_ / "figure-pocket-ind.svg", "drawn, and edited");
  save_text(temporary_ / "elsewhere.svg", "graph");
  fs::remove(folder_ / "graph-paper-G0-MS-ind.svg");
  fs::create_symlink(temporary_ / "elsewhere.svg", folder_ / "graph-paper-G0-MS-ind.svg");
  EXPECT_THAT(save_report(kFew, folder_), ElementsAre("figure-pocket-ind.svg", "graph-paper-G0-MS-ind.svg"));
  EXPECT_EQ(read().at("figure-pocket-ind.svg"), "drawn, and edited");
  EXPECT_EQ(load_text(temporary_ / "elsewhere.svg"), "graph");
}

// Changed files of the last report too; the same bytes are no matter.
TEST_F(ReportFolder, replaces_under_its_names_nothing_that_no_report_wrote_unless_told_to) {
  make_folder(folder_);
  save_text(folder_ / "index.html", "a page of mine");
  save_text(folder_ / "cells.csv", kFew.at("cells.csv"));
  EXPECT_THAT(message_of<InputError>([&] { save_report(kFew, folder_); }),
              AllOf(HasSubstr("index.html: expected"), HasSubstr("one of no report; --force replaces it")));
  EXPECT_EQ(read().at("index.html"), "a page of mine");
  EXPECT_FALSE(fs::exists(folder_ / kReportList));
  EXPECT_THAT(save_report(kFew, folder_, true), IsEmpty());
  EXPECT_EQ(read(), kFew);
  save_text(folder_ / "cells.csv", "cells, with my notes");
  EXPECT_THAT(message_of<InputError>([&] { save_report(kMany, folder_); }),
              AllOf(HasSubstr("cells.csv: expected"), HasSubstr("changed since; --force replaces it")));
  EXPECT_EQ(read(), (ReportFiles{{"cells.csv", "cells, with my notes"}, {"index.html", "few"}}));
  save_report(kMany, folder_, true);
  EXPECT_EQ(read(), kMany);
}

TEST_F(ReportFolder, replaces_a_report_of_a_build_that_left_no_list) {
  make_folder(folder_);
  save_text(folder_ / "index.html", "an older page");
  save_text(folder_ / "report.json", R"({"schema": "equilux-report", "schema_version": 1})");
  EXPECT_THAT(save_report(kFew, folder_), ElementsAre("report.json"));
  EXPECT_EQ(read().at("index.html"), "few");
}

TEST_F(ReportFolder, does_not_miss_a_file_that_was_deleted) {
  save_report(kMany, folder_);
  fs::remove(folder_ / "figure-pocket-ind.svg");
  EXPECT_THAT(save_report(kFew, folder_), IsEmpty());
  EXPECT_EQ(read(), kFew);
}

// A folder under a file's name stops the report there, as a full disk would: `stop` is in turn every name.
TEST_F(ReportFolder, after_a_cut_has_the_earlier_page_with_its_files_and_is_whole_again_with_the_next) {
  const ReportFiles next = {{"a.csv", "1"}, {"cells.csv", "new"}, {"index.html", "new"}, {"z.csv", "2"}};
  for (const char* stop : {"a.csv", "z.csv"}) {
    fs::remove_all(folder_);
    save_report(kMany, folder_);
    make_folder(folder_ / stop);
    EXPECT_THROW(save_report(next, folder_), StoreError);
    for (const char* kept : {"index.html", "figure-pocket-ind.svg", "graph-paper-G0-MS-ind.svg"})
      EXPECT_EQ(load_text(folder_ / kept), kMany.at(kept)) << stop;
    fs::remove(folder_ / stop);
    EXPECT_THAT(save_report(kFew, folder_), IsEmpty()) << "what the cut report wrote is known too";
    EXPECT_EQ(read(), kFew) << stop;
  }
}

TEST_F(ReportFolder, refuses_a_list_that_it_cannot_read_before_it_writes_anything) {
  const std::string head = R"({"schema": "equilux-report-files", "schema_version": 1, "files": )";
  for (const auto& [list, place] : std::vector<std::pair<std::string, std::string>>{
           {"[", "report-files.json"},
           {R"({"schema": "equilux-report"})", "/schema: expected"},
           {R"({"schema": "equilux-report-files", "schema_version": 2, "files": []})",
            "/schema_version: exp"},
           {head + "3}", "/files: expected an array"},
           {head + R"([{"file": "../elsewhere.svg", "digest": ""}]})",
            "/files/0/file: expected a file's name"},
           {head + R"([{"file": "..", "digest": ""}]})", "/files/0/file: expected a file's name"},
           {head + R"([{"file": "a.svg"}]})", "/files/0/digest: expected a string"}}) {
    fs::remove_all(folder_);
    make_folder(folder_);
    save_text(folder_ / kReportList, list);
    EXPECT_THAT(message_of<InputError>([&] { save_report(kFew, folder_); }), HasSubstr(place)) << list;
    EXPECT_THAT(read(), IsEmpty());
  }
}

}  // namespace
}  // namespace equilux::tests
