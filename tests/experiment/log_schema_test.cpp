// Logs of older schemas, and logs that are read while they are written.
#include "experiment/log_schema.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"
#include "tests/experiment/old_log.h"
#include "tests/experiment/raw_database.h"

namespace equilux {

namespace {
namespace fs = std::filesystem;

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class LogSchema : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  fs::path path_ = folder_.path() / "responses.sqlite";
};

TEST_F(LogSchema, AnOlderLogIsBroughtUpAndACopyOfItIsKept) {
  make_old_log(path_);
  const Rows trials = RawDatabase(path_).query("SELECT * FROM trial"),
             events = RawDatabase(path_).query("SELECT * FROM event");
  {
    const TrialLog log(path_);
    const auto sessions = log.load_sessions();
    ASSERT_EQ(sessions.size(), 2u);
    EXPECT_EQ(sessions[0].participant, "P01");
    EXPECT_TRUE(sessions[0].complete);
    EXPECT_EQ(sessions[1].digests, (SessionDigests{"s", "m", "w", "", "", ""}));
    EXPECT_EQ(sessions[1].screen.framebuffer_width, std::optional(1920));
    EXPECT_NE(sessions[0].uuid, sessions[1].uuid);
    EXPECT_EQ(sessions[0].station, sessions[1].station);
    EXPECT_EQ(log.load_answers(SubjectKind::kPerson, Experiment::kArtifact).size(), 2u);
    EXPECT_EQ(log.load_trials(1).at(1).response_time_ns, std::optional<std::int64_t>(1000));
    EXPECT_FALSE(log.load_trials(2).at(1).answer);
  }
  EXPECT_EQ(RawDatabase(path_).query("SELECT * FROM event"), events);
  const fs::path kept = folder_.path() / "responses.v1.sqlite";
  EXPECT_THAT(find_kept_copies(path_), ElementsAre(kept));
  EXPECT_EQ(RawDatabase(kept).query("SELECT * FROM trial"), trials);
  EXPECT_EQ(RawDatabase(kept).value("PRAGMA user_version"), "1");
  EXPECT_EQ(fs::status(kept).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(LogSchema, TheTablesAfterAreThoseOfANewLog) {
  make_old_log(path_);
  TrialLog{path_};
  const fs::path fresh = folder_.path() / "fresh.sqlite";
  TrialLog(fresh, true);
  const char* tables = "SELECT name, sql FROM sqlite_schema ORDER BY name";
  EXPECT_EQ(RawDatabase(path_).query(tables), RawDatabase(fresh).query(tables));
}

TEST_F(LogSchema, TwoCopiesOfAnOlderLogGetTheSameIdentities) {
  make_old_log(path_);
  const fs::path other = folder_.path() / "other.sqlite";
  { TrialLog{path_}; }
  fs::copy(folder_.path() / "responses.v1.sqlite", other);
  const auto first = TrialLog(path_).load_sessions(), second = TrialLog(other).load_sessions();
  EXPECT_EQ(first[0].uuid, second[0].uuid);
  EXPECT_EQ(first[1].station, second[1].station);
}

TEST_F(LogSchema, AnEarlierCopyIsNeverOverwritten) {
  make_old_log(path_);
  save_text(folder_.path() / "responses.v1.sqlite", "an earlier one");
  TrialLog{path_};
  EXPECT_EQ(load_text(folder_.path() / "responses.v1.sqlite"), "an earlier one");
  EXPECT_EQ(find_kept_copies(path_).size(), 2u);
}

TEST_F(LogSchema, AFailedMigrationLeavesTheLogAsItWas) {
  make_old_log(path_);
  RawDatabase(path_).query("PRAGMA foreign_keys = OFF");
  RawDatabase(path_).query("UPDATE trial SET session = 9 WHERE session = 2");
  EXPECT_THROW(TrialLog{path_}, InputError);
  EXPECT_EQ(RawDatabase(path_).value("PRAGMA user_version"), "1");
  EXPECT_EQ(RawDatabase(path_).value("SELECT count(*) FROM trial"), "4");
}

TEST_F(LogSchema, ASnapshotSeesWhatIsCommittedAndTouchesNothing) {
  TrialLog writer(path_, true);
  const auto session = writer.append_session(make_fake_session(), make_fake_trials(2));
  writer.append_answer(session, {0, Side::kLeft, 1000}, 1, 5000);
  const std::string digest = digest_file(path_), wal = digest_file(path_.string() + "-wal");
  const TrialLog snapshot = TrialLog::load_snapshot(path_);
  writer.append_answer(session, {1, Side::kLeft, 1000}, std::nullopt, 6000);
  EXPECT_TRUE(snapshot.load_trials(session).at(0).answer);
  EXPECT_FALSE(snapshot.load_trials(session).at(1).answer);
  EXPECT_EQ(digest_file(path_), digest);
  EXPECT_NE(digest_file(path_.string() + "-wal"), wal) << "otherwise the second answer was not in the WAL";
}

TEST_F(LogSchema, ASnapshotOfAnOlderLogLeavesItOld) {
  make_old_log(path_);
  EXPECT_EQ(TrialLog::load_snapshot(path_).load_sessions().size(), 2u);
  EXPECT_EQ(RawDatabase(path_).value("PRAGMA user_version"), "1");
  EXPECT_THAT(find_kept_copies(path_), IsEmpty());
}

}  // namespace
}  // namespace equilux
