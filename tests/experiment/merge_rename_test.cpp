// Two stations gave one code to two persons: who is told apart, for good, and who is not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "experiment/merge_logs.h"
#include "experiment/withdraw.h"
#include "tests/experiment/child.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"
#include "tests/experiment/raw_database.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr int kTrials = 4;
constexpr const char* kStudy = "study";  // digest of the study of make_fake_session

const Rename kRename{"P01", "P01b"};

class MergeRename : public ::testing::Test {
 protected:
  // A session of `code`, finished.
  static void add(const fs::path& path, const std::string& code, std::int64_t index,
                  Experiment experiment = Experiment::kArtifact, SubjectKind kind = SubjectKind::kPerson) {
    TrialLog log(path, true);
    SessionRow row = make_fake_session(index, kind, experiment);
    row.participant = code;
    answer_all(log, log.append_session(row, make_fake_trials(kTrials)), kTrials);
  }
  MergePlan merge(const std::vector<fs::path>& others, const std::vector<Rename>& renames = {}) const {
    return merge_logs(ours_, others, kStudy, renames);
  }
  std::string conflict_with(const std::vector<fs::path>& others,
                            const std::vector<Rename>& renames = {}) const {
    const auto before = fs::exists(ours_) ? load_all(ours_) : std::vector<Rows>{};
    const std::string message = message_of<InputError>([&] { merge(others, renames); });
    EXPECT_EQ(fs::exists(ours_) ? load_all(ours_) : std::vector<Rows>{}, before) << "nothing is written";
    return message;
  }
  void expect_unchanged_by(const std::vector<fs::path>& others,
                           const std::vector<Rename>& renames = {}) const {
    const auto before = load_all(ours_);
    merge(others, renames);
    EXPECT_EQ(load_all(ours_), before);
  }
  // Of each session its code here, its index at its station, and its first code, if another.
  static Rows load_codes(const fs::path& path) {
    return RawDatabase(path).query(
        "SELECT code, subject_index, coalesce(value, '-') FROM session JOIN participant ON participant.id ="
        " participant LEFT JOIN field ON session = session.id AND name = 'renamed_from' ORDER BY "
        "subject_index,"
        " experiment");
  }
  static std::vector<Rows> load_all(const fs::path& path) {
    std::vector<Rows> tables = load_whole_content(path);
    for (const char* table : {"field", "tombstone"})
      tables.push_back(RawDatabase(path).query(fmt::format("SELECT * FROM {} ORDER BY rowid", table)));
    return tables;
  }
  // P01 of ours and P01 of the first station are two persons, told apart.
  void merge_renamed() {
    add(ours_, "P01", 0);
    add(first_, "P01", 1);
    ASSERT_EQ(merge({first_}, {kRename}).added.size(), 1u);
  }

  TemporaryFolder folder_;
  fs::path ours_ = folder_.path() / "ours.sqlite", first_ = folder_.path() / "first.sqlite",
           second_ = folder_.path() / "second.sqlite";
};

TEST_F(MergeRename, TellsTwoPersonsOfOneCodeApartAndKeepsTheFirstCode) {
  add(ours_, "P01", 0);
  add(first_, "P01", 1);
  EXPECT_THAT(conflict_with({first_}), HasSubstr("--rename P01=NEW"));
  const MergePlan plan = merge({first_}, {kRename});
  EXPECT_THAT(format_merge(plan), HasSubstr("renamed: P01 of station"));
  EXPECT_EQ(load_codes(ours_), (Rows{{"P01", "0", "-"}, {"P01b", "1", "P01"}}));
  EXPECT_EQ(load_codes(first_), (Rows{{"P01", "1", "-"}})) << "the station's own log stays as it is";
}

// Which an earlier merge may have given all the same.
TEST_F(MergeRename, TakesANameForNoNewCode) {
  const Rename to_name{"P01", "anna"};
  add(ours_, "P01", 0);
  add(first_, "P01", 1);
  EXPECT_THAT(conflict_with({first_}, {to_name}), HasSubstr("a new code has a digit or more"));
  merge({first_}, {kRename});
  RawDatabase(ours_).query("UPDATE participant SET code = 'anna' WHERE code = 'P01b'");
  expect_unchanged_by({first_}, {to_name});
}

TEST_F(MergeRename, OnceMoreChangesNothingWithTheOptionOrWithout) {
  merge_renamed();
  expect_unchanged_by({first_}, {kRename});
  expect_unchanged_by({first_});
}

// Also those that had begun when the first merge was.
TEST_F(MergeRename, LaterAnswersAndSessionsOfThatPersonComeUnderTheNewCode) {
  add(ours_, "P01", 0);
  std::int64_t begun = 0;
  {
    TrialLog log(first_, true);
    SessionRow row = make_fake_session(1);
    row.participant = "P01";
    begun = log.append_session(row, make_fake_trials(kTrials));
  }
  merge({first_}, {kRename});
  {
    TrialLog log(first_);
    answer_all(log, begun, kTrials);
  }
  add(first_, "P01", 1, Experiment::kMaterial);
  const MergePlan plan = merge({first_});
  EXPECT_EQ(plan.replaced.size(), 1u);
  EXPECT_EQ(plan.added.size(), 1u);
  EXPECT_EQ(load_codes(ours_), (Rows{{"P01", "0", "-"}, {"P01b", "1", "P01"}, {"P01b", "1", "P01"}}));
  expect_unchanged_by({first_});
}

// As the material experiment asks for: each log then holds both, under codes of its own.
TEST_F(MergeRename, StationsThatTookInOneAnotherCanBeMerged) {
  merge_renamed();
  merge_logs(first_, {ours_}, kStudy, {{"P01", "P01a"}});
  EXPECT_EQ(load_codes(first_), (Rows{{"P01a", "0", "P01"}, {"P01", "1", "-"}}));
  expect_unchanged_by({first_});
  for (const auto& [one, other] : {std::pair(ours_, first_), std::pair(first_, ours_)}) {
    const fs::path apart = folder_.path() / "apart.sqlite", together = folder_.path() / "together.sqlite";
    merge_logs(apart, {one}, kStudy);
    merge_logs(apart, {other}, kStudy);
    merge_logs(together, {one, other}, kStudy);
    EXPECT_EQ(load_codes(apart), load_codes(one));
    EXPECT_EQ(load_codes(together), load_codes(one));
    fs::remove(apart);
    fs::remove(together);
  }
}

TEST_F(MergeRename, ToACodeThatIsNotFreeIsRefused) {
  add(ours_, "P01", 0);
  add(ours_, "P02", 2);
  add(first_, "P01", 1);
  add(first_, "P03", 3);
  add(second_, "P04", 4);
  EXPECT_THAT(conflict_with({first_}, {{"P01", "P02"}}),
              HasSubstr("--rename P01=P02: " + ours_.string() + " has P02, who is somebody else"));
  EXPECT_THAT(conflict_with({first_}, {{"P01", "p02"}}), HasSubstr("has P02, who is somebody else"));
  EXPECT_THAT(conflict_with({first_}, {{"P01", "P03"}}), HasSubstr("first.sqlite has P03"));
  EXPECT_THAT(conflict_with({first_, second_}, {{"P01", "P04"}}), HasSubstr("second.sqlite has P04"));
  withdraw_participant(ours_, "P02");
  EXPECT_THAT(conflict_with({first_}, {{"P01", "p02"}}), HasSubstr("--rename P01=p02: P02 withdrew"));
}

TEST_F(MergeRename, OfNobodyOrOfTwoIsRefused) {
  add(ours_, "P01", 0);
  add(first_, "P01", 1);
  add(second_, "P01", 2);
  add(second_, "planted-1-0", 0, Experiment::kArtifact, SubjectKind::kPlanted);
  EXPECT_THAT(conflict_with({first_}, {{"P09", "P10"}}), HasSubstr("no log that comes in has P09"));
  EXPECT_THAT(
      conflict_with({first_, second_}, {kRename}),
      AllOf(HasSubstr("first.sqlite and "), HasSubstr("second.sqlite have it; take them in one after")));
  EXPECT_THAT(conflict_with({first_}, {kRename, {"P01", "P01c"}}), HasSubstr("each code once"));
  EXPECT_THAT(conflict_with({first_}, {kRename, {"P02", "p01B"}}), HasSubstr("each code once"));
  EXPECT_THAT(conflict_with({second_}, {{"planted-1-0", "P05"}}), HasSubstr("no person's code"));
  for (const char* text : {"", "P01", "=P02", "P01=", "P01=P01", "P01=Anna M", "P01=a=b"})
    EXPECT_THAT(message_of<InputError>([&] { parse_rename(text); }), HasSubstr("--rename")) << text;
}

TEST_F(MergeRename, OfWhomIsKnownByAnotherCodeAlreadyIsRefused) {
  merge_renamed();
  EXPECT_THAT(conflict_with({first_}, {{"P01", "P01c"}}),
              HasSubstr("is P01b in " + ours_.string() + " already"));
  add(second_, "P02", 2);
  merge({second_});
  EXPECT_THAT(conflict_with({second_}, {{"P02", "P03"}}),
              HasSubstr("is P02 in " + ours_.string() + " already"));
}

// Under neither code, though nothing here names the first one any more.
TEST_F(MergeRename, WhoWithdrewHereDoesNotComeBack) {
  merge_renamed();
  withdraw_participant(ours_, "P01b");
  EXPECT_EQ(TrialLog(ours_).count_withdrawn(), 1);
  EXPECT_EQ(load_codes(ours_), (Rows{{"P01", "0", "-"}}));
  EXPECT_EQ(RawDatabase(ours_).value("SELECT count(*) FROM field"), "0");
  EXPECT_THAT(conflict_with({first_}), HasSubstr("the participant withdrew"));
  EXPECT_THAT(conflict_with({first_}, {kRename}), HasSubstr("P01b withdrew"));
  EXPECT_THAT(conflict_with({first_}, {{"P01", "P01c"}}), HasSubstr("the participant withdrew"));
  withdraw_participant(first_, "P01");
  merge({first_}, {kRename});
  EXPECT_EQ(load_codes(ours_), (Rows{{"P01", "0", "-"}})) << "the other person of that code stays";
}

// Who was P01 at the station asks to be erased by that code.
TEST_F(MergeRename, AWithdrawalTellsOfTheOtherPersonOfTheCode) {
  merge_renamed();
  EXPECT_THAT(format_withdrawal(plan_withdrawal(ours_, "P01")),
              HasSubstr("P01 of another station is P01b here, another person, who stays"));
  EXPECT_THAT(format_withdrawal(plan_withdrawal(ours_, "P01b")), Not(HasSubstr("another person")));
  merge_logs(second_, {first_}, kStudy, {kRename});
  EXPECT_THAT(message_of<InputError>([&] { plan_withdrawal(second_, "P01"); }),
              HasSubstr("got P01 of another station is P01b here"));
}

TEST_F(MergeRename, AWithdrawalAtTheStationErasesThatPersonAlone) {
  merge_renamed();
  fs::copy(first_, second_);  // which still holds what is withdrawn
  withdraw_participant(first_, "P01");
  EXPECT_THAT(conflict_with({first_}),
              AllOf(HasSubstr("P01 withdrew there, which is the code of two persons"),
                    HasSubstr("--rename P01=P01b"), HasSubstr("else withdraw P01 here first")));
  EXPECT_EQ(merge({first_}, {kRename}).erased, std::vector<std::string>{"P01b"});
  EXPECT_EQ(load_codes(ours_), (Rows{{"P01", "0", "-"}}));
  EXPECT_EQ(TrialLog(ours_).count_withdrawn(), 1);
  expect_unchanged_by({first_});
  expect_unchanged_by({first_}, {kRename});
  EXPECT_THAT(conflict_with({second_}), HasSubstr("the participant withdrew"));
}

// Else the person of that code here would be erased.
TEST_F(MergeRename, KeepsAWithdrawalFromBeforeTheFirstMergeFromTheOtherPerson) {
  add(ours_, "P01", 0);
  add(first_, "P01", 1);
  withdraw_participant(first_, "P01");
  EXPECT_THAT(merge({first_}, {kRename}).erased, IsEmpty());
  expect_unchanged_by({first_});
  EXPECT_EQ(load_codes(ours_), (Rows{{"P01", "0", "-"}}));
}

TEST_F(MergeRename, WhereTheOtherOfTheCodeWithdrewTheStationsTombstoneErasesNobody) {
  merge_renamed();
  withdraw_participant(first_, "P01");
  withdraw_participant(ours_, "P01");
  EXPECT_THAT(merge({first_}).erased, IsEmpty());
  EXPECT_EQ(load_codes(ours_), (Rows{{"P01b", "1", "P01"}}));
}

TEST_F(MergeRename, IsAnOptionOfTheProgram) {
  const StudyFolder folder = make_fake_study(folder_.path() / "study");
  const std::string digest = load_folder_study(folder).digest;
  for (const fs::path& path : {folder.responses(), first_}) {
    TrialLog log(path, true);
    SessionRow row = make_fake_session(path == first_ ? 1 : 0);
    row.participant = "P01";
    row.digests.study = digest;
    answer_all(log, log.append_session(row, make_fake_trials(kTrials)), kTrials);
  }
  const auto run = [&](const std::vector<std::string>& options) {
    std::vector<std::string> arguments = {"merge", folder.root.string()};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return run_session_program(arguments);
  };
  EXPECT_THAT(run({first_.string()}).err, HasSubstr("--rename P01=NEW"));
  EXPECT_THAT(run({first_.string(), "--rename", "P01"}).err, HasSubstr("expected OLD=NEW, two codes"));
  const ChildResult result = run({"--rename", "P01=P01b", first_.string()});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, AllOf(HasSubstr("1 added"), HasSubstr("is P01b here, artifact experiment")));
}

}  // namespace
}  // namespace equilux
