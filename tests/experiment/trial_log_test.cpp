// What is appended comes back, in a file that stands for itself.
#include "experiment/trial_log.h"

#include <algorithm>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <optional>

#include "base/digest.h"
#include "base/error.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"
#include "tests/experiment/raw_database.h"

namespace equilux {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

class TrialLogTest : public ::testing::Test {
 protected:
  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_.path() / "responses.sqlite";
};

TEST_F(TrialLogTest, GivesBackASessionAsItWasAppended) {
  SessionRow row = make_fake_session(3, SubjectKind::kPlanted, Experiment::kMaterial);
  row.seed = (std::uint64_t{1} << 63) - 1;
  row.digests = {"s", "m", "", "sel", "t", "p"};
  row.fields = {{"age_band", "20-29"}, {"consent_version", "1"}};
  row.screen = {"HDMI-1", 1920, 1080, 0.4572, 16.25, 12.125};
  TrialLog log(path_, true);
  row.id = log.append_session(row, make_fake_trials(2));
  const auto sessions = log.load_sessions();
  ASSERT_EQ(sessions.size(), 1u);
  const SessionRow& loaded = sessions[0];
  EXPECT_EQ(loaded.id, row.id);
  EXPECT_EQ(loaded.participant, "P3");
  EXPECT_EQ(loaded.kind, SubjectKind::kPlanted);
  EXPECT_EQ(loaded.experiment, Experiment::kMaterial);
  EXPECT_EQ(loaded.subject_index, 3);
  EXPECT_EQ(loaded.seed, row.seed);
  EXPECT_EQ(loaded.program_version, row.program_version);
  EXPECT_EQ(loaded.digests, row.digests);
  EXPECT_EQ(loaded.screen.monitor, "HDMI-1");
  EXPECT_EQ(loaded.screen.framebuffer_width, std::optional(1920));
  EXPECT_EQ(loaded.screen.framebuffer_height, std::optional(1080));
  EXPECT_EQ(loaded.screen.viewing_distance_m, std::optional(0.4572));
  EXPECT_EQ(loaded.screen.degrees_wide, std::optional(16.25));
  EXPECT_EQ(loaded.screen.degrees_high, std::optional(12.125));
  EXPECT_EQ(loaded.started_utc, row.started_utc);
  EXPECT_FALSE(loaded.complete);
  EXPECT_EQ(loaded.fields, row.fields);
  EXPECT_EQ(loaded.uuid.size(), 32u);
  EXPECT_EQ(loaded.station.size(), 32u);
}

// The file alone, without what stands beside it, while the log is open.
TEST_F(TrialLogTest, IsWholeInItsFileAfterASessionsStartAndOnceTheWalIsEmptied) {
  const auto load_copy = [&] {
    const auto copy = folder_.path() / "copy.sqlite";
    std::filesystem::copy_file(path_, copy, std::filesystem::copy_options::overwrite_existing);
    return TrialLog::load_snapshot(copy);
  };
  TrialLog log(path_, true);
  const std::int64_t id = log.append_session(make_fake_session(), make_fake_trials(3));
  ASSERT_EQ(load_copy().load_sessions().size(), 1u);
  EXPECT_EQ(load_copy().load_trials(id), log.load_trials(id));
  answer_all(log, id, 3);
  EXPECT_NE(load_copy().load_trials(id), log.load_trials(id)) << "otherwise emptying it does nothing";
  log.empty_wal();
  EXPECT_EQ(load_copy().load_trials(id), log.load_trials(id));
  EXPECT_EQ(load_copy().load_events(id), log.load_events(id));
  EXPECT_TRUE(load_copy().load_sessions()[0].complete);
}

TEST_F(TrialLogTest, EmptiesNoWalThatSomebodyReadsAndLosesNothing) {
  TrialLog log(path_, true);
  const std::int64_t id = log.append_session(make_fake_session(), make_fake_trials(3));
  const RawDatabase reader(path_);
  reader.query("BEGIN");
  reader.query("SELECT count(*) FROM trial");
  answer_all(log, id, 3);
  log.empty_wal();
  reader.query("COMMIT");
  EXPECT_TRUE(TrialLog::load_snapshot(path_).load_sessions()[0].complete);
}

TEST_F(TrialLogTest, KeepsWhyAPairIsShownAndWhetherItsAnswerCameTooSoon) {
  TrialLog log(path_, true);
  auto trials = make_fake_trials(3);
  trials[0].phase = Phase::kPractice;
  trials[2].phase = Phase::kCatch;
  const auto session = log.append_session(make_fake_session(), trials);
  log.append_answer(session, {1, Side::kLeft, 1000, true}, 2, 5000);
  const auto loaded = log.load_trials(session);
  EXPECT_EQ(loaded[0].phase, Phase::kPractice);
  EXPECT_EQ(loaded[1].phase, Phase::kMain);
  EXPECT_EQ(loaded[2].phase, Phase::kCatch);
  EXPECT_TRUE(loaded[1].too_fast);
  EXPECT_FALSE(loaded[0].too_fast);
}

TEST_F(TrialLogTest, CountsAnswersOfTheMainPhaseAlone) {
  TrialLog log(path_, true);
  auto trials = make_fake_trials(4);
  trials[0].phase = Phase::kPractice;
  trials[3].phase = Phase::kCatch;
  answer_all(log, log.append_session(make_fake_session(), trials), 4);
  EXPECT_EQ(log.load_answers(SubjectKind::kPerson, Experiment::kArtifact).size(), 2u);
}

TEST_F(TrialLogTest, KeepsAFieldOnce) {
  TrialLog log(path_, true);
  const auto session = log.append_session(make_fake_session(), make_fake_trials(1));
  log.append_field(session, "refresh_hz", "59.94");
  EXPECT_EQ(log.load_sessions().at(0).fields.at("refresh_hz"), "59.94");
  EXPECT_THROW(log.append_field(session, "refresh_hz", "60"), StoreError);
}

TEST_F(TrialLogTest, IsForItsOwnersEyesAlone) {
  TrialLog log(path_, true);
  log.append_session(make_fake_session(), make_fake_trials(1));
  namespace fs = std::filesystem;
  for (const char* suffix : {"", "-wal", "-shm"}) {
    const fs::perms permissions = fs::status(path_.string() + suffix).permissions();
    EXPECT_EQ(permissions, fs::perms::owner_read | fs::perms::owner_write) << suffix;
  }
}

// One that was copied or restored; a group that may write it is meant to.
TEST_F(TrialLogTest, KeepsOthersOutAgainWhereTheyWereLetIn) {
  namespace fs = std::filesystem;
  {
    TrialLog log(path_, true);
  }
  const auto after_opening = [&](unsigned mode) {
    fs::permissions(path_, static_cast<fs::perms>(mode));
    TrialLog log(path_, false);
    return static_cast<unsigned>(fs::status(path_).permissions());
  };
  EXPECT_EQ(after_opening(0644), 0600u);
  EXPECT_EQ(after_opening(0666), 0660u);
  EXPECT_EQ(after_opening(0660), 0660u);
  EXPECT_EQ(after_opening(0600), 0600u);
}

TEST_F(TrialLogTest, KeepsWhatIsNotKnownOfAScreenEmpty) {
  TrialLog log(path_, true);
  log.append_session(make_fake_session(), make_fake_trials(1));
  const ScreenRecord screen = log.load_sessions().at(0).screen;
  EXPECT_EQ(screen.monitor, "");
  EXPECT_FALSE(screen.framebuffer_width || screen.framebuffer_height || screen.viewing_distance_m ||
               screen.degrees_wide || screen.degrees_high);
}

TEST_F(TrialLogTest, GivesBackTrialsInOrderWithTheirAnswers) {
  TrialLog log(path_, true);
  auto trials = make_fake_trials(3);
  trials[1].upper_key = "G1-MR-ind-ref-v0";
  const auto session = log.append_session(make_fake_session(), trials);
  log.append_showing(session, 0, 10);
  log.append_answer(session, {0, Side::kRight, 1234}, 1, 20);
  const auto loaded = log.load_trials(session);
  ASSERT_EQ(loaded.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(loaded[i].number, trials[i].number);
    EXPECT_EQ(loaded[i].cell, trials[i].cell);
    EXPECT_EQ(loaded[i].test_key, trials[i].test_key);
    EXPECT_EQ(loaded[i].pair_key, trials[i].pair_key);
    EXPECT_EQ(loaded[i].upper_key, trials[i].upper_key);
    EXPECT_EQ(loaded[i].test_side, trials[i].test_side);
  }
  EXPECT_EQ(loaded[0].answer, std::optional(Side::kRight));
  EXPECT_EQ(loaded[0].response_time_ns, std::optional<std::int64_t>(1234));
  EXPECT_TRUE(loaded[0].answered_utc);
  EXPECT_FALSE(loaded[1].answer || loaded[1].response_time_ns || loaded[1].answered_utc);
}

TEST_F(TrialLogTest, RecordsEveryShowingAnswerAndEndAsAnEvent) {
  TrialLog log(path_, true);
  const auto session = log.append_session(make_fake_session(), make_fake_trials(2));
  log.append_showing(session, 0, 10);
  log.append_event(session, "abort", 15, "window closed");
  log.append_showing(session, 0, 3);
  log.append_answer(session, {0, Side::kLeft, 5}, 1, 20);
  log.append_answer(session, {1, Side::kLeft, 5}, std::nullopt, 30);
  log.finish_session(session, 40);
  EXPECT_THAT(
      load_events(path_),
      ElementsAre(ElementsAre("1", "0", "showing", "10", ""),
                  ElementsAre("1", "NULL", "abort", "15", "window closed"),
                  ElementsAre("1", "0", "showing", "3", ""), ElementsAre("1", "0", "answer", "20", ""),
                  ElementsAre("1", "1", "showing", "20", ""), ElementsAre("1", "1", "answer", "30", ""),
                  ElementsAre("1", "NULL", "finish", "40", "")));
}

TEST_F(TrialLogTest, CountsOnlyFinishedSessionsOfOneKindAndExperiment) {
  TrialLog log(path_, true);
  const auto finished = log.append_session(make_fake_session(0), make_fake_trials(3));
  answer_all(log, finished, 3);
  const auto unfinished = log.append_session(make_fake_session(1), make_fake_trials(3));
  log.append_answer(unfinished, {0, Side::kLeft, 1}, 1, 1);
  answer_all(log, log.append_session(make_fake_session(0, SubjectKind::kPlanted), make_fake_trials(3)), 3);
  answer_all(log,
             log.append_session(make_fake_session(0, SubjectKind::kPerson, Experiment::kMaterial),
                                make_fake_trials(3)),
             3);
  const auto answers = log.load_answers(SubjectKind::kPerson, Experiment::kArtifact);
  ASSERT_EQ(answers.size(), 3u);
  for (const AnswerRow& answer : answers) {
    EXPECT_EQ(answer.session, finished);
    EXPECT_EQ(answer.subject_index, 0);
    EXPECT_TRUE(answer.correct);
  }
}

TEST_F(TrialLogTest, TellsCorrectAnswersFromWrongOnes) {
  TrialLog log(path_, true);
  const auto session = log.append_session(make_fake_session(), make_fake_trials(2));
  log.append_answer(session, {0, Side::kLeft, 1}, 1, 1);             // the test picture is left
  log.append_answer(session, {1, Side::kLeft, 1}, std::nullopt, 2);  // the test picture is right
  log.finish_session(session, 3);
  const auto answers = log.load_answers(SubjectKind::kPerson, Experiment::kArtifact);
  ASSERT_EQ(answers.size(), 2u);
  EXPECT_TRUE(answers[0].correct);
  EXPECT_FALSE(answers[1].correct);
}

TEST_F(TrialLogTest, FindsTheLowestFreeIndexOfAKindAndExperiment) {
  TrialLog log(path_, true);
  EXPECT_EQ(log.find_free_index(SubjectKind::kPerson, Experiment::kArtifact), 0);
  for (const int index : {0, 1, 3}) log.append_session(make_fake_session(index), {});
  log.append_session(make_fake_session(2, SubjectKind::kPlanted), {});
  log.append_session(make_fake_session(0, SubjectKind::kPerson, Experiment::kMaterial), {});
  EXPECT_EQ(log.find_free_index(SubjectKind::kPerson, Experiment::kArtifact), 2);
  EXPECT_EQ(log.find_free_index(SubjectKind::kPlanted, Experiment::kArtifact), 0);
  EXPECT_EQ(log.find_free_index(SubjectKind::kPerson, Experiment::kMaterial), 1);
  EXPECT_EQ(log.find_free_index(SubjectKind::kLooking, Experiment::kMaterial), 0);
}

TEST_F(TrialLogTest, SharesAParticipantBetweenExperiments) {
  TrialLog log(path_, true);
  log.append_session(make_fake_session(0), {});
  log.append_session(make_fake_session(0, SubjectKind::kPerson, Experiment::kMaterial), {});
  EXPECT_EQ(RawDatabase(path_).value("SELECT count(*) FROM participant"), "1");
  EXPECT_EQ(log.load_sessions().size(), 2u);
}

TEST_F(TrialLogTest, KnowsWhichSelectionsWereUsed) {
  TrialLog log(path_, true);
  SessionRow row = make_fake_session(0, SubjectKind::kPerson, Experiment::kMaterial);
  row.digests.selection = "abc";
  EXPECT_FALSE(log.has_session_using_selection("abc"));
  log.append_session(row, {});
  EXPECT_TRUE(log.has_session_using_selection("abc"));
  EXPECT_FALSE(log.has_session_using_selection("abd"));
}

TEST_F(TrialLogTest, RunsInWalModeFullySyncedWithForeignKeys) {
  TrialLog log(path_, true);
  EXPECT_EQ(log.load_setting("journal_mode"), "wal");
  EXPECT_EQ(log.load_setting("synchronous"), "2");
  EXPECT_EQ(log.load_setting("foreign_keys"), "1");
  const TrialLog again(path_);
  EXPECT_EQ(again.load_setting("journal_mode"), "wal");
  EXPECT_EQ(again.load_setting("synchronous"), "2");
  EXPECT_EQ(again.load_setting("foreign_keys"), "1");
}

TEST_F(TrialLogTest, SaysOfItselfWhatItIs) {
  { TrialLog log(path_, true); }
  const RawDatabase database(path_);
  EXPECT_EQ(database.value("PRAGMA application_id"), std::to_string(0x45514C58));
  EXPECT_EQ(database.value("PRAGMA user_version"), std::to_string(kLogSchemaVersion));
  for (const auto& row : database.query("SELECT name, strict FROM pragma_table_list WHERE schema = 'main'"
                                        " AND name NOT LIKE 'sqlite%'")) {
    EXPECT_EQ(row.at(1), "1") << row.at(0) << " is not STRICT";
  }
}

TEST_F(TrialLogTest, RefusesRowsThatBreakItsTables) {
  { TrialLog(path_, true).append_session(make_fake_session(), make_fake_trials(2)); }
  const RawDatabase database(path_);
  database.query("PRAGMA foreign_keys = ON");
  const auto refused = [&](const std::string& sql) {
    EXPECT_THROW(database.query(sql), std::runtime_error) << sql;
  };
  refused("UPDATE trial SET trial = 1 WHERE trial = 0");
  refused("UPDATE trial SET answer = 'left' WHERE trial = 0");
  refused("UPDATE trial SET answer = 'up', response_time_ns = 1, answered_utc = '' WHERE trial = 0");
  refused("UPDATE session SET kind = 'robot'");
  refused("UPDATE session SET subject_index = 'first'");
  refused("DELETE FROM session");
  refused(
      "INSERT INTO event (session, trial, kind, time_ns, recorded_utc, detail)"
      " VALUES (1, 7, 'showing', 0, '', '')");
}

TEST_F(TrialLogTest, LeavesOneWholeFileWhenClosed) {
  {
    TrialLog log(path_, true);
    answer_all(log, log.append_session(make_fake_session(), make_fake_trials(5)), 5);
    EXPECT_TRUE(std::filesystem::exists(path_.string() + "-wal"));
  }
  EXPECT_FALSE(std::filesystem::exists(path_.string() + "-wal"));
  EXPECT_FALSE(std::filesystem::exists(path_.string() + "-shm"));
  const auto copy = folder_.path() / "copy.sqlite";
  std::filesystem::copy_file(path_, copy);
  EXPECT_EQ(TrialLog(copy).load_answers(SubjectKind::kPerson, Experiment::kArtifact).size(), 5u);
}

TEST_F(TrialLogTest, LeavesOneWholeFileWhenClosedThoughAnotherHadItOpenBefore) {
  {
    std::optional<TrialLog> log(std::in_place, path_, true);
    {
      const TrialLog reader(path_);
      EXPECT_EQ(reader.load_sessions().size(), 0u);
    }
    answer_all(*log, log->append_session(make_fake_session(), make_fake_trials(5)), 5);
  }
  EXPECT_FALSE(std::filesystem::exists(path_.string() + "-wal"));
  EXPECT_FALSE(std::filesystem::exists(path_.string() + "-shm"));
}

TEST_F(TrialLogTest, LeavesAnEmptyWalWhenClosedWhileAnotherHasItOpen) {
  std::optional<TrialLog> log(std::in_place, path_, true);
  {
    const TrialLog reader(path_);
    answer_all(*log, log->append_session(make_fake_session(), make_fake_trials(5)), 5);
    log.reset();
    EXPECT_EQ(std::filesystem::file_size(path_.string() + "-wal"), 0u);
    const auto copy = folder_.path() / "copy.sqlite";
    std::filesystem::copy_file(path_, copy);
    EXPECT_EQ(TrialLog(copy).load_answers(SubjectKind::kPerson, Experiment::kArtifact).size(), 5u);
    EXPECT_TRUE(reader.load_sessions().at(0).complete);
  }
  EXPECT_FALSE(std::filesystem::exists(path_.string() + "-wal"));
}

TEST_F(TrialLogTest, CanBeReadWhileItIsWritten) {
  TrialLog log(path_, true);
  const auto session = log.append_session(make_fake_session(), make_fake_trials(2));
  const TrialLog reader(path_);
  log.append_answer(session, {0, Side::kLeft, 1}, 1, 1);
  EXPECT_TRUE(reader.load_trials(session).at(0).answer);
}

TEST_F(TrialLogTest, BriefTrialsAreTrialsWithoutNamesButViewsAndWithoutTimesOfDay) {
  TrialLog log(path_, true);
  auto trials = make_fake_trials(8);
  trials[2].phase = Phase::kCatch;
  trials[3].phase = Phase::kPractice;
  trials[5].test_key = "of no view";
  const auto session = log.append_session(make_fake_session(), trials);
  const auto other = log.append_session(make_fake_session(1), make_fake_trials(3));
  log.append_answer(session, {0, Side::kRight, 1234, true}, 1, 5000);
  const BriefTrials brief = log.load_brief_trials();
  EXPECT_EQ(brief.by_session.at(other).size(), 3u);
  const auto whole = log.load_trials(session);
  ASSERT_EQ(brief.by_session.at(session).size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const BriefTrial& trial = brief.by_session.at(session)[i];
    EXPECT_EQ(trial.number, whole[i].number);
    EXPECT_EQ(trial.phase, whole[i].phase);
    EXPECT_EQ(brief.cells.at(trial.cell), whole[i].cell);
    EXPECT_EQ(trial.view, i == 5 ? std::nullopt : std::optional<int>(i % kViewCount));
    EXPECT_EQ(trial.test_side, whole[i].test_side);
    EXPECT_EQ(trial.answer, whole[i].answer);
    EXPECT_EQ(trial.response_time_ns, whole[i].response_time_ns.value_or(0));
    EXPECT_EQ(trial.too_fast, whole[i].too_fast);
  }
}

TEST_F(TrialLogTest, MovesWithItsConnection) {
  TrialLog log(path_, true);
  TrialLog moved = std::move(log);
  EXPECT_EQ(moved.append_session(make_fake_session(), {}), 1);
  moved = TrialLog(folder_.path() / "other.sqlite", true);
  EXPECT_THAT(moved.load_sessions(), IsEmpty());
}

TEST(AnswerDigest, DoesNotDependOnTheOrderOrNumbersOfSessions) {
  const Cell cell = make_fake_trials(1)[0].cell;
  const AnswerRow first{1, 0, cell, true}, second{2, 1, cell, false};
  const AnswerRow second_elsewhere{9, 1, cell, false};
  EXPECT_EQ(digest_answers({first, second}), digest_answers({second_elsewhere, first}));
}

// What it was defined as: the lines of all answers, sorted by their bytes.
TEST(AnswerDigest, IsOfTheSortedLines) {
  std::vector<AnswerRow> answers;
  std::vector<std::string> lines;
  const std::vector<TrialRow> trials = make_fake_trials(kClampLevelCount);
  for (int subject : {0, 1, 2, 10, 11, 100}) {
    for (std::size_t i = 0; i < trials.size(); ++i) {
      Cell cell = trials[i].cell;
      if (subject % 2 == 1) cell.column.object.geometry = i % 2 == 0 ? "G10" : "G";
      answers.push_back({subject + 1, subject, cell, i % 3 == 0});
      lines.push_back(fmt::format("{} {} {}\n", format_key(cell), subject, i % 3 == 0 ? "correct" : "wrong"));
    }
  }
  std::sort(lines.begin(), lines.end());
  EXPECT_EQ(digest_answers(answers), digest_text(fmt::format("{}", fmt::join(lines, ""))));
}

TEST(AnswerDigest, SeesEveryChange) {
  const auto trials = make_fake_trials(2);
  const AnswerRow row{1, 0, trials[0].cell, true};
  const std::string digest = digest_answers({row});
  EXPECT_NE(digest_answers({}), digest);
  EXPECT_NE(digest_answers({row, row}), digest);
  EXPECT_NE(digest_answers({{1, 1, trials[0].cell, true}}), digest);
  EXPECT_NE(digest_answers({{1, 0, trials[1].cell, true}}), digest);
  EXPECT_NE(digest_answers({{1, 0, trials[0].cell, false}}), digest);
}

// Every column of every table has its row, "| `column` |", below the table's heading in docs/responses.md.
TEST_F(TrialLogTest, HasEveryColumnDocumented) {
  { TrialLog log(path_, true); }
  const std::string page = load_text(std::filesystem::path(EQUILUX_SOURCE_DIR) / "docs/responses.md");
  const RawDatabase database(path_);
  for (const std::string table : {"participant", "session", "trial", "event"}) {
    const std::size_t begin = page.find("## " + table + "\n");
    ASSERT_NE(begin, std::string::npos) << table;
    const std::string section = page.substr(begin, page.find("\n## ", begin + 1) - begin);
    for (const auto& row : database.query("SELECT name FROM pragma_table_info('" + table + "')")) {
      EXPECT_NE(section.find("| `" + row.at(0) + "` |"), std::string::npos) << table << "." << row.at(0);
    }
  }
}

// Three stations, side by side and then merged: every index once.
TEST_F(TrialLogTest, StationsGiveOutIndicesOfTheirOwn) {
  TrialLog log(path_, true);
  const auto next = [&](std::int64_t first) {
    const std::int64_t index = log.find_free_index(SubjectKind::kPerson, Experiment::kArtifact, {first, 3});
    log.append_session(make_fake_session(index), make_fake_trials(1));
    return index;
  };
  EXPECT_EQ(next(1), 1);
  EXPECT_EQ(next(1), 4);
  EXPECT_EQ(next(0), 0);
  EXPECT_EQ(next(2), 2);
  EXPECT_EQ(next(0), 3);
  EXPECT_EQ(next(2), 5);
  EXPECT_EQ(log.find_free_index(SubjectKind::kPerson, Experiment::kArtifact), 6);
}

}  // namespace
}  // namespace equilux
