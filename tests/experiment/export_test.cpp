// What other programs get to read: tidy, described, the same bytes each time, and never in the place of
// anything else.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <regex>

#include "analysis/csv.h"
#include "base/error.h"
#include "base/json.h"
#include "experiment/export_log.h"
#include "tests/experiment/child.h"
#include "tests/experiment/fake_study.h"
#include "tests/experiment/fake_trials.h"
#include "tests/experiment/raw_database.h"
#include "tests/experiment/unprivileged.h"
#include "tests/support/failures.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Key;
using ::testing::Not;

class Export : public ::testing::Test {
 protected:
  Export() {
    TrialLog log(folder_.responses(), true);
    SessionRow first = make_fake_session(1);
    first.fields = {{"age_band", "20-29"}, {"remark", "said \"fine\",\nthen left"}};
    auto trials = make_fake_trials(3);
    trials[0].phase = Phase::kPractice;
    trials[2].phase = Phase::kCatch;
    answer_all(log, log.append_session(first, trials), 3);
    SessionRow second = make_fake_session(0);
    second.participant = "p-0";
    second.screen = {"HDMI-1", 1920, 1080, 0.1, 16.25, 12.125};
    const auto aborted = log.append_session(second, make_fake_trials(2));
    log.append_answer(aborted, {1, Side::kLeft, 1'500'000'001, true}, 0, 7);
    log.append_event(aborted, "abort", 8, "tired, and hungry");
    answer_all(log, log.append_session(make_fake_session(0, SubjectKind::kPlanted), make_fake_trials(2)), 2);
  }
  ExportFiles make(ExportFormat format, SubjectKind kind = SubjectKind::kPerson) const {
    const auto records = load_records(TrialLog::load_snapshot(folder_.responses()), kind);
    const Study study = load_folder_study(folder_);
    return format == ExportFormat::kCsv ? make_csv_export(records, study, kind)
                                        : make_bids_export(records, study, kind);
  }
  Table table(const std::string& name) const { return parse_csv(make(ExportFormat::kCsv).at(name), name); }
  ChildResult run(const std::vector<std::string>& more) const {
    std::vector<std::string> words = {"export", folder_.root.string(), "--out", out_.string()};
    words.insert(words.end(), more.begin(), more.end());
    return run_session_program(words);
  }

  TemporaryFolder temporary_;
  StudyFolder folder_ = make_fake_study(temporary_.path() / "study");
  fs::path out_ = temporary_.path() / "out";
};

std::string cell(const Table& table, std::size_t row, const std::string& column) {
  const auto at = std::find(table.columns.begin(), table.columns.end(), column);
  EXPECT_NE(at, table.columns.end()) << column;
  return table.rows.at(row).at(static_cast<std::size_t>(at - table.columns.begin()));
}

ExportFiles load_files(const fs::path& folder) {
  ExportFiles files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file())
      files[entry.path().lexically_relative(folder).generic_string()] = read_bytes(entry.path());
  }
  return files;
}

TEST_F(Export, HasEverySessionOfItsKindInOrderOfIndexAndNoOther) {
  const Table sessions = table("sessions.csv");
  ASSERT_EQ(sessions.rows.size(), 2u);
  EXPECT_EQ(cell(sessions, 0, "participant"), "p-0");
  EXPECT_EQ(cell(sessions, 0, "state"), "aborted");
  EXPECT_EQ(cell(sessions, 0, "abort_reason"), "tired, and hungry");
  EXPECT_EQ(cell(sessions, 0, "viewing_distance_m"), "0.1");
  EXPECT_EQ(cell(sessions, 1, "participant"), "P1");
  EXPECT_EQ(cell(sessions, 1, "state"), "complete");
  EXPECT_EQ(cell(sessions, 1, "monitor"), "");
  EXPECT_EQ(parse_csv(make(ExportFormat::kCsv, SubjectKind::kPlanted).at("sessions.csv"), "").rows.size(),
            1u);
}

TEST_F(Export, QuotesWhatNeedsIt) {
  const Table fields = table("fields.csv");
  ASSERT_EQ(fields.rows.size(), 2u);
  EXPECT_EQ(cell(fields, 1, "name"), "remark");
  EXPECT_EQ(cell(fields, 1, "value"), "said \"fine\",\nthen left");
}

TEST_F(Export, MarksTrialsByPhaseAndWhetherTheyCount) {
  const Table trials = table("trials.csv");
  ASSERT_EQ(trials.rows.size(), 5u);
  EXPECT_EQ(cell(trials, 0, "answer"), "");
  EXPECT_EQ(cell(trials, 0, "correct"), "");
  EXPECT_EQ(cell(trials, 1, "response_time_ns"), "1500000001");
  EXPECT_EQ(cell(trials, 1, "too_fast"), "1");
  EXPECT_EQ(cell(trials, 1, "correct"), "0") << "the test picture stood right";
  EXPECT_EQ(cell(trials, 1, "counted"), "0") << "its session is not complete";
  EXPECT_EQ(cell(trials, 2, "phase"), "practice");
  EXPECT_EQ(cell(trials, 2, "counted"), "0");
  EXPECT_EQ(cell(trials, 3, "phase"), "main");
  EXPECT_EQ(cell(trials, 3, "counted"), "1");
  EXPECT_EQ(cell(trials, 3, "correct"), "1");
  EXPECT_EQ(cell(trials, 3, "clamp_level"), "1");
  EXPECT_EQ(cell(trials, 3, "vpl_count"), "100000");
  EXPECT_EQ(cell(trials, 3, "test_view"), "1");
  EXPECT_EQ(cell(trials, 4, "phase"), "catch");
}

TEST_F(Export, HasTheEventsOfEachSessionInOrder) {
  const Table events = table("events.csv");
  ASSERT_EQ(events.rows.size(), 3u + 6u);
  EXPECT_EQ(cell(events, 0, "kind"), "answer");
  EXPECT_EQ(cell(events, 1, "kind"), "showing");
  EXPECT_EQ(cell(events, 2, "kind"), "abort");
  EXPECT_EQ(cell(events, 2, "trial"), "");
  EXPECT_EQ(cell(events, 2, "number"), "2");
  EXPECT_EQ(cell(events, 3, "number"), "0");
}

// The counted trials are the very answers that tallies count.
TEST_F(Export, CountsWhatTheLogCounts) {
  const auto answers =
      TrialLog(folder_.responses()).load_answers(SubjectKind::kPerson, Experiment::kArtifact);
  const Table trials = table("trials.csv");
  std::vector<std::string> counted;
  for (std::size_t row = 0; row < trials.rows.size(); ++row) {
    if (cell(trials, row, "counted") == "1")
      counted.push_back(cell(trials, row, "cell") + " " + cell(trials, row, "correct"));
  }
  ASSERT_EQ(answers.size(), 1u);
  EXPECT_THAT(counted, ElementsAre(format_key(answers[0].cell) + " 1"));
}

std::vector<std::string> column_names(const TableNote& table) {
  std::vector<std::string> names;
  for (const ColumnNote& note : table.columns) names.push_back(note.name);
  return names;
}

TEST_F(Export, DescribesEveryColumnOfEveryTable) {
  const Table dictionary = table("dictionary.csv");
  for (const TableNote& note : describe_tables(ExportFormat::kCsv)) {
    EXPECT_EQ(table(note.name + ".csv").columns, column_names(note));
    std::vector<std::string> described;
    for (std::size_t row = 0; row < dictionary.rows.size(); ++row) {
      if (cell(dictionary, row, "table") == note.name) described.push_back(cell(dictionary, row, "column"));
    }
    EXPECT_EQ(described, column_names(note));
  }
  for (std::size_t row = 0; row < dictionary.rows.size(); ++row) {
    EXPECT_NE(cell(dictionary, row, "type"), "");
    EXPECT_NE(cell(dictionary, row, "meaning"), "");
  }
}

// What a log keeps of a session, a trial and an event is all in the export, by the same name or in another
// form.
TEST_F(Export, LeavesNoColumnOfTheLogOut) {
  const std::set<std::string> other_form = {"id", "uuid", "session"};
  const RawDatabase database(folder_.responses());
  for (const std::string name : {"session", "field", "trial", "event"}) {
    const Table exported = table(name + "s.csv");
    for (const auto& row : database.query("SELECT name FROM pragma_table_info('" + name + "')")) {
      if (other_form.contains(row.at(0))) continue;
      EXPECT_THAT(exported.columns, Contains(row.at(0))) << name;
    }
  }
}

TEST_F(Export, StandsInTheDocumentationAsItIs) {
  EXPECT_EQ(load_text(fs::path(EQUILUX_SOURCE_DIR) / "docs/data-dictionary.md"), format_data_dictionary())
      << "docs/data-dictionary.md is made of experiment/export_columns.cpp";
}

TEST_F(Export, IsTheSameBytesEachTime) {
  for (const ExportFormat format : {ExportFormat::kCsv, ExportFormat::kBids})
    EXPECT_EQ(make(format), make(format));
  ASSERT_EQ(run({}).exit_code, 0);
  const ExportFiles first = load_files(out_);
  EXPECT_EQ(first, make(ExportFormat::kCsv));
  ASSERT_EQ(run({"--force"}).exit_code, 0);
  EXPECT_EQ(load_files(out_), first);
}

// Each column of a table of tabs, by its header.
std::vector<std::vector<std::string>> parse_tsv(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);
    auto& row = rows.emplace_back();
    for (std::string field; std::getline(fields, field, '\t');) row.push_back(field);
  }
  return rows;
}

// source: BIDS 1.8.0, "Participant names and other labels", "Tabular files", "Behavioral experiments".
TEST_F(Export, KeepsTheRulesOfBids) {
  const ExportFiles files = make(ExportFormat::kBids);
  const Json description = parse_json(files.at("dataset_description.json"), "dataset_description.json");
  EXPECT_EQ(description.at("BIDSVersion").as_string(), "1.8.0");
  EXPECT_NE(description.at("Name").as_string(), "");
  EXPECT_EQ(description.at("DatasetType").as_string(), "raw");
  EXPECT_THAT(files, Contains(Key("README")));
  EXPECT_THAT(files, Contains(Key("participants.json")));
  const std::regex legal(
      "sub-([A-Za-z0-9]+)/beh/sub-\\1_task-(artifact|material)(_run-[0-9]+)?_beh\\.(tsv|json)");
  const std::set<std::string> at_root = {
      "dataset_description.json", "README",     ".bidsignore", "participants.tsv",
      "participants.json",        "export.json"};
  for (const auto& [name, bytes] : files) {
    EXPECT_TRUE(at_root.contains(name) || std::regex_match(name, legal)) << name;
    if (!name.ends_with(".tsv")) continue;
    const Json sidecar = parse_json(files.at(fs::path(name).replace_extension("json").string()), name);
    const auto rows = parse_tsv(bytes);
    for (const std::string& column : rows.at(0)) EXPECT_TRUE(sidecar.find(column)) << name << " " << column;
    for (const auto& row : rows) {
      EXPECT_EQ(row.size(), rows[0].size()) << name;
      EXPECT_THAT(row, Not(Contains(""))) << name << ": what is missing is n/a";
    }
  }
  const auto participants = parse_tsv(files.at("participants.tsv"));
  ASSERT_EQ(participants.size(), 3u);
  EXPECT_EQ(participants[0][0], "participant_id");
  EXPECT_THAT(participants[1], ElementsAre("sub-P1", "P1", "complete", "n/a"));
  EXPECT_THAT(participants[2][0], HasSubstr("sub-p0"));
  EXPECT_EQ(parse_json(files.at("sub-P1/beh/sub-P1_task-artifact_beh.json"), "").at("TaskName").as_string(),
            "artifact");
}

TEST_F(Export, GivesResponseTimesToBidsInSeconds) {
  const ExportFiles files = make(ExportFormat::kBids);
  const std::string label = make_bids_label("p-0");
  const auto rows = parse_tsv(files.at(fmt::format("sub-{0}/beh/sub-{0}_task-artifact_beh.tsv", label)));
  EXPECT_EQ(rows[0].back(), "response_time");
  EXPECT_EQ(rows[1].back(), "n/a");
  EXPECT_EQ(rows[2].back(), "1.500000001");
}

TEST_F(Export, TellsBidsTheQuestionThatStoodOnTheScreen) {
  SessionRow row = make_fake_session(7);
  row.participant = "P7";
  row.fields = {{"prompt", "Select the image that lacks artifacts."}};
  TrialLog(folder_.responses(), false).append_session(row, make_fake_trials(2));
  const ExportFiles files = make(ExportFormat::kBids);
  const auto question = [&](const std::string& code) {
    const std::string file = fmt::format("sub-{0}/beh/sub-{0}_task-artifact_beh.json", code);
    return parse_json(files.at(file), file).at("Instructions").as_string();
  };
  EXPECT_EQ(question("P7"), "Select the image that lacks artifacts.");
  EXPECT_EQ(question("P1"), prompt_of(Experiment::kArtifact)) << "where none was recorded";
}

TEST_F(Export, MakesLabelsThatAreLegalAndApart) {
  EXPECT_EQ(make_bids_label("P01"), "P01");
  std::set<std::string> labels;
  for (const char* code : {"planted-1-10", "planted-11-0", "planted110", "ä", "-", "planted_1-10"}) {
    const std::string label = make_bids_label(code);
    EXPECT_TRUE(std::regex_match(label, std::regex("[A-Za-z0-9]+"))) << label;
    EXPECT_TRUE(labels.insert(label).second) << label;
  }
}

TEST_F(Export, RefusesBidsLabelsThatDifferInCaseAlone) {
  SessionRow row = make_fake_session(7);
  row.participant = "p1";
  TrialLog(folder_.responses()).append_session(row, make_fake_trials(1));
  EXPECT_THAT(message_of<InputError>([&] { make(ExportFormat::kBids); }), HasSubstr("P1 and p1"));
}

TEST_F(Export, NumbersTheRunsOfAParticipantWhoHasSeveralSessions) {
  SessionRow row = make_fake_session(7);
  row.participant = "P1";
  TrialLog(folder_.responses()).append_session(row, make_fake_trials(1));
  const ExportFiles files = make(ExportFormat::kBids);
  EXPECT_THAT(files, Contains(Key("sub-P1/beh/sub-P1_task-artifact_run-1_beh.tsv")));
  EXPECT_THAT(files, Contains(Key("sub-P1/beh/sub-P1_task-artifact_run-2_beh.tsv")));
}

TEST_F(Export, TakesTheNameOfNothingElse) {
  temporary_.write("out/mine.txt", "mine");
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--force"}}) {
    const ChildResult result = run(more);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.err, HasSubstr(out_.string()));
    EXPECT_EQ(load_files(out_), (ExportFiles{{"mine.txt", "mine"}}));
  }
  EXPECT_EQ(RawDatabase(folder_.responses()).value("SELECT count(*) FROM export"), "0")
      << "nothing was exported";
}

TEST_F(Export, OfNoNameIsRefusedBeforeItIsRecorded) {
  EXPECT_THAT(message_of<InputError>([] { check_can_export("", true); }),
              HasSubstr("--out: expected a folder to make, got an empty name"));
}

TEST_F(Export, ReplacesAnEarlierExportOnlyWithForceAndWithNothingOfSomebodyElseIn) {
  ASSERT_EQ(run({}).exit_code, 0);
  const ExportFiles first = load_files(out_);
  const ChildResult again = run({"--format", "bids"});
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_THAT(again.err, HasSubstr("--force"));
  EXPECT_EQ(load_files(out_), first);
  temporary_.write("out/notes/mine.txt", "mine");
  EXPECT_THAT(run({"--format", "bids", "--force"}).err, HasSubstr("mine.txt"));
  EXPECT_THAT(load_files(out_), Contains(Key("notes/mine.txt")));
  fs::remove(out_ / "notes/mine.txt");
  ASSERT_EQ(run({"--format", "bids", "--force"}).exit_code, 0);
  EXPECT_EQ(load_files(out_), make(ExportFormat::kBids));
  EXPECT_THAT(load_files(temporary_.path()), Not(Contains(Key(HasSubstr(".part")))));
}

TEST_F(Export, IsWholeOrNotThereWhenTheDiskIsFull) {
  const auto files = make(ExportFormat::kCsv);
  {
    const FileSizeLimit limit(1500);
    EXPECT_THAT(message_of<StoreError>([&] { save_export(out_, files, false); }), HasSubstr("cannot write"));
  }
  EXPECT_FALSE(fs::exists(out_));
  save_export(out_, files, false);
  {
    const FileSizeLimit limit(1500);
    EXPECT_THROW(save_export(out_, make(ExportFormat::kBids), true), StoreError);
  }
  EXPECT_EQ(load_files(out_), files);
}

TEST_F(Export, OfAnInterruptedOneDoesNotHinderTheNext) {
  const auto files = make(ExportFormat::kCsv);
  save_export(out_, files, false);
  fs::rename(out_, out_.string() + ".part");
  fs::remove(out_.string() + ".part/trials.csv");
  temporary_.write("out.part/trials.csv.123@host.part", "half");
  save_export(out_, files, false);
  EXPECT_EQ(load_files(out_), files);
  EXPECT_FALSE(fs::exists(out_.string() + ".part"));
}

// Killed before it had its first file, or in mid-file.
TEST_F(Export, OfOneThatWasKilledAtItsStartDoesNotHinderTheNext) {
  for (const char* left : {"", "export.json.123@host.part"}) {
    fs::create_directories(out_.string() + ".part");
    if (*left) temporary_.write(std::string("out.part/") + left, "{");
    const ChildResult result = run({"--force"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_FALSE(fs::exists(out_.string() + ".part"));
  }
}

TEST_F(Export, LeavesAloneWhatSomebodyElseHasWhereItIsWrittenFirst) {
  const auto expect_refused = [&](const std::string& stranger) {
    const ChildResult result = run({});
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.err, AllOf(HasSubstr(out_.string() + ".part: expected a free name"),
                                  HasSubstr("got " + stranger + ", which no export has written"),
                                  HasSubstr("move or delete it, or export to another name")));
    EXPECT_FALSE(fs::exists(out_));
    EXPECT_TRUE(fs::exists(out_.string() + ".part"));
  };
  temporary_.write("out.part", "a file");
  expect_refused("out.part");
  fs::remove(out_.string() + ".part");
  temporary_.write("out.part/mine.txt", "mine");
  expect_refused("mine.txt");
  for (const auto& [name, bytes] : make(ExportFormat::kCsv)) temporary_.write("out.part/" + name, bytes);
  expect_refused("mine.txt");
  fs::remove(out_.string() + ".part/mine.txt");
  temporary_.write("out.part/export.json", R"({"schema": "another"})");
  expect_refused("export.json");
  EXPECT_EQ(RawDatabase(folder_.responses()).value("SELECT count(*) FROM export"), "0");
}

TEST_F(Export, IsForItsOwnersEyesAlone) {
  ASSERT_EQ(run({}).exit_code, 0);
  EXPECT_EQ(fs::status(out_).permissions(), fs::perms::owner_all);
}

TEST_F(Export, IsRecordedInTheLog) {
  ASSERT_EQ(run({}).exit_code, 0);
  ASSERT_EQ(run({"--force"}).exit_code, 0);
  const auto exports = TrialLog(folder_.responses()).load_exports();
  ASSERT_EQ(exports.size(), 1u);
  EXPECT_EQ(exports[0].path, out_.string());
}

TEST_F(Export, OfALogThatCannotBeWrittenIsMadeAndSaysThatItIsNotRecorded) {
  const RawDatabase other(folder_.responses());
  other.query("BEGIN IMMEDIATE");
  const ChildResult result = run({});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("not recorded in the log"));
  EXPECT_THAT(result.err, HasSubstr("locked"));
  EXPECT_TRUE(fs::exists(out_ / "trials.csv"));
}

TEST_F(Export, OfNobodySaysWhoThereIs) {
  const ChildResult result = run({"--kind", "looking"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("sessions of kind looking, got 2 of kind person, 1 of kind planted"));
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(Export, OfAFolderWithoutALogSaysSo) {
  fs::remove(folder_.responses());
  const ChildResult result = run({});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("nothing of that name"));
}

}  // namespace
}  // namespace equilux
