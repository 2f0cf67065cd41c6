// After a withdrawal no byte of the code or the answers is left, in any file that the program keeps.
#include "experiment/withdraw.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/files.h"
#include "experiment/log_schema.h"
#include "experiment/status.h"
#include "tests/experiment/child.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"
#include "tests/experiment/old_log.h"
#include "tests/experiment/raw_database.h"
#include "tests/experiment/unprivileged.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

const std::string kCode = "Withdrawing-Participant-4711";
const std::string kMarker = "a thing that only this person said";

class Withdraw : public ::testing::Test {
 protected:
  // Three participants in both experiments; the second is the one who will withdraw.
  void make_log(int trials = 40) const {
    TrialLog log(path_, true);
    for (const Experiment experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
      for (int index = 0; index < 3; ++index) add_session(log, index, experiment, trials);
    }
  }
  static void add_session(TrialLog& log, int index, Experiment experiment, int trials) {
    SessionRow row = make_fake_session(index, SubjectKind::kPerson, experiment);
    if (index == 1) row.participant = kCode;
    row.fields = {{"remark", index == 1 ? kMarker : "nothing"}};
    const auto session = log.append_session(row, make_fake_trials(trials));
    log.append_event(session, "note", 1, index == 1 ? kMarker + std::string(9000, 'x') : "nothing");
    answer_all(log, session, trials);
  }
  // Every file of the folder that holds the text.
  std::vector<std::string> find_text(const std::string& text) const {
    std::vector<std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(temporary_.path())) {
      if (entry.is_regular_file() && read_bytes(entry.path()).find(text) != std::string::npos)
        files.push_back(entry.path().filename().string());
    }
    return files;
  }

  TemporaryFolder temporary_;
  StudyFolder folder_ = make_fake_study(temporary_.path());
  fs::path path_ = folder_.responses();
};

TEST_F(Withdraw, LeavesNoByteOfCodeOrAnswersAndAllOfTheOthers) {
  make_log();
  const auto others = TrialLog(path_).load_trials(1);
  const auto sessions = TrialLog(path_).load_sessions();
  ASSERT_THAT(find_text(kCode), Contains("responses.sqlite")) << "otherwise the search finds nothing";
  ASSERT_THAT(find_text(kMarker), Contains("responses.sqlite"));
  ASSERT_THAT(find_text(sessions[1].uuid), Contains("responses.sqlite"));
  withdraw_participant(path_, kCode);
  for (const std::string& text : {kCode, kMarker, sessions[1].uuid, sessions[4].uuid, std::string(50, 'x')})
    EXPECT_THAT(find_text(text), IsEmpty()) << text;
  const TrialLog log(path_);
  EXPECT_EQ(log.load_sessions().size(), 4u);
  EXPECT_EQ(log.load_trials(1), others);
  EXPECT_EQ(log.load_events(1).size(), 1u + 40 + 39 + 1);
}

// Logs of old may hold two codes that differ in the case of letters alone.
TEST_F(Withdraw, InOtherLettersIsKnownTooButForSomebodyElse) {
  const auto begin = [](const std::string& code, int index) {
    SessionRow row = make_fake_session(index);
    row.participant = code;
    return row;
  };
  {
    TrialLog log(path_, true);
    log.append_session(begin("Anna7", 0), make_fake_trials(2));
    log.append_session(begin("anna7", 1), make_fake_trials(2));
  }
  withdraw_participant(path_, "Anna7");
  TrialLog log(path_);
  ASSERT_EQ(log.load_sessions().size(), 1u);
  EXPECT_FALSE(log.has_withdrawn("anna7")) << "somebody else's";
  EXPECT_TRUE(log.has_withdrawn("ANNA7"));
  for (const std::string code : {"Anna7", "ANNA7", "aNNa7"})
    EXPECT_THROW(log.append_session(begin(code, 2), {}), InputError) << code;
  EXPECT_EQ(log.count_withdrawn(), 1);
}

// Mutant: rows deleted as SQLite deletes them by itself. The search must find what stayed.
TEST_F(Withdraw, WithoutOverwritingItsBytesAreFound) {
  make_log();
  {
    const RawDatabase database(path_);
    database.query("PRAGMA secure_delete = OFF");
    for (const char* table : {"event", "trial", "field"})
      database.query(std::string("DELETE FROM ") + table + " WHERE session IN (2, 5)");
    database.query("DELETE FROM session WHERE participant = 2");
    database.query("DELETE FROM participant WHERE id = 2");
  }
  EXPECT_THAT(find_text(kMarker), Contains("responses.sqlite"));
}

TEST_F(Withdraw, ErasesFromAWalThatWasLeft) {
  make_log();
  const TemporaryFolder aside;
  {
    TrialLog live(path_);
    SessionRow row = make_fake_session(3);
    row.participant = kCode;
    live.append_event(live.append_session(row, make_fake_trials(2)), "note", 1, kMarker);
    fs::copy(path_, aside.path() / "db");
    fs::copy(path_.string() + "-wal", aside.path() / "wal");
  }
  fs::copy(aside.path() / "db", path_, fs::copy_options::overwrite_existing);
  fs::copy(aside.path() / "wal", path_.string() + "-wal");
  ASSERT_THAT(find_text(kMarker), Contains("responses.sqlite-wal"));
  withdraw_participant(path_, kCode);
  EXPECT_THAT(find_text(kMarker), IsEmpty());
  EXPECT_THAT(find_text(kCode), IsEmpty());
  EXPECT_FALSE(fs::exists(path_.string() + "-wal"));
}

TEST_F(Withdraw, ErasesFromKeptAndUnfinishedCopies) {
  make_old_log(path_, kCode, kMarker);
  { TrialLog{path_}; }
  fs::copy(folder_.root / "responses.v1.sqlite", folder_.root / "responses.v1-3.sqlite");
  fs::copy(folder_.root / "responses.v1.sqlite", folder_.root / "responses.v1-4.sqlite.part");
  ASSERT_EQ(find_text(kCode).size(), 4u);
  const Withdrawal plan = plan_withdrawal(path_, kCode);
  EXPECT_EQ(plan.copies.size(), 2u) << "also where one before it was removed";
  withdraw_participant(path_, kCode);
  EXPECT_THAT(find_text(kCode), IsEmpty());
  EXPECT_THAT(find_text(kMarker), IsEmpty());
  EXPECT_EQ(RawDatabase(folder_.root / "responses.v1.sqlite").value("SELECT count(*) FROM session"), "1");
  EXPECT_EQ(RawDatabase(folder_.root / "responses.v1-3.sqlite").value("PRAGMA user_version"), "1");
}

TEST_F(Withdraw, OfAnOlderLogBringsItUpAndErasesFromTheCopyThatThisKeeps) {
  make_old_log(path_, kCode, kMarker);
  withdraw_participant(path_, kCode);
  EXPECT_THAT(find_text(kCode), IsEmpty());
  EXPECT_EQ(find_kept_copies(path_).size(), 1u);
}

TEST_F(Withdraw, LeavesATombstoneThatRefusesTheCode) {
  make_log(2);
  withdraw_participant(path_, kCode);
  TrialLog log(path_);
  EXPECT_EQ(log.count_withdrawn(), 1);
  SessionRow again = make_fake_session(1);
  again.participant = kCode;
  EXPECT_THAT(message_of<InputError>([&] { log.append_session(again, {}); }),
              AllOf(HasSubstr("participant/code"), HasSubstr("withdrawn on 20")));
  EXPECT_EQ(log.find_free_index(SubjectKind::kPerson, Experiment::kArtifact), 1) << "free for somebody else";
  EXPECT_NO_THROW(log.append_session(make_fake_session(1), {}));
  EXPECT_EQ(RawDatabase(path_).value("SELECT length(salt) || ' ' || length(digest) FROM tombstone"), "32 64");
}

TEST_F(Withdraw, OnceMoreChangesNothing) {
  make_log(2);
  withdraw_participant(path_, kCode);
  const auto tombstones = RawDatabase(path_).query("SELECT * FROM tombstone");
  const Withdrawal plan = plan_withdrawal(path_, kCode);
  EXPECT_TRUE(plan.withdrawn_utc);
  withdraw_participant(path_, kCode);
  EXPECT_EQ(RawDatabase(path_).query("SELECT * FROM tombstone"), tombstones);
}

TEST_F(Withdraw, PlansWithoutTouchingAnything) {
  make_log(2);
  TrialLog(path_).append_export("/somewhere/answers");
  const fs::path report = path_.parent_path() / "report";
  fs::create_directories(report);
  save_text(report / "subjects.csv", std::string("artifact,") + kCode + ",12");
  save_text(report / "ee.csv", std::string("of ") + kCode + "0 and nobody else");
  const std::string digest = digest_file(path_);
  const Withdrawal plan = plan_withdrawal(path_, kCode);
  EXPECT_EQ(digest_file(path_), digest);
  EXPECT_EQ(plan.sessions.size(), 2u);
  EXPECT_EQ(plan.answers, 4);
  EXPECT_THAT(format_withdrawal(plan),
              AllOf(HasSubstr("sessions 2, answers 4"), HasSubstr("material, index 1"),
                    HasSubstr("/somewhere/answers"),
                    HasSubstr("also in " + (report / "subjects.csv").string()), Not(HasSubstr("ee.csv"))));
}

// Of 64 MiB and a byte, of which nothing is on the disk: more than a text may have.
TEST_F(Withdraw, NamesAReportThatCannotBeReadAndGoesOn) {
  make_log(2);
  const fs::path report = path_.parent_path() / "report";
  fs::create_directories(report);
  save_text(report / "ee.csv", "nobody's");
  save_text(report / "page.html", "");
  fs::resize_file(report / "page.html", (std::uintmax_t{64} << 20) + 1);
  fs::create_symlink(report / "deleted.csv", report / "link.csv");
  const Withdrawal plan = plan_withdrawal(path_, kCode);
  EXPECT_THAT(plan.reports, IsEmpty());
  EXPECT_THAT(plan.unread, ElementsAre(report / "page.html"));
  EXPECT_THAT(format_withdrawal(plan), HasSubstr("perhaps also in " + (report / "page.html").string() +
                                                 ", which cannot be read: look into it"));
  withdraw_participant(path_, kCode);
  EXPECT_THAT(find_text(kCode), IsEmpty());
}

TEST_F(Withdraw, NamesAReportFolderThatCannotBeLookedInto) {
  make_log(2);
  const fs::path report = path_.parent_path() / "report";
  fs::create_directories(report);
  save_text(report / "subjects.csv", "artifact," + kCode);
  fs::permissions(report, fs::perms::none);
  {
    const ReadOnlyFolder nobody(folder_.root);
    const Withdrawal plan = plan_withdrawal(path_, kCode);
    EXPECT_THAT(plan.reports, IsEmpty());
    EXPECT_THAT(plan.unread, ElementsAre(report));
  }
  fs::permissions(report, fs::perms::owner_all);
  EXPECT_THAT(plan_withdrawal(path_, kCode).reports, ElementsAre(report / "subjects.csv"));
}

TEST_F(Withdraw, NamesExportsWhetherTheyAreThereOrNot) {
  make_log(2);
  const TemporaryFolder made;
  {
    TrialLog log(path_);
    log.append_export(made.path().string());
    log.append_export((made.path() / "deleted").string());
  }
  EXPECT_THAT(format_withdrawal(plan_withdrawal(path_, kCode)),
              AllOf(ContainsRegex(made.path().string() + ", of [^:]*:[^:]*:[^:]*Z\n"),
                    ContainsRegex("/deleted, of .*Z: not there any more; if it was moved, it holds them"),
                    HasSubstr("that equilux-analyze made elsewhere")));
}

TEST_F(Withdraw, NamesWhatAnExportThatWasKilledHasLeft) {
  make_log(2);
  const TemporaryFolder made;
  TrialLog(path_).append_export((made.path() / "answers").string());
  const std::string left = (made.path() / "answers.part").string();
  EXPECT_THAT(format_withdrawal(plan_withdrawal(path_, kCode)), Not(HasSubstr(left)));
  fs::create_directory(left);
  EXPECT_THAT(format_withdrawal(plan_withdrawal(path_, kCode)),
              HasSubstr("  " + left + ", which an export that was broken off left there\n"));
}

TEST_F(Withdraw, OfACodeThatNobodyHasIsAnError) {
  make_log(1);
  EXPECT_THAT(message_of<InputError>([&] { plan_withdrawal(path_, "P9"); }), HasSubstr("got P9"));
}

// Written down by hand, and asked for weeks later.
TEST_F(Withdraw, OfACodeInOtherLettersTellsWhichOneThereIs) {
  make_log(2);
  std::string small = kCode;
  std::transform(small.begin(), small.end(), small.begin(), [](unsigned char c) { return std::tolower(c); });
  EXPECT_THAT(message_of<InputError>([&] { plan_withdrawal(path_, small); }),
              HasSubstr(fmt::format("got {}, where {} differs", small, kCode)));
}

TEST_F(Withdraw, OfALogThatAnotherProgramHasOpenErasesNothing) {
  make_log(2);
  {
    const TrialLog other(path_);
    EXPECT_THAT(message_of<StoreError>([&] { withdraw_participant(path_, kCode); }),
                HasSubstr("another program has it open"));
    EXPECT_EQ(other.load_sessions().size(), 6u);
  }
  EXPECT_NO_THROW(withdraw_participant(path_, kCode));
}

TEST_F(Withdraw, WithACopyThatIsNoLogErasesNothing) {
  make_log(2);
  save_text(folder_.root / "responses.v1.sqlite", std::string(5000, 'x'));
  EXPECT_THAT(message_of<InputError>([&] { plan_withdrawal(path_, kCode); }),
              HasSubstr("responses.v1.sqlite"));
}

TEST_F(Withdraw, AsksBeforeItErases) {
  make_log(2);
  const std::vector<std::string> words = {"withdraw", folder_.root.string(), kCode};
  const ChildResult asked = Child("/bin/sh", {"-c", "exec \"$0\" \"$@\" < /dev/null", kSessionProgram,
                                              words[0], words[1], words[2]})
                                .wait();
  EXPECT_EQ(asked.exit_code, 1);
  EXPECT_THAT(asked.err, HasSubstr("nothing was erased"));
  EXPECT_EQ(TrialLog(path_).load_sessions().size(), 6u);
  const ChildResult done = run_session_program({words[0], words[1], words[2], "--yes"});
  EXPECT_EQ(done.exit_code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("is erased from"));
  EXPECT_THAT(find_text(kCode), IsEmpty());
  EXPECT_THAT(format_status(folder_), AllOf(HasSubstr("Withdrawn participants: 1."), Not(HasSubstr(kCode))));
}

// A log that was archived, without its study folder: what a merge asks for.
TEST_F(Withdraw, TakesALogByItself) {
  make_log(2);
  const fs::path archived = folder_.root / "archived" / "station1-2026.sqlite";
  fs::create_directory(archived.parent_path());
  fs::copy_file(path_, archived);
  const ChildResult done = run_session_program({"withdraw", archived.string(), kCode, "--yes"});
  EXPECT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(TrialLog(archived).load_sessions().size(), 4u);
  EXPECT_EQ(TrialLog(path_).load_sessions().size(), 6u) << "another log";
}

TEST_F(Withdraw, TheCodeInOtherLettersIsRefusedToo) {
  make_log(2);
  SessionRow row = make_fake_session(9);
  {
    TrialLog log(path_);
    row.participant = "Q7-CDF";
    log.append_session(row, make_fake_trials(2));
  }
  withdraw_participant(path_, "Q7-CDF");
  TrialLog log(path_);
  row.participant = "q7-cdf";
  EXPECT_THAT(message_of<InputError>([&] { log.append_session(row, make_fake_trials(2)); }),
              HasSubstr("q7-cdf, withdrawn on"));
  row.participant = "Q7-CDG";
  EXPECT_NO_THROW(log.append_session(row, make_fake_trials(2)));
}

}  // namespace
}  // namespace equilux
