// Reading a log that others write, or left as they were killed, or that nobody can write.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>

#include "base/error.h"
#include "base/files.h"
#include "experiment/trial_log.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"
#include "tests/experiment/raw_database.h"
#include "tests/experiment/unprivileged.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

using ::testing::HasSubstr;

class Snapshot : public ::testing::Test {
 protected:
  // A log whose answer is in the WAL alone, as a killed program leaves it; the index only where `with_index`.
  void leave_wal(bool with_index) const {
    const fs::path live = source_.path() / "responses.sqlite";
    TrialLog log(live, true);
    log.append_session(make_fake_session(), make_fake_trials(2));
    log.append_answer(1, {0, Side::kLeft, 1000}, 1, 5000);
    fs::copy(live, path_);
    fs::copy(live.string() + "-wal", path_.string() + "-wal");
    if (with_index) fs::copy(live.string() + "-shm", path_.string() + "-shm");
  }
  void make_closed_log() const {
    TrialLog log(path_, true);
    log.append_session(make_fake_session(), make_fake_trials(2));
    log.append_answer(1, {0, Side::kLeft, 1000}, 1, 5000);
  }
  bool sees_answer() const { return TrialLog::load_snapshot(path_).load_trials(1).at(0).answer.has_value(); }
  std::map<std::string, std::string> load_files() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(folder_.path()))
      files[entry.path().filename().string()] = read_bytes(entry.path());
    return files;
  }

  TemporaryFolder source_, folder_;
  fs::path path_ = folder_.path() / "a study?100%#1.sqlite";  // also a name that is no plain URI
};

TEST_F(Snapshot, OfALeftWalSeesItsAnswersAndLeavesIt) {
  leave_wal(false);
  const auto before = load_files();
  EXPECT_TRUE(sees_answer());
  auto after = load_files();
  after.erase(path_.filename().string() + "-shm");  // the index, which a reader may make
  EXPECT_EQ(after, before);
}

TEST_F(Snapshot, OfALeftWalInAReadOnlyFolderSeesItsAnswersAndTouchesNothing) {
  for (const bool with_index : {false, true}) {
    for (const auto& entry : fs::directory_iterator(folder_.path())) fs::remove(entry);
    for (const auto& entry : fs::directory_iterator(source_.path())) fs::remove(entry);
    leave_wal(with_index);
    const auto before = load_files();
    {
      const ReadOnlyFolder read_only(folder_.path());
      EXPECT_TRUE(sees_answer()) << "with the WAL's index: " << with_index;
    }
    EXPECT_EQ(load_files(), before);
  }
}

TEST_F(Snapshot, OfAClosedLogInAReadOnlyFolderSeesItsAnswersAndTouchesNothing) {
  make_closed_log();
  const auto before = load_files();
  {
    const ReadOnlyFolder read_only(folder_.path());
    EXPECT_TRUE(sees_answer());
  }
  EXPECT_EQ(load_files(), before);
}

// What was recorded may all be in a WAL that cannot be read there: to say "no sessions" would be a guess.
TEST_F(Snapshot, AReadOnlyFileOfNobodyWithAWalIsNotTakenForNone) {
  RawDatabase(path_).query("PRAGMA journal_mode = WAL");
  {
    const ReadOnlyFolder read_only(folder_.path());
    EXPECT_FALSE(TrialLog::is_at(path_));
  }
  save_text(path_.string() + "-wal", std::string(100, 'x'));
  const ReadOnlyFolder read_only(folder_.path());
  EXPECT_TRUE(TrialLog::is_at(path_));
}

TEST_F(Snapshot, OfALogThatCannotBeReadIsAStoreError) {
  make_closed_log();
  fs::permissions(path_, fs::perms::none);
  const ReadOnlyFolder read_only(folder_.path());
  EXPECT_THAT(message_of<StoreError>([&] { sees_answer(); }), HasSubstr("cannot open"));
}

TEST_F(Snapshot, SeesALogThatAnotherProgramIsWriting) {
  make_closed_log();
  const RawDatabase other(path_);
  other.query("BEGIN IMMEDIATE");
  other.query("UPDATE trial SET too_fast = 1");
  EXPECT_FALSE(TrialLog::load_snapshot(path_).load_trials(1).at(0).too_fast) << "it is not committed yet";
  other.query("COMMIT");
  EXPECT_TRUE(TrialLog::load_snapshot(path_).load_trials(1).at(0).too_fast);
}

TEST_F(Snapshot, IsOfAReadOnlyLogThatCannotBeWritten) {
  make_closed_log();
  const ReadOnlyFolder read_only(folder_.path());
  EXPECT_THAT(message_of<StoreError>([&] {
                TrialLog(path_).append_answer(1, {1, Side::kLeft, 5}, {}, 1);
              }),
              HasSubstr(path_.string()));
}

}  // namespace
}  // namespace equilux
