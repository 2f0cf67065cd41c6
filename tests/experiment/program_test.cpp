// equilux-session as its users meet it: command line, exit codes, words.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/version.h"
#include "tests/experiment/child.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/raw_database.h"

namespace equilux {
namespace {

using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::StartsWith;

class SessionProgram : public ::testing::Test {
 protected:
  ChildResult simulate(std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"simulate", root_, "--experiment", "artifact"};
    words.insert(words.end(), more.begin(), more.end());
    return run_session_program(words);
  }

  TemporaryFolder temporary_;
  StudyFolder folder_ = make_fake_study(temporary_.path());
  std::string root_ = folder_.root.string();
};

TEST_F(SessionProgram, SaysHowManySessionsItKeptResumedAndAdded) {
  const ChildResult first = simulate({"--subjects", "3", "--seed", "4"});
  EXPECT_EQ(first.exit_code, 0) << first.err;
  EXPECT_EQ(first.out, "artifact sessions of planted subjects, seed 4: 0 kept, 0 resumed, 3 added\n");
  EXPECT_EQ(simulate({"--subjects", "4", "--seed", "4"}).out,
            "artifact sessions of planted subjects, seed 4: 3 kept, 0 resumed, 1 added\n");
}

TEST_F(SessionProgram, TakesSubjectsAndSeedFromTheStudy) {
  EXPECT_EQ(simulate().out, "artifact sessions of planted subjects, seed 1: 0 kept, 0 resumed, 12 added\n");
}

TEST_F(SessionProgram, AcknowledgesEachAnswerInOrder) {
  const ChildResult result = simulate({"--subjects", "1", "--acknowledge"});
  std::string expected;
  for (int trial = 0; trial < 32; ++trial) expected += fmt::format("answered 1 {}\n", trial);
  EXPECT_THAT(result.out, StartsWith(expected));
}

TEST_F(SessionProgram, TakesATruthFromAFile) {
  const auto truth = folder_.root / "mine.json";
  save_fake_truth(folder_, 0.0, 0.5, "never", "never", truth);
  EXPECT_EQ(simulate({"--truth", truth.string(), "--subjects", "1"}).exit_code, 0);
  const RawDatabase database(folder_.responses());
  EXPECT_EQ(database.value("SELECT count(*) FROM trial WHERE answer = test_side"), "32");
}

TEST_F(SessionProgram, ShowsWhoHasAnsweredHowMuch) {
  EXPECT_EQ(run_session_program({"status", root_}).out, "No sessions yet.\n");
  EXPECT_FALSE(std::filesystem::exists(folder_.responses())) << "reading must not make a log";
  simulate({"--subjects", "2"});
  const ChildResult status = run_session_program({"status", root_});
  EXPECT_EQ(status.exit_code, 0);
  EXPECT_THAT(status.out, HasSubstr("planted-1-1"));
  EXPECT_THAT(status.out, HasSubstr("32/32"));
}

TEST_F(SessionProgram, EndsEveryHelpWithAnExample) {
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{{"--help"},
                                                                                     {"simulate", "--help"},
                                                                                     {"run", "--help"},
                                                                                     {"status", "--help"},
                                                                                     {"export", "--help"},
                                                                                     {"withdraw", "--help"},
                                                                                     {"merge", "--help"}}) {
    const ChildResult result = run_session_program(words);
    EXPECT_EQ(result.exit_code, 0);
    const std::string last_line = result.out.substr(result.out.rfind("Example: "));
    EXPECT_THAT(last_line, MatchesRegex("Example: equilux-session [^\n]*\n")) << words.front();
  }
}

TEST_F(SessionProgram, SaysItsVersion) {
  EXPECT_EQ(run_session_program({"--version"}).out, fmt::format("equilux-session {}\n", kVersion));
}

TEST_F(SessionProgram, LeavesWithTwoOnAWrongCommandLine) {
  using Words = std::vector<std::string>;
  for (const Words& words :
       {Words{}, Words{"dance"}, Words{"simulate"}, Words{"simulate", root_}, Words{"status"},
        Words{"simulate", root_, "--experiment", "taste"},
        Words{"simulate", root_, "--experiment", "artifact", "--subjects", "0"},
        Words{"simulate", root_, "--experiment", "artifact", "--subjects", "many"},
        Words{"simulate", root_, "--experiment", "artifact", "--seed", "-1"}, Words{"export", root_},
        Words{"export", root_, "--out", "a", "--format", "xml"},
        Words{"export", root_, "--out", "a", "--kind", "martian"}, Words{"withdraw", root_},
        Words{"withdraw", root_, "P01", "P02"}, Words{"merge", root_}, Words{"merge"},
        Words{"run", root_, "--experiment", "taste"}, Words{"run", root_, "--diagonal", "-3"},
        Words{"run", root_, "--distance", "0"}}) {
    const ChildResult result = run_session_program(words);
    EXPECT_EQ(result.exit_code, 2) << fmt::format("{}", fmt::join(words, " "));
    EXPECT_NE(result.err, "");
  }
}

TEST_F(SessionProgram, LeavesWithOneOnInputThatItCannotUse) {
  const ChildResult missing = run_session_program({"status", root_ + "/nowhere"});
  EXPECT_EQ(missing.exit_code, 1);
  EXPECT_THAT(missing.err, StartsWith("equilux-session: " + root_ + "/nowhere: expected a study folder"));
  const ChildResult material = run_session_program({"simulate", root_, "--experiment", "material"});
  EXPECT_EQ(material.exit_code, 1);
  EXPECT_THAT(material.err, HasSubstr("equilux-analyze prune " + root_));
  EXPECT_THAT(material.err, EndsWith("\n"));
}

TEST_F(SessionProgram, LeavesWithOneWhereThereIsNoLogToReadFrom) {
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"export", root_, "--out", root_ + "/out"},
                                             {"withdraw", root_, "P01", "--yes"},
                                             {"merge", root_, root_}}) {
    const ChildResult result = run_session_program(words);
    EXPECT_EQ(result.exit_code, 1) << words.front();
    EXPECT_THAT(result.err,
                HasSubstr("responses.sqlite: expected a log of responses, got nothing of that name"));
  }
  EXPECT_FALSE(std::filesystem::exists(folder_.responses()));
}

// Files of the program may not exceed 200,000 bytes: the disk is full in mid-session.
TEST_F(SessionProgram, StopsOnAFullDiskAndLosesNothing) {
  Child child(kSessionProgram, {"simulate", root_, "--experiment", "artifact", "--acknowledge"}, 200'000);
  const ChildResult result = child.wait();
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("responses.sqlite: cannot write"));
  const auto acknowledged = std::count(result.out.begin(), result.out.end(), '\n');
  EXPECT_GT(acknowledged, 0);
  const std::string answered = "SELECT count(*) FROM trial WHERE answer IS NOT NULL";
  EXPECT_EQ(RawDatabase(folder_.responses()).value(answered), std::to_string(acknowledged));
  EXPECT_THAT(simulate().out, HasSubstr(" 1 resumed, "));
  EXPECT_EQ(RawDatabase(folder_.responses()).value(answered), std::to_string(12 * 32));
}

#ifndef EQUILUX_WINDOW
TEST_F(SessionProgram, SaysWhereItHasNoWindow) {
  const ChildResult result = run_session_program({"run", root_});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("without one"));
}
#endif

}  // namespace
}  // namespace equilux
