// Several stations' logs become one, or nothing happens and it is said why.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "base/random.h"
#include "experiment/merge_logs.h"
#include "experiment/withdraw.h"
#include "tests/experiment/child.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"
#include "tests/experiment/old_log.h"
#include "tests/experiment/raw_database.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

constexpr int kTrials = 4;
const std::string kStudy = "study";  ///< digest of the study of make_fake_session

class Merge : public ::testing::Test {
 protected:
  // A session of `code`, with so many answers; finished with all.
  static std::int64_t add(const fs::path& log_path, const std::string& code, std::int64_t index,
                          int answers = kTrials, const SessionRow& like = make_fake_session()) {
    TrialLog log(log_path, true);
    SessionRow row = like;
    row.participant = code;
    row.subject_index = index;
    const auto session = log.append_session(row, make_fake_trials(kTrials));
    log.append_showing(session, 0, 1);
    answer(log, session, 0, answers);
    return session;
  }
  static void answer(TrialLog& log, std::int64_t session, int from, int to, Side side = Side::kLeft) {
    for (int trial = from; trial < to; ++trial) {
      const auto next = trial + 1 < kTrials ? std::optional(trial + 1) : std::nullopt;
      log.append_answer(session, {trial, side, 1000 + trial}, next, trial);
    }
    if (to == kTrials) log.finish_session(session, 99);
  }
  MergePlan merge(const std::vector<fs::path>& others) const { return merge_logs(ours_, others, kStudy); }
  std::string conflict_with(const std::vector<fs::path>& others) const {
    const auto before = fs::exists(ours_) ? load_whole_content(ours_) : std::vector<Rows>{};
    const std::string message = message_of<InputError>([&] { merge(others); });
    EXPECT_EQ(fs::exists(ours_) ? load_whole_content(ours_) : std::vector<Rows>{}, before)
        << "nothing is written";
    return message;
  }
  std::string value(const std::string& sql) const { return RawDatabase(ours_).value(sql); }
  // A station's log, and copies of it at two moments before its end.
  static void write_station(const fs::path& log, std::uint64_t station, RandomStream& random,
                            std::vector<fs::path>& logs) {
    const auto sessions = 1 + random.next_below(3);
    for (std::uint64_t session = 0; session < sessions; ++session) {
      const int early = static_cast<int>(random.next_below(kTrials)), late = early + 1;
      const auto index = static_cast<std::int64_t>(10 * station + session);
      const auto id = add(log, fmt::format("P{}", index), index, early);
      if (session < 2) {
        logs.push_back(fmt::format("{}.{}", log.string(), session));
        fs::copy(log, logs.back());
      }
      TrialLog open(log);
      if (random.next_below(2) == 0) answer(open, id, early, late);
    }
    logs.push_back(log);
  }
  // What a log says, whatever its row numbers are.
  Rows load_meaning() const { return load_meaning(ours_); }
  static Rows load_meaning(const fs::path& log) {
    return RawDatabase(log).query(
        "SELECT uuid, station, code, subject_index, complete, trial.trial, answer, response_time_ns, "
        "answered_utc"
        " FROM session JOIN participant ON participant.id = participant JOIN trial ON trial.session = "
        "session.id"
        " ORDER BY uuid, trial.trial");
  }

  TemporaryFolder folder_;
  fs::path ours_ = folder_.path() / "ours.sqlite", first_ = folder_.path() / "first.sqlite",
           second_ = folder_.path() / "second.sqlite";
};

TEST_F(Merge, RefusesCodesThatDifferInTheCaseOfLettersAlone) {
  add(ours_, "P01", 0);
  add(first_, "p01", 1);
  EXPECT_THAT(conflict_with({first_}), AllOf(HasSubstr("p01"), HasSubstr("ours.sqlite has P01")));
  add(second_, "P01b", 1);
  EXPECT_EQ(merge({second_}).added.size(), 1u);
}

TEST_F(Merge, TakesInTheSessionsOfTwoStationsWhole) {
  add(ours_, "A", 0);
  add(first_, "B", 1);
  SessionRow row = make_fake_session();
  row.fields = {{"age_band", "20-29"}};
  add(second_, "C", 2, 2, row);
  const MergePlan plan = merge({first_, second_});
  EXPECT_EQ(plan.added.size(), 2u);
  EXPECT_THAT(plan.remarks, IsEmpty());
  const TrialLog log(ours_);
  const auto sessions = log.load_sessions();
  ASSERT_EQ(sessions.size(), 3u);
  EXPECT_EQ(sessions[1].participant, "B");
  EXPECT_TRUE(sessions[1].complete);
  EXPECT_FALSE(sessions[2].complete);
  EXPECT_EQ(sessions[2].fields.at("age_band"), "20-29");
  const TrialLog theirs(second_);
  EXPECT_EQ(sessions[2].uuid, theirs.load_sessions()[0].uuid);
  EXPECT_EQ(sessions[2].station, theirs.load_sessions()[0].station);
  EXPECT_EQ(log.load_trials(3), theirs.load_trials(1));
  EXPECT_EQ(log.load_events(3), theirs.load_events(1));
  EXPECT_EQ(log.load_answers(SubjectKind::kPerson, Experiment::kArtifact).size(), 2u * kTrials);
}

TEST_F(Merge, OnceMoreChangesNothing) {
  add(ours_, "A", 0);
  add(first_, "B", 1);
  merge({first_});
  const auto before = load_whole_content(ours_);
  const MergePlan again = merge({first_, first_, ours_});
  EXPECT_EQ(again.kept, 1 + 1 + 2);
  EXPECT_TRUE(again.added.empty() && again.replaced.empty());
  EXPECT_EQ(load_whole_content(ours_), before);
}

TEST_F(Merge, GivesTheSameWhateverTheOrder) {
  add(first_, "B", 1);
  add(second_, "C", 2, 3);
  merge({first_, second_});
  const Rows one_way = load_meaning();
  fs::remove(ours_);
  merge({second_});
  merge({first_});
  EXPECT_EQ(load_meaning(), one_way);
}

TEST_F(Merge, MakesALogWhereThereIsNone) {
  add(first_, "B", 1);
  EXPECT_EQ(merge({first_}).added.size(), 1u);
  EXPECT_EQ(fs::status(ours_).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_NE(value("SELECT station FROM log"), RawDatabase(first_).value("SELECT station FROM log"));
}

TEST_F(Merge, TakesTheLongerOfTwoCopiesOfASession) {
  add(first_, "B", 1, 2);
  merge({first_});
  {
    TrialLog log(first_);
    log.append_event(1, "resume", 0, "{}");
    answer(log, 1, 2, kTrials);
    log.append_field(1, "ambient_lux", "40");
  }
  fs::copy(ours_, second_);
  const MergePlan plan = merge({first_});
  EXPECT_EQ(plan.replaced.size(), 1u);
  EXPECT_EQ(TrialLog(ours_).load_trials(TrialLog(ours_).load_sessions().at(0).id),
            TrialLog(first_).load_trials(1));
  EXPECT_EQ(value("SELECT count(*) FROM session"), "1");
  EXPECT_EQ(value("SELECT value FROM field"), "40");
  EXPECT_EQ(merge({second_}).kept, 1) << "the shorter copy takes nothing back";
  EXPECT_EQ(value("SELECT complete FROM session"), "1");
}

TEST_F(Merge, TakesTheLongestOfThreeCopies) {
  add(first_, "B", 1, 1);
  merge({first_});
  fs::copy(first_, second_);
  {
    TrialLog log(second_);
    answer(log, 1, 1, 2);
  }
  fs::copy(second_, folder_.path() / "third.sqlite");
  {
    TrialLog log(folder_.path() / "third.sqlite");
    answer(log, 1, 2, 3);
  }
  merge({second_, folder_.path() / "third.sqlite", first_});
  EXPECT_EQ(value("SELECT count(*) FROM trial WHERE answer IS NOT NULL"), "3");
}

// Seed 73: 25 rounds of 1 to 3 stations with 1 to 3 sessions each, of 0 to 4 answers; every log also as it
// was at two earlier moments. Merged at once or one by one, in any order, they give what the stations have at
// the end.
TEST_F(Merge, OfCopiesFromAnyMomentInAnyOrderGivesWhatTheStationsHave) {
  RandomStream random(73, "merge", 0);
  for (int round = 0; round < 25; ++round) {
    for (const auto& entry : fs::directory_iterator(folder_.path())) fs::remove(entry);
    Rows expected;
    std::vector<fs::path> logs;
    const auto stations = 1 + random.next_below(3);
    for (std::uint64_t station = 0; station < stations; ++station) {
      const fs::path log = folder_.path() / fmt::format("station{}.sqlite", station);
      write_station(log, station, random, logs);
      const Rows meaning = load_meaning(log);
      expected.insert(expected.end(), meaning.begin(), meaning.end());
    }
    for (std::size_t i = logs.size() - 1; i > 0; --i) std::swap(logs[i], logs[random.next_below(i + 1)]);
    if (random.next_below(2) == 0) {
      merge(logs);
    } else {
      for (const fs::path& log : logs) merge({log});
    }
    std::sort(expected.begin(), expected.end());
    Rows merged = load_meaning(ours_);
    std::sort(merged.begin(), merged.end());
    ASSERT_EQ(merged, expected) << "round " << round;
  }
}

TEST_F(Merge, RefusesTheSameSessionWithOtherAnswers) {
  add(first_, "B", 1, 2);
  merge({first_});
  fs::copy(first_, second_);
  {
    TrialLog log(first_), other(second_);
    answer(log, 1, 2, 3, Side::kLeft);
    answer(other, 1, 2, 3, Side::kRight);
  }
  EXPECT_THAT(conflict_with({first_, second_}),
              AllOf(HasSubstr("second.sqlite: B, person, artifact, index 1"),
                    HasSubstr("other answers or events in"), HasSubstr("first.sqlite")));
}

TEST_F(Merge, RefusesAParticipantWhoFinishedAtBothStations) {
  add(ours_, "A", 0);
  add(first_, "A", 1);
  EXPECT_THAT(conflict_with({first_}), HasSubstr("finished the same experiment in"));
}

TEST_F(Merge, RemarksAParticipantWhoBeganAtOneStationAndFinishedAtAnother) {
  add(ours_, "A", 0, 2);
  add(first_, "A", 1);
  EXPECT_THAT(merge({first_}).remarks, ElementsAre(HasSubstr("A has more than one session in the artifact")));
}

TEST_F(Merge, TakesAParticipantOfBothExperimentsForTheSame) {
  add(ours_, "A", 0);
  SessionRow material = make_fake_session(0, SubjectKind::kPerson, Experiment::kMaterial);
  add(first_, "A", 0, kTrials, material);
  EXPECT_THAT(merge({first_}).remarks,
              ElementsAre(AllOf(HasSubstr("A has sessions of two stations, in "), HasSubstr("first.sqlite"),
                                HasSubstr("--rename A=NEW"))));
  EXPECT_EQ(value("SELECT count(*) FROM participant"), "1");
  EXPECT_THAT(merge({first_}).remarks, IsEmpty()) << "it was said";
}

// Each digest by itself, and the words by which it is named.
TEST_F(Merge, RefusesSessionsThatWereMadeFromOtherFiles) {
  add(ours_, "A", 0);
  const std::pair<std::string SessionDigests::*, const char*> digests[] = {
      {&SessionDigests::study, "its study has the digest other, the folder's study"},
      {&SessionDigests::manifest, "its set of pictures has the digest other"},
      {&SessionDigests::windows, "its windows.json has the digest other"},
      {&SessionDigests::selection, "its selection has the digest other"},
      {&SessionDigests::truth, "its truth has the digest other"}};
  for (const auto& [member, words] : digests) {
    fs::remove(first_);
    SessionRow row = make_fake_session();
    row.digests.*member = "other";
    add(first_, "B", 1, kTrials, row);
    EXPECT_THAT(conflict_with({first_}), AllOf(HasSubstr("conflicts, 1;"), HasSubstr(words)));
  }
}

TEST_F(Merge, RefusesAnotherProtocolButTakesAnUnknownOne) {
  SessionRow row = make_fake_session();
  row.digests.protocol = "one";
  add(ours_, "A", 0, kTrials, row);
  row.digests.protocol = "two";
  add(first_, "B", 1, kTrials, row);
  EXPECT_THAT(conflict_with({first_}), HasSubstr("its session.json has the digest two"));
  add(second_, "C", 2);
  EXPECT_EQ(merge({second_}).added.size(), 1u);
}

TEST_F(Merge, NamesAllConflictsAtOnceAndTakesNothing) {
  add(ours_, "A", 0);
  add(ours_, "B", 1);
  add(first_, "A", 2);
  add(first_, "C", 3);
  SessionRow row = make_fake_session();
  row.digests.windows = "other";
  add(second_, "B", 4, kTrials, row);
  const std::string message = conflict_with({first_, second_});
  EXPECT_THAT(message, AllOf(HasSubstr("conflicts, 3;"), HasSubstr("A, person"), HasSubstr("B, person"),
                             HasSubstr("windows.json"), Not(HasSubstr("C, person"))));
}

TEST_F(Merge, RefusesTwoSessionsOfOneStationWithOneIndex) {
  add(ours_, "A", 0);
  fs::copy(ours_, first_);
  add(ours_, "B", 1);
  add(first_, "C", 1);
  EXPECT_THAT(conflict_with({first_}), HasSubstr("one log was copied and both went on"));
}

TEST_F(Merge, RemarksEqualIndicesOfTwoStations) {
  add(ours_, "A", 0);
  add(first_, "B", 0);
  EXPECT_THAT(merge({first_}).remarks, ElementsAre(AllOf(HasSubstr("balance: A, person, artifact, index 0"),
                                                         HasSubstr("B, person, artifact, index 0"))));
  EXPECT_THAT(merge({first_}).remarks, IsEmpty()) << "it was said";
}

TEST_F(Merge, RefusesWhoWithdrewHere) {
  add(ours_, "A", 0);
  add(first_, "B", 1);
  merge({first_});
  withdraw_participant(ours_, "B");
  EXPECT_THAT(conflict_with({first_}), HasSubstr("withdrew; withdraw there too"));
}

TEST_F(Merge, RefusesWhoWithdrewHereInOtherLettersToo) {
  for (const auto& [here, there] : {std::pair("P01", "p01"), {"Anna7", "anna7"}, {"b2", "B2"}}) {
    add(ours_, here, 0);
    withdraw_participant(ours_, here);
    const fs::path log = folder_.path() / (std::string(there) + ".sqlite");
    add(log, there, 1);
    EXPECT_THAT(conflict_with({log}), HasSubstr("withdrew; withdraw there too")) << there;
  }
}

TEST_F(Merge, ErasesHereWhoWithdrewThere) {
  add(ours_, "A", 0);
  add(first_, "Withdrawing-4711", 1);
  merge({first_});
  withdraw_participant(first_, "Withdrawing-4711");
  add(first_, "C", 1);  // the index is free again at that station
  const MergePlan plan = merge({first_});
  EXPECT_THAT(plan.erased, ElementsAre("Withdrawing-4711"));
  EXPECT_EQ(plan.added.size(), 1u);
  EXPECT_EQ(read_bytes(ours_).find("Withdrawing-4711"), std::string::npos);
  EXPECT_EQ(value("SELECT count(DISTINCT salt) FROM tombstone"), "1");
  EXPECT_EQ(merge({first_}).tombstones.size(), 0u);
  SessionRow again = make_fake_session(5);
  again.participant = "Withdrawing-4711";
  EXPECT_THROW(TrialLog(ours_).append_session(again, {}), InputError);
}

std::vector<std::string> load_export_places(const fs::path& log) {
  std::vector<std::string> places;
  for (const ExportRow& row : TrialLog(log).load_exports())
    places.push_back((row.station.empty() ? "here" : row.station) + " " + row.path);
  std::sort(places.begin(), places.end());
  return places;
}

// So that a withdrawal names them, wherever it is asked for.
TEST_F(Merge, KnowsOfTheExportsOfAllStations) {
  add(ours_, "A", 0);
  add(first_, "B", 1);
  add(second_, "C", 2);
  TrialLog(ours_).append_export("/answers");
  TrialLog(first_).append_export("/answers");
  TrialLog(first_).append_export("/answers");
  TrialLog(second_).append_export("/tmp/a:b");
  const std::string first = TrialLog(first_).load_station(), second = TrialLog(second_).load_station();
  EXPECT_EQ(merge({first_, second_}).exports.size(), 2u);
  std::vector<std::string> expected{"here /answers", first + " /answers", second + " /tmp/a:b"};
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(load_export_places(ours_), expected);
  EXPECT_THAT(
      format_withdrawal(plan_withdrawal(ours_, "B")),
      AllOf(HasSubstr("  /answers, of "), HasSubstr("at station " + first.substr(0, 8) + ": /answers, of"),
            HasSubstr("at station " + second.substr(0, 8) + ": /tmp/a:b, of")));
}

TEST_F(Merge, OfTheSameExportsOnceMoreChangesNothingAndALaterOneIsSeen) {
  add(ours_, "A", 0);
  add(first_, "B", 1);
  TrialLog(first_).append_export("/answers");
  merge({first_});
  const auto before = load_whole_content(ours_);
  EXPECT_THAT(merge({first_, first_, ours_}).exports, IsEmpty());
  EXPECT_EQ(load_whole_content(ours_), before);
  RawDatabase(first_).query(
      "INSERT INTO export (path, made_utc) VALUES ('/answers', '2999-01-01T00:00:00.000Z')");
  EXPECT_EQ(merge({first_}).exports.size(), 1u);
  const auto exports = TrialLog(ours_).load_exports();
  ASSERT_EQ(exports.size(), 1u) << "each path once, with its last time";
  EXPECT_EQ(exports[0].made_utc, "2999-01-01T00:00:00.000Z");
}

// Through a log that holds what others have: each stays with its station, and ours are not another's.
TEST_F(Merge, KnowsWhoseExportsTheyAreOverTwoMerges) {
  add(ours_, "A", 0);
  add(first_, "B", 1);
  TrialLog(ours_).append_export("/ours");
  TrialLog(first_).append_export("/first");
  merge_logs(second_, {ours_, first_}, kStudy);
  const std::string ours = TrialLog(ours_).load_station(), first = TrialLog(first_).load_station();
  EXPECT_THAT(load_export_places(second_), UnorderedElementsAre(ours + " /ours", first + " /first"));
  merge({second_});
  EXPECT_THAT(load_export_places(ours_), UnorderedElementsAre("here /ours", first + " /first"));
}

TEST_F(Merge, ReadsALogOfAnOlderSchemaWithoutChangingIt) {
  make_old_log(first_);
  const std::string digest = digest_file(first_);
  EXPECT_EQ(merge_logs(ours_, {first_}, "s").added.size(), 2u);
  EXPECT_EQ(merge_logs(ours_, {first_}, "s").kept, 2);
  EXPECT_EQ(digest_file(first_), digest);
  EXPECT_EQ(RawDatabase(first_).value("PRAGMA user_version"), "1");
}

TEST_F(Merge, IsAllOrNothingOnAFullDisk) {
  add(ours_, "A", 0);
  SessionRow row = make_fake_session();
  row.fields = {{"remark", std::string(300'000, 'x')}};
  add(first_, "B", 1);
  add(first_, "C", 2, kTrials, row);
  const auto before = load_whole_content(ours_);
  {
    const FileSizeLimit limit(200'000);
    EXPECT_THROW(merge({first_}), StoreError);
  }
  EXPECT_EQ(load_whole_content(ours_), before);
  EXPECT_EQ(merge({first_}).added.size(), 2u);
}

TEST_F(Merge, NeedsTheLogForItself) {
  add(ours_, "A", 0);
  add(first_, "B", 1);
  const TrialLog other(ours_);
  EXPECT_THAT(message_of<StoreError>([&] { merge({first_}); }), HasSubstr("another program has it open"));
}

class MergeProgram : public ::testing::Test {
 protected:
  TemporaryFolder temporary_;
  StudyFolder folder_ = make_fake_study(temporary_.path() / "here"),
              other_ = make_fake_study(temporary_.path() / "there");
};

TEST_F(MergeProgram, TakesLogsOrStudyFoldersAndSaysWhatItDid) {
  run_session_program({"simulate", other_.root.string(), "--experiment", "artifact", "--subjects", "2"});
  const ChildResult first = run_session_program({"merge", folder_.root.string(), other_.root.string()});
  EXPECT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, HasSubstr("sessions: 2 added"));
  const ChildResult second =
      run_session_program({"merge", folder_.root.string(), other_.responses().string()});
  EXPECT_THAT(second.out, HasSubstr("sessions: 0 added, 0 further along than here, 2 known already"));
}

TEST_F(MergeProgram, AsksBeforeItErasesWhoWithdrewElsewhere) {
  run_session_program({"simulate", other_.root.string(), "--experiment", "artifact", "--subjects", "2"});
  run_session_program({"merge", folder_.root.string(), other_.root.string()});
  run_session_program({"withdraw", other_.root.string(), "planted-1-1", "--yes"});
  TrialLog(folder_.responses()).append_export("/somewhere/answers");
  const std::string words = kSessionProgram + " merge " + folder_.root.string() + " " + other_.root.string();
  const ChildResult asked = Child("/bin/sh", {"-c", words + " < /dev/null"}).wait();
  EXPECT_EQ(asked.exit_code, 1);
  EXPECT_THAT(asked.err, HasSubstr("nothing was erased"));
  EXPECT_EQ(TrialLog(folder_.responses()).load_sessions().size(), 2u);
  const ChildResult done = Child("/bin/sh", {"-c", words + " --yes"}).wait();
  EXPECT_THAT(done.out, AllOf(HasSubstr("1 taken over, 1 erased here"), HasSubstr("/somewhere/answers")));
  EXPECT_EQ(TrialLog(folder_.responses()).load_sessions().size(), 1u);
}

}  // namespace
}  // namespace equilux
