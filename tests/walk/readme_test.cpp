// Every command of README.md, run in its order as a reader would, and what README says is there afterwards.
// The small built-in study is rendered here, and nowhere else in the tests.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/digest.h"
#include "base/files.h"
#include "stimuli/exr_file.h"
#include "stimuli/manifest.h"
#include "stimuli/png_file.h"
#include "tests/support/temp_folder.h"
#include "tests/walk/programs.h"
#include "tests/walk/readme_commands.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

const fs::path kSource = EQUILUX_SOURCE_DIR;

int count(const std::string& text, const std::string& word) {
  int found = 0;
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + word.size())) ++found;
  return found;
}

class Readme : public ::testing::Test {
 protected:
  // The tree as README's commands see it; what they make stays in this folder.
  void SetUp() override {
    for (const char* name : {"protocols", "stimuli", "docs"}) {
      fs::create_directory_symlink(kSource / name, folder_ / name);
    }
    fs::create_directories(folder_ / "build/release");
    fs::create_directory_symlink(EQUILUX_BIN_DIR, folder_ / "build/release/bin");
  }

  /// Standard output and standard error.
  std::string run(const std::string& command) {
    Child child("/bin/bash", {"-c", R"(cd "$1" && eval "$2")", "bash", folder_.path().string(), command});
    const ChildResult result = child.wait();
    EXPECT_EQ(result.exit_code, 0) << command << "\n" << result.out << result.err;
    EXPECT_EQ((result.out + result.err).find_first_of("\r\033"), std::string::npos) << command;
    return result.out + result.err;
  }

  void check_manifest() {
    const Manifest manifest = load_manifest(study_ / "manifest.json");
    EXPECT_EQ(manifest.pictures.size(), 184u) << "2 x 2 x 1 x 2 x 11 x 2 VPL pictures and 8 references";
    EXPECT_EQ(manifest.tones.size(), 8u);
    for (const auto& [key, picture] : manifest.pictures) {
      EXPECT_EQ(digest_file(study_ / picture.file), picture.digest) << key;
    }
    const LdrImage picture = load_png(study_ / "pictures/G2-GS-ind-100k-C4-v1.png");
    EXPECT_EQ(picture.width, 280);
    EXPECT_EQ(picture.height, 210);
  }

  void check_report() {
    const fs::path report = study_ / "report";
    const std::string page = load_text(report / "index.html");
    EXPECT_THAT(page, AllOf(HasSubstr("lanted"), HasSubstr("</html>")));
    for (const char* name :
         {"cells.csv", "thresholds.csv", "ee.csv", "subjects.csv", "trends.csv", "report.json",
          "csv-metadata.json", "figure-pocket-ind.svg", "figure-pocket-ind.pdf", "graph-G0-MS-ind.svg",
          "graph-G0-GS-ind.svg", "graph-G2-MS-ind.svg", "graph-G2-GS-ind.svg"}) {
      EXPECT_GT(load_text(report / name).size(), 100u) << name;
    }
    EXPECT_EQ(count(load_text(report / "ee.csv"), "\n"), 1 + 8);
  }

  void check_folder_table(const std::string& readme) {
    const auto names = parse_readme_table_names(readme, "A study folder");
    EXPECT_GE(names.size(), 11u);
    for (const std::string& name : names) {
      // Nothing was found, no room is being made and nothing replaced.
      const bool is_of_a_moment = name == "verdict.json" || name == "rooms/" || name == "changing.txt";
      EXPECT_EQ(fs::exists(study_ / name), !is_of_a_moment) << name;
    }
  }

  TempFolder folder_;
  fs::path study_ = folder_ / "studies/pocket";
};

TEST_F(Readme, EveryCommandDoesWhatItSays) {
  const std::string readme = load_text(kSource / "README.md");
  std::string output;
  int tested = 0;
  for (const ReadmeCommand& command : parse_readme_commands(readme)) {
    if (!command.reason.empty()) continue;
    output += run(command.text);
    ++tested;
  }
  EXPECT_GE(tested, 8);
  EXPECT_THAT(output, HasSubstr("184 pictures, 184 written now, 216 layers rendered now"));
  EXPECT_EQ(count(output, "  MET\n"), 2 * 8) << "by set, and again by tonemap";
  EXPECT_THAT(output, Not(HasSubstr("MISSED")));
  EXPECT_THAT(output, HasSubstr("12 added"));
  EXPECT_THAT(output, HasSubstr("14 added"));
  EXPECT_THAT(output, HasSubstr("Equivalence exists, indirect"));
  EXPECT_THAT(output, HasSubstr("PLANTED answers"));
  check_manifest();
  check_report();
  check_folder_table(readme);
  EXPECT_EQ(load_png(folder_ / "picture.png").width, 140);
  EXPECT_EQ(load_exr(folder_ / "picture.exr").image.height, 105);
  EXPECT_THAT(load_text(folder_ / "g2.py"), HasSubstr("import bpy"));
  EXPECT_THAT(run("build/release/bin/equilux-render set protocols/pocket.json --out studies/pocket"),
              HasSubstr("184 pictures, 0 written now, 0 layers rendered now"));
}

TEST_F(Readme, CommandsAreTheLinesOfItsShellBlocks) {
  const auto commands = parse_readme_commands(
      "```sh\nfirst  # a remark\n\nsecond  # not tested: takes long\n```\nprose\n```\nno command\n```\n");
  ASSERT_EQ(commands.size(), 2u);
  EXPECT_EQ(commands[0].text, "first  # a remark");
  EXPECT_EQ(commands[0].reason, "");
  EXPECT_EQ(commands[1].text, "second");
  EXPECT_EQ(commands[1].reason, "takes long");
  EXPECT_EQ(commands[1].line, 4);
}

TEST_F(Readme, CommandsThatAreNotTestedSayWhy) {
  EXPECT_THROW(parse_readme_commands("```sh\nfirst  # not tested\n```\n"), InputError);
  EXPECT_THROW(parse_readme_commands("```sh\nfirst  # not tested: \n```\n"), InputError);
}

TEST_F(Readme, FilesOfAStudyFolderAreTheFirstCellsOfItsTable) {
  EXPECT_THAT(parse_readme_table_names("## Files\n| file | holds |\n|---|---|\n| `a`, `b/` | `c` |\n"
                                       "| `d-<kind>.json` | e |\n\n## Next\n| `f` | g |\n",
                                       "Files"),
              ElementsAre("a", "b/", "d-planted.json"));
}

// Mutant: a command that fails.
TEST_F(Readme, ACommandThatFailsIsNoticed) {
  EXPECT_EQ(Child("/bin/bash", {"-c", R"(cd "$1" && eval "$2")", "bash", folder_.path().string(),
                                "build/release/bin/equilux-render tonemap nowhere"})
                .wait()
                .exit_code,
            1);
}

}  // namespace
}  // namespace equilux
