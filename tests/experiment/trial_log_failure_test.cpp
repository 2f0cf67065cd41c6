// Files that are no logs, answers that cannot be, and a disk that is full: said aloud, and nothing lost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/files.h"
#include "experiment/database.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"
#include "tests/experiment/raw_database.h"
#include "tests/experiment/unprivileged.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class TrialLogFailure : public ::testing::Test {
 protected:
  template <typename Error>
  void expect_error(const std::function<void()>& act, const std::string& part) {
    try {
      act();
      ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr(path_.filename().string()));
      EXPECT_THAT(error.what(), HasSubstr(part));
    }
  }
  template <typename Error>
  void expect_open_error(const std::string& part, std::initializer_list<bool> create = {false, true}) {
    for (const bool make : create) expect_error<Error>([&] { TrialLog log(path_, make); }, part);
  }
  std::int64_t make_log(int trials) {
    return TrialLog(path_, true).append_session(make_fake_session(), make_fake_trials(trials));
  }

  TemporaryFolder folder_;
  fs::path path_ = folder_.path() / "responses.sqlite";
};

TEST_F(TrialLogFailure, AMissingFileIsNotMadeByReading) {
  expect_open_error<InputError>("nothing of that name", {false});
  EXPECT_TRUE(fs::is_empty(folder_.path()));
}

TEST_F(TrialLogFailure, AFolderIsNoLog) {
  fs::create_directory(path_);
  expect_open_error<InputError>("a folder");
}

TEST_F(TrialLogFailure, AMissingParentFolderCannotHoldALog) {
  path_ = folder_.path() / "missing" / "responses.sqlite";
  expect_open_error<StoreError>("cannot open", {true});
}

TEST_F(TrialLogFailure, ATextFileIsNoLogAndIsLeftAlone) {
  save_text(path_, std::string(5000, 'x'));
  expect_open_error<InputError>("file is not a database");
  EXPECT_EQ(load_text(path_), std::string(5000, 'x'));
}

TEST_F(TrialLogFailure, AnEmptyFileIsNoLogButMayBecomeOne) {
  save_text(path_, "");
  expect_open_error<InputError>("an empty file", {false});
  EXPECT_EQ(fs::file_size(path_), 0u);
  EXPECT_NO_THROW(TrialLog(path_, true));
}

// Its maker was stopped after the file was there and before the first transaction.
TEST_F(TrialLogFailure, AFileOfNobodyIsNoLogYet) {
  EXPECT_FALSE(TrialLog::is_at(path_));
  save_text(path_, "");
  EXPECT_FALSE(TrialLog::is_at(path_));
  RawDatabase(path_).query("PRAGMA journal_mode = WAL");
  EXPECT_GT(fs::file_size(path_), 0u);
  EXPECT_FALSE(TrialLog::is_at(path_));
  make_log(1);
  EXPECT_TRUE(TrialLog::is_at(path_));
}

TEST_F(TrialLogFailure, WhatIsNoLogIsLeftToBeRefused) {
  save_text(path_, "not a log");
  EXPECT_TRUE(TrialLog::is_at(path_));
  fs::remove(path_);
  RawDatabase(path_).query("CREATE TABLE bookmarks (address TEXT)");
  EXPECT_TRUE(TrialLog::is_at(path_));
}

TEST_F(TrialLogFailure, WhereTheDiskIsFullAtTheStartNoFileStaysBehind) {
  {
    const FileSizeLimit full(0);
    expect_open_error<StoreError>("responses.sqlite", {true});
  }
  EXPECT_TRUE(fs::is_empty(folder_.path()));
  EXPECT_NO_THROW(make_log(1));
}

// One bit at a time: every log that still opens has all of its trials. An index that lacks a row would hide
// it, since rows are read through it.
TEST_F(TrialLogFailure, ADamagedFileNeverHidesATrial) {
  for (const std::int64_t index : {0, 1, 2}) {
    TrialLog log(path_, true);
    log.append_session(make_fake_session(index), make_fake_trials(40));
  }
  const std::string whole = load_text(path_);
  int refused = 0, opened = 0;
  for (std::size_t at = 101; at < whole.size(); at += 37) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ (1 << at % 8));
    save_text(path_, damaged);
    try {
      const auto counted = TrialLog::load_snapshot(path_, LogCheck::kTables).load_brief_trials().by_session;
      ASSERT_EQ(counted.size(), 3u) << at;
      for (const auto& [session, trials] : counted) ASSERT_EQ(trials.size(), 40u) << at;
      const TrialLog log = TrialLog::load_snapshot(path_);
      const auto sessions = log.load_sessions();
      ASSERT_EQ(sessions.size(), 3u) << at;
      for (const SessionRow& row : sessions) ASSERT_EQ(log.load_trials(row.id).size(), 40u) << at;
      ++opened;
    } catch (const std::runtime_error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 50);
  EXPECT_GT(opened, 50) << "of free space and of texts";
}

TEST_F(TrialLogFailure, AWalThatCameWithACopyIsNotEverybodysToRead) {
  const fs::path copy = folder_.path() / "copy.sqlite", wal = copy.string() + kWalSuffix;
  {
    const TrialLog log(path_, true);
    TrialLog(path_).append_session(make_fake_session(), make_fake_trials(5));
    fs::copy_file(path_, copy);
    fs::copy_file(path_.string() + kWalSuffix, wal);
  }
  for (const fs::path& file : {copy, wal}) fs::permissions(file, fs::perms{0644});
  const TrialLog log(copy);
  EXPECT_EQ(log.load_sessions().size(), 1u);
  for (const fs::path& file : {copy, wal}) EXPECT_EQ(fs::status(file).permissions(), fs::perms{0600}) << file;
}

TEST_F(TrialLogFailure, AnotherProgramsDatabaseIsLeftAlone) {
  RawDatabase(path_).query("CREATE TABLE bookmarks (address TEXT)");
  const std::string digest = digest_file(path_);
  expect_open_error<InputError>("a database of another program");
  EXPECT_EQ(digest_file(path_), digest);
}

TEST_F(TrialLogFailure, ANewerSchemaIsRefused) {
  make_log(1);
  RawDatabase(path_).query("PRAGMA user_version = 3");
  expect_open_error<InputError>("3, of a newer Equilux");
}

TEST_F(TrialLogFailure, ATruncatedFileIsRefused) {
  make_log(200);
  const auto size = fs::file_size(path_);
  for (const auto left : {size / 2, size / 4096 * 4096 - 4096, std::uintmax_t{4096}, std::uintmax_t{50}}) {
    fs::resize_file(path_, left);
    expect_open_error<InputError>("whole log");
  }
}

TEST_F(TrialLogFailure, ADatabaseInMemoryHasNoWal) {
  path_ = ":memory:";
  expect_open_error<StoreError>("journal_mode", {true});
}

TEST_F(TrialLogFailure, ATrialIsAnsweredOnce) {
  const auto session = make_log(3);
  TrialLog log(path_);
  log.append_answer(session, {0, Side::kLeft, 10}, 1, 1);
  expect_error<StoreError>(
      [&] {
        log.append_answer(session, {0, Side::kRight, 20}, 1, 2);
      },
      "does not wait for an answer");
  expect_error<StoreError>(
      [&] {
        log.append_answer(session, {3, Side::kRight, 20}, 1, 2);
      },
      "does not wait for an answer");
  expect_error<StoreError>(
      [&] {
        log.append_answer(session + 1, {0, Side::kRight, 20}, 1, 2);
      },
      "does not wait for an answer");
  EXPECT_EQ(log.load_trials(session)[0].answer, std::optional(Side::kLeft));
  EXPECT_EQ(log.load_trials(session)[0].response_time_ns, std::optional<std::int64_t>(10));
  EXPECT_EQ(load_events(path_).size(), 2u);
}

TEST_F(TrialLogFailure, AnAnswerIsNotKeptWithoutTheShowingOfTheNext) {
  const auto session = make_log(3);
  TrialLog log(path_);
  expect_error<StoreError>([&] { log.append_answer(session, {0, Side::kLeft, 10}, 99, 1); }, "FOREIGN KEY");
  EXPECT_FALSE(log.load_trials(session)[0].answer);
  EXPECT_TRUE(load_events(path_).empty());
}

TEST_F(TrialLogFailure, ASessionWithAnUnansweredTrialCannotBeFinished) {
  const auto session = make_log(2);
  TrialLog log(path_);
  log.append_answer(session, {0, Side::kLeft, 10}, 1, 1);
  expect_error<StoreError>([&] { log.finish_session(session, 2); }, "cannot be finished");
  EXPECT_FALSE(log.load_sessions()[0].complete);
  log.append_answer(session, {1, Side::kLeft, 10}, std::nullopt, 3);
  log.finish_session(session, 4);
  EXPECT_TRUE(log.load_sessions()[0].complete);
  expect_error<StoreError>([&] { log.finish_session(session, 5); }, "cannot be finished");
  expect_error<StoreError>([&] { log.finish_session(session + 1, 5); }, "cannot be finished");
}

TEST_F(TrialLogFailure, AnIndexIsTakenOnce) {
  TrialLog log(path_, true);
  log.append_session(make_fake_session(0), make_fake_trials(1));
  SessionRow second = make_fake_session(0);
  second.participant = "P9";
  expect_error<InputError>([&] { log.append_session(second, make_fake_trials(1)); }, "session 1 holds");
  EXPECT_EQ(RawDatabase(path_).value("SELECT count(*) FROM participant"), "1") << "nothing of it may stay";
}

TEST_F(TrialLogFailure, ASessionIsAppendedWithAllItsTrialsOrNotAtAll) {
  TrialLog log(path_, true);
  auto trials = make_fake_trials(3);
  trials[2].number = 1;
  expect_error<StoreError>([&] { log.append_session(make_fake_session(0), trials); }, "UNIQUE");
  EXPECT_EQ(load_whole_content(path_), std::vector<Rows>(4));
}

TEST_F(TrialLogFailure, ASeedOrCodeThatCannotBeKeptIsRefused) {
  TrialLog log(path_, true);
  SessionRow row = make_fake_session(0);
  row.seed = std::uint64_t{1} << 63;
  expect_error<InputError>([&] { log.append_session(row, {}); }, "below 2^63");
  row = make_fake_session(0);
  row.participant.clear();
  expect_error<InputError>([&] { log.append_session(row, {}); }, "participant/code");
}

TEST_F(TrialLogFailure, ALogThatAnotherWriterHoldsIsAStoreErrorAfterAWait) {
  const auto session = make_log(2);
  TrialLog log(path_);
  const RawDatabase other(path_);
  other.query("BEGIN IMMEDIATE");
  expect_error<StoreError>([&] { log.append_answer(session, {0, Side::kLeft, 10}, 1, 1); }, "locked");
  other.query("ROLLBACK");
  EXPECT_NO_THROW(log.append_answer(session, {0, Side::kLeft, 10}, 1, 1));
}

TEST_F(TrialLogFailure, AFullDiskKeepsAllEarlierAnswers) {
  const int count = 500;
  const auto session = make_log(count);
  int acknowledged = 0;
  {
    TrialLog log(path_);
    const FileSizeLimit limit(200'000);
    expect_error<StoreError>(
        [&] {
          for (; acknowledged < count; ++acknowledged) {
            log.append_answer(session, {acknowledged, Side::kLeft, 10}, std::nullopt, acknowledged);
          }
        },
        "cannot write");
  }
  ASSERT_GT(acknowledged, 0);
  ASSERT_LT(acknowledged, count);
  TrialLog log(path_);
  const auto trials = log.load_trials(session);
  for (int i = 0; i < count; ++i) {
    EXPECT_EQ(trials[static_cast<std::size_t>(i)].answer.has_value(), i < acknowledged) << i;
  }
  EXPECT_NO_THROW(log.append_answer(session, {acknowledged, Side::kLeft, 10}, std::nullopt, 0));
}

// A folder that is moved, or removed, with the log open: what is written now would be lost with it.
TEST_F(TrialLogFailure, AFolderThatIsMovedAwayStopsTheSession) {
  const fs::path home = folder_.path() / "study", away = folder_.path() / "away";
  fs::create_directory(home);
  path_ = home / "responses.sqlite";
  const auto session = make_log(3);
  {
    TrialLog log(path_);
    log.append_answer(session, {0, Side::kLeft, 10}, 1, 1);
    fs::rename(home, away);
    expect_error<StoreError>(
        [&] {
          log.append_answer(session, {1, Side::kLeft, 10}, 2, 2);
        },
        "moved or removed while it was open");
  }
  fs::rename(away, home);
  TrialLog log(path_);
  EXPECT_TRUE(log.load_trials(session)[0].answer);
  EXPECT_FALSE(log.load_trials(session)[2].answer);
}

TEST_F(TrialLogFailure, AFolderThatIsRemovedStopsTheSession) {
  const fs::path home = folder_.path() / "study";
  fs::create_directory(home);
  path_ = home / "responses.sqlite";
  const auto session = make_log(3);
  TrialLog log(path_);
  fs::remove_all(home);
  expect_error<StoreError>(
      [&] {
        log.append_answer(session, {0, Side::kLeft, 10}, 1, 1);
      },
      "moved or removed while it was open");
}

TEST_F(TrialLogFailure, AnotherFileInItsPlaceStopsTheSession) {
  const auto session = make_log(3);
  TrialLog log(path_);
  fs::copy_file(path_, folder_.path() / "copy");
  fs::rename(folder_.path() / "copy", path_);
  expect_error<StoreError>(
      [&] {
        log.append_answer(session, {0, Side::kLeft, 10}, 1, 1);
      },
      "moved or removed while it was open");
}

TEST_F(TrialLogFailure, AReadOnlyFolderIsAStoreErrorThatSaysWhatToLookAt) {
  make_log(2);
  const ReadOnlyFolder read_only(folder_.path());
  expect_error<StoreError>([&] { TrialLog{path_}; }, "look at the permissions");
}

TEST_F(TrialLogFailure, AFolderThatBecomesReadOnlyInMidSessionKeepsWhatItHas) {
  const auto session = make_log(3);
  {
    TrialLog log(path_);
    log.append_answer(session, {0, Side::kLeft, 10}, 1, 1);
    const ReadOnlyFolder read_only(folder_.path());
    EXPECT_NO_THROW(log.append_answer(session, {1, Side::kLeft, 10}, 2, 2)) << "its files are open";
  }
  EXPECT_TRUE(TrialLog(path_).load_trials(session)[1].answer);
}

}  // namespace
}  // namespace equilux
