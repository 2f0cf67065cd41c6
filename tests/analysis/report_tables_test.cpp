// The files of a report: every column explained, the same numbers in all, the same bytes in any order of
// files.
#include "analysis/report_tables.h"

#include <array>
#include <boost/math/special_functions/beta.hpp>
#include <chrono>
#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <set>
#include <thread>

#include "analysis/answers_export.h"
#include "analysis/figure.h"
#include "analysis/interim.h"
#include "analysis/program.h"
#include "analysis/trend_bounds.h"
#include "analysis/views.h"
#include "base/error.h"
#include "base/files.h"
#include "base/program.h"
#include "experiment/simulate.h"
#include "experiment/withdraw.h"
#include "protocols/session_protocol.h"
#include "tests/analysis/columns.h"
#include "tests/experiment/fake_trials.h"
#include "tests/experiment/raw_database.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux::tests {
namespace {
namespace fs = std::filesystem;

// A study folder with a log of planted answers, as equilux-session leaves it, but without pictures.
void make_answered_folder(const fs::path& root, const std::string& protocol, std::uint64_t seed, int artifact,
                          int material) {
  const PlantedStudy planted = make_planted_study(protocol, artifact, material, seed, 0.05);
  const StudyFolder folder{root};
  make_folder(root);
  save_text(folder.study(), format_json(planted.study.source));
  fs::copy_file(planted.study.windows_path, folder.windows());
  fs::copy_file(planted.study.truth_path, folder.truth());
  Selection selection = planted.selection;
  selection.answers_digest = digest_answers(planted.artifact);
  save_selection(selection, folder.selection(SubjectKind::kPlanted));
  TrialLog log(folder.responses(), true);
  for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial}) {
    std::map<std::int64_t, std::vector<TrialRow>> sessions;
    for (const AnswerRow& answer :
         experiment == Experiment::kArtifact ? planted.artifact : planted.material) {
      auto& trials = sessions[answer.subject_index];
      TrialRow trial;
      trial.number = static_cast<int>(trials.size());
      trial.cell = answer.cell;
      trial.test_key = trial.pair_key = format_key(Condition{answer.cell, 0});
      trial.test_side = trials.size() % 2 == 0 ? Side::kLeft : Side::kRight;
      const bool left = (trial.test_side == Side::kLeft) == answer.correct;
      trial.answer = left ? Side::kLeft : Side::kRight;
      trial.response_time_ns = 1'000'000'000 + static_cast<std::int64_t>(trials.size());
      trial.answered_utc = "2026-01-31T12:00:00.000Z";
      trials.push_back(trial);
    }
    for (const auto& [index, trials] : sessions) {
      SessionRow row = make_fake_session(index, SubjectKind::kPlanted, experiment);
      row.digests.study = planted.study.digest;
      if (experiment == Experiment::kMaterial) {
        row.digests.windows = "";
        row.digests.selection = digest_selection(selection);
      }
      log.finish_session(log.append_session(row, trials), 1);
    }
  }
}

AnalyzeParams make_params(const std::vector<fs::path>& folders, const fs::path& out) {
  AnalyzeParams params;
  params.study_folders = folders;
  params.out = out;
  params.plot = false;
  params.uncertainty = {1, 100, 100};
  return params;
}

std::map<std::string, std::string> read_files(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(folder))
    files[entry.path().filename().string()] = load_text(entry.path());
  return files;
}

class Folders : public ::testing::Test {
 protected:
  Folders() {
    make_answered_folder(temporary_ / "a", "pocket", 1, 12, 14);
    make_answered_folder(temporary_ / "b", "pocket", 2, 7, 5);
    make_answered_folder(temporary_ / "n", "normalisation", 3, 12, 14);
  }
  std::vector<Report> load(const std::vector<std::string>& names) const {
    std::vector<fs::path> folders;
    for (const std::string& name : names) folders.push_back(temporary_ / name);
    return load_reports(make_params(folders, {}));
  }
  const TempFolder temporary_{find_memory_folder()};
};

TEST_F(Folders, of_one_study_are_pooled_and_others_stand_beside) {
  const auto reports = load({"a", "b", "n"});
  ASSERT_EQ(reports.size(), 2U);
  EXPECT_EQ(reports[0].study.name, "normalisation");
  EXPECT_EQ(reports[1].study.name, "pocket");
  EXPECT_EQ(reports[1].evidence.artifact.finished.size(), 19U);
  EXPECT_EQ(reports[1].evidence.material.finished.size(), 19U);
  EXPECT_EQ(reports[1].artifact_subjects.sessions.size(), 19U);
  EXPECT_EQ(reports[1].artifact_subjects.order.subjects, 12U) << "P0 to P6 sat in both logs";
  EXPECT_EQ(reports[1].uncertainty.subjects, 12U);
  const auto a = load({"a"}), b = load({"b"});
  for (const auto& [cell, count] : reports[1].artifact) {
    EXPECT_EQ(count.n, a[0].artifact.at(cell).n + b[0].artifact.at(cell).n);
    EXPECT_EQ(count.k, a[0].artifact.at(cell).k + b[0].artifact.at(cell).k);
  }
}

TEST_F(Folders, say_while_sessions_go_on_what_the_report_says) {
  const StudyFolder folder{temporary_ / "a"};
  const Study study = load_folder_study(folder);
  TrialLog(folder.responses())
      .append_session(make_fake_session(99, SubjectKind::kPlanted), make_fake_trials(3));
  const InterimFindings interim = load_interim(folder, study, SubjectKind::kPlanted);
  EXPECT_EQ(interim.artifact.finished, 12);
  EXPECT_EQ(interim.artifact.unfinished, 1);
  EXPECT_EQ(interim.material.finished, 14);
  const Report report = load({"a"})[0];
  ASSERT_EQ(interim.columns.size(), report.findings.size());
  for (std::size_t c = 0; c < interim.columns.size(); ++c) {
    const ColumnFinding &now = interim.columns[c], &then = report.findings[c];
    EXPECT_EQ(now.artifact, then.artifact);
    EXPECT_EQ(now.material, then.material);
    for (const Rule rule : kRules) {
      EXPECT_EQ(now.under(rule).regions, then.under(rule).regions);
      EXPECT_EQ(now.under(rule).verdict, then.under(rule).verdict);
    }
  }
}

TEST_F(Folders, say_nothing_before_the_first_answer_and_refuse_answers_of_another_study) {
  const StudyFolder folder{temporary_ / "b"};
  const Study study = load_folder_study(folder);
  for (const ColumnFinding& column : load_interim(folder, study, SubjectKind::kPerson).columns)
    EXPECT_EQ(column.under(Rule::kPaper).verdict, Verdict::kUntested);
  fs::copy_file((temporary_ / "n") / "responses.sqlite", folder.responses(),
                fs::copy_options::overwrite_existing);
  EXPECT_THROW(load_interim(folder, study, SubjectKind::kPlanted), InputError);
  fs::remove(folder.responses());
  EXPECT_EQ(load_interim(folder, study, SubjectKind::kPlanted).artifact.finished, 0);
}

// A person's artifact session: four cells, all right, and four catch trials of which two are right.
SessionRow make_person(std::int64_t index, const Study& study, const std::string& protocol) {
  SessionRow row = make_fake_session(index, SubjectKind::kPerson, Experiment::kArtifact);
  row.digests.study = study.digest;
  row.digests.protocol = protocol;
  return row;
}

std::vector<TrialRow> make_person_trials(const Study& study, int answered) {
  const auto cells = enumerate_cells(study);
  std::vector<TrialRow> trials = make_fake_trials(8);
  for (TrialRow& trial : trials) {
    trial.cell = cells.at(static_cast<std::size_t>(trial.number));
    trial.phase = trial.number < 4 ? Phase::kMain : Phase::kCatch;
    if (trial.number >= answered) continue;
    const bool is_left = (trial.test_side == Side::kLeft) == (trial.number < 6);
    trial.answer = is_left ? Side::kLeft : Side::kRight;
    trial.response_time_ns = 1'000'000'000;
    trial.answered_utc = "2026-01-31T12:00:00.000Z";
  }
  return trials;
}

// Folder b, whose session.json asks for two right of four catch trials.
TEST_F(Folders, hold_sessions_to_their_own_protocol_and_tell_who_is_left_out_and_why) {
  const StudyFolder folder{temporary_ / "b"};
  save_text(folder.session(), R"({"schema": "equilux-session", "schema_version": 1,
                                  "catch_trials": {"count": 4, "pass": 2}})");
  const std::string own = load_session_protocol(folder.session()).digest;
  const Study study = load_folder_study(folder);
  {
    TrialLog log(folder.responses());
    log.finish_session(log.append_session(make_person(0, study, own), make_person_trials(study, 8)), 1);
    log.finish_session(log.append_session(make_person(1, study, "other"), make_person_trials(study, 8)), 1);
    const auto ended = log.append_session(make_person(2, study, own), make_person_trials(study, 3));
    log.append_event(ended, "abort", 1, "felt ill");
    const auto interrupted = log.append_session(make_person(3, study, own), make_person_trials(study, 3));
    log.append_event(interrupted, "interrupt", 1, "the window was closed");
    log.finish_session(log.append_session(make_person(4, study, own), make_person_trials(study, 8)), 1);
  }
  withdraw_participant(folder.responses(), "P4");
  AnalyzeParams params = make_params({folder.root}, {});
  params.kind = SubjectKind::kPerson;
  const Report report = load_reports(params)[0];
  const auto& sessions = report.artifact_subjects.sessions;
  ASSERT_EQ(sessions.size(), 4U);
  EXPECT_EQ(sessions[0].summary.caught, (Count{2, 4}));
  EXPECT_EQ(sessions[0].summary.catch_pass, 2);
  EXPECT_TRUE(sessions[0].marks.empty());
  EXPECT_FALSE(sessions[1].summary.catch_pass) << "its protocol is not the folder's";
  EXPECT_EQ(sessions[1].marks, std::vector<SubjectMark>{SubjectMark::kCatch});
  EXPECT_EQ(sessions[2].summary.abort_reason, "felt ill");
  EXPECT_FALSE(sessions[3].summary.abort_reason) << "it was not ended, it waits";
  EXPECT_EQ(report.evidence.artifact.answers.size(), 8U);
  EXPECT_EQ(report.evidence.artifact.unfinished, 2);
  EXPECT_EQ(report.evidence.withdrawn, 1);
  std::string warnings;
  for (const std::string& warning : report.warnings) warnings += warning + "\n";
  for (const char* part :
       {"Withdrawals that the logs record: 1", "followed 2 session protocols",
        "Of 2 artifact sessions 1 used a session.json other than the one in the folder now"})
    EXPECT_NE(warnings.find(part), std::string::npos) << part << " in\n" << warnings;
  const std::string page = format_page({report});
  EXPECT_NE(warnings.find("2 artifact sessions were not finished (1 ended early by the experimenter, 1 left "
                          "unfinished): their 6 answers are left out."),
            std::string::npos)
      << warnings;
  EXPECT_EQ(make_report_json({report}).at("studies").at(0).at("artifact").at("ended_early_sessions"),
            Json(1));
  EXPECT_NE(page.find("<tr><td>artifact</td><td class=\"number\">2</td><td class=\"number\">2</td>"
                      "<td class=\"number\">1</td><td class=\"number\">1</td>"),
            std::string::npos);
  EXPECT_NE(page.find("ended early (felt ill), left out"), std::string::npos);
  EXPECT_NE(page.find("2 of 4 (at least 2)"), std::string::npos);
}

// Planted artifact answers, and material sessions of persons: these are not what the report is of.
TEST_F(Folders, name_finished_sessions_of_other_kinds) {
  EXPECT_THAT(load({"a"})[0].warnings, testing::Not(testing::Contains(testing::HasSubstr("other kinds"))));
  for (const char* name : {"a", "b"}) {
    const StudyFolder folder{temporary_ / name};
    SessionRow row = make_person(0, load_folder_study(folder), "");
    row.experiment = Experiment::kMaterial;
    row.digests.windows = "";
    TrialLog log(folder.responses());
    log.finish_session(log.append_session(row, make_person_trials(load_folder_study(folder), 8)), 1);
  }
  const std::string told = "Finished sessions of other kinds are not counted here: {} of the kind person.";
  EXPECT_THAT(load({"a"})[0].warnings,
              testing::Contains(fmt::format(fmt::runtime(told), "1 material sessions")));
  EXPECT_THAT(load({"a", "b"})[0].warnings,
              testing::Contains(fmt::format(fmt::runtime(told), "2 material sessions")));
}

TEST_F(Folders, give_the_same_bytes_in_any_order) {
  const fs::path first = temporary_ / "first", second = temporary_ / "second";
  for (const auto& [out, names] :
       std::map<fs::path, std::vector<std::string>>{{first, {"a", "b", "n"}}, {second, {"n", "b", "a"}}}) {
    save_report(make_report_files(load(names)), out);
  }
  EXPECT_EQ(read_files(first), read_files(second));
}

TEST_F(Folders, given_twice_or_with_answers_of_two_kinds_are_refused) {
  EXPECT_THROW(load({"a", "a"}), InputError);
  EXPECT_THROW(load_reports(make_params({temporary_ / "a", temporary_ / "./a/"}, {})), InputError);
  fs::create_directory_symlink("a", temporary_ / "link");
  EXPECT_THROW(load({"a", "link"}), InputError);
}

TEST_F(Folders, that_hold_the_same_session_are_refused) {
  fs::copy(temporary_ / "a", temporary_ / "copy", fs::copy_options::recursive);
  EXPECT_THAT(message_of<InputError>([&] {
                load({"a", "b", "copy"});
              }),
              testing::MatchesRegex(".*copy: session [0-9]+ of .*: expected each session in one log: .*, "
                                    "got one that .*a has too"));
}

TEST_F(Folders, with_a_person_who_finished_in_two_logs_warn) {
  const Study study = load_folder_study(StudyFolder{temporary_ / "a"});
  for (const auto& [name, index] : {std::pair("a", 0), std::pair("b", 0), std::pair("b", 1)}) {
    TrialLog log((temporary_ / name) / "responses.sqlite");
    log.finish_session(log.append_session(make_person(index, study, ""), make_person_trials(study, 8)), 1);
  }
  AnalyzeParams params = make_params({temporary_ / "a", temporary_ / "b"}, {});
  params.kind = SubjectKind::kPerson;
  std::vector<std::string> repeaters;
  const auto reports = load_reports(params);
  for (const std::string& warning : reports[0].warnings) {
    if (warning.starts_with("Participants ")) repeaters.push_back(warning);
  }
  ASSERT_EQ(repeaters.size(), 1u);
  EXPECT_TRUE(
      repeaters[0].starts_with("Participants finished the artifact experiment more than once, in "
                               "different logs: P0 (2 times). The 3 sessions are of 2 codes."))
      << repeaters[0];
  for (const char* named : {"ranges of cuts", "order effect", "Clopper-Pearson, Jeffreys", "supported"})
    EXPECT_NE(repeaters[0].find(named), std::string::npos) << named;
  EXPECT_NE(format_page(reports).find("<td>artifact</td><td class=\"number\">3</td><td class=\"number\">2<"),
            std::string::npos);
}

TEST_F(Folders, with_planted_subjects_of_equal_codes_warn_too) {
  std::string warnings;
  const auto reports = load({"a", "b"});
  for (const std::string& warning : reports[0].warnings) warnings += warning + "\n";
  EXPECT_NE(
      warnings.find("Simulated subjects of one code finished the material experiment more than once, in "
                    "different logs: P0 (2 times), P1 (2 times), P2 (2 times), P3 (2 times), P4 (2 "
                    "times). The 19 sessions are of 14 codes."),
      std::string::npos)
      << warnings;
  EXPECT_NE(warnings.find("P4 (2 times) and 2 more. The 19 sessions are of 12 codes."), std::string::npos)
      << warnings;
}

// Folder c, whose only subject gave up: alone it is refused, in a pool it says that it has nothing to count.
TEST_F(Folders, of_a_pool_of_which_one_has_no_finished_session_count_the_others) {
  make_answered_folder(temporary_ / "c", "pocket", 3, 0, 0);
  const StudyFolder folder{temporary_ / "c"};
  SessionRow row = make_fake_session(0, SubjectKind::kPlanted, Experiment::kArtifact);
  row.digests.study = load_folder_study(folder).digest;
  {
    TrialLog log(folder.responses());
    log.append_event(log.append_session(row, make_fake_trials(5)), "abort", 1, "felt ill");
  }
  fs::remove(folder.selection(SubjectKind::kPlanted));
  EXPECT_THAT(message_of<InputError>([&] { load({"c"}); }),
              testing::HasSubstr("expected finished artifact sessions, got none (1 unfinished)"));
  EXPECT_THROW(load({"c", "n"}), InputError) << "the only one of its study";
  const Report report = load({"a", "c"})[0], alone = load({"a"})[0];
  EXPECT_EQ(report.artifact, alone.artifact);
  EXPECT_EQ(report.material, alone.material);
  EXPECT_EQ(report.folders.size(), 2U);
  EXPECT_TRUE(report.selection) << "of a, since c has no say";
  EXPECT_EQ(report.evidence.artifact.unfinished, 1);
  EXPECT_EQ(report.artifact_subjects.sessions.size(), 13U);
  EXPECT_THAT(report.warnings, testing::Contains(testing::HasSubstr(
                                   "c: No artifact session of the kind planted is finished here: 1 "
                                   "unfinished ones, none to count.")));
}

// A log whose sessions recorded other pictures than those of folder a.
TEST_F(Folders, with_other_pictures_are_pooled_with_a_warning_that_names_them) {
  EXPECT_THAT(load({"a", "b"})[0].warnings,
              testing::Not(testing::Contains(testing::HasSubstr("different pictures"))));
  const StudyFolder folder{temporary_ / "b"};
  const Study study = load_folder_study(folder);
  SessionRow row = make_fake_session(50, SubjectKind::kPlanted, Experiment::kArtifact);
  row.digests.study = study.digest;
  row.digests.manifest = "another set";
  {
    TrialLog log(folder.responses());
    log.finish_session(log.append_session(row, make_person_trials(study, 8)), 1);
  }
  const Report report = load({"a", "b"})[0];
  EXPECT_THAT(report.warnings, testing::Contains(testing::HasSubstr("different pictures are added up")));
  EXPECT_THAT(report.warnings, testing::Contains(testing::HasSubstr("/b (another set...)")));
  EXPECT_EQ(report.selections.size(), 2U) << "each was pruned by itself";
  const Json json = make_report_json({report});
  EXPECT_EQ(json.at("studies").as_array()[0].at("selections").as_array().size(), 2U);
}

TEST_F(Folders, make_tables_whose_every_column_is_explained) {
  const auto reports = load({"a", "n"});
  auto tables = make_report_tables(reports);
  tables.push_back({"answers.csv", make_answers_table(reports)});
  std::size_t columns = 0;
  const Json metadata = make_csv_metadata(tables);
  for (const Json& table : metadata.at("tables").as_array()) {
    for (const Json& column : table.at("tableSchema").at("columns").as_array()) {
      EXPECT_GT(column.at("dc:description").as_string().size(), 5U);
      ++columns;
    }
  }
  std::size_t expected = 0;
  for (const ReportTable& table : tables) expected += table.table.columns.size();
  EXPECT_EQ(columns, expected);
  EXPECT_THROW(find_entry("cells.csv", "mood"), CheckFailure);
}

std::size_t place_of(const Table& table, const std::string& column) {
  return static_cast<std::size_t>(std::find(table.columns.begin(), table.columns.end(), column) -
                                  table.columns.begin());
}

std::int64_t sum_column(const Table& table, const std::string& column) {
  std::int64_t sum = 0;
  for (const auto& row : table.rows) sum += std::stoll(row[place_of(table, column)]);
  return sum;
}

const Table& find_table(const std::vector<ReportTable>& tables, const std::string& file) {
  return std::find_if(tables.begin(), tables.end(), [&](const auto& table) { return table.file == file; })
      ->table;
}

// As no program leaves it: an answer is taken from a finished session.
void erase_answer(const StudyFolder& folder, int session, int trial) {
  RawDatabase(folder.responses())
      .query(fmt::format("UPDATE trial SET answer = NULL, response_time_ns = NULL, answered_utc = NULL"
                         " WHERE session = {} AND trial = {}",
                         session, trial));
}

TEST_F(Folders, have_the_same_sums_in_every_file) {
  const StudyFolder damaged{temporary_ / "b"};
  erase_answer(damaged, 1, 3);
  const auto reports = load({"a", "b", "n"});
  const auto tables = make_report_tables(reports);
  const Table answers = make_answers_table(reports);
  EXPECT_EQ(sum_column(find_table(tables, "cells.csv"), "n"), std::ssize(answers.rows));
  EXPECT_EQ(sum_column(find_table(tables, "cells.csv"), "k"), sum_column(answers, "correct"));
  EXPECT_EQ(sum_column(find_table(tables, "subjects.csv"), "answered"), std::ssize(answers.rows));
  EXPECT_EQ(sum_column(find_table(tables, "subjects.csv"), "correct"), sum_column(answers, "correct"));
  const Json json = make_report_json(reports);
  EXPECT_EQ(json.at("cells").as_array().size(), find_table(tables, "cells.csv").rows.size());
  EXPECT_EQ(json.at("ee").as_array().size(), 8U + 12U);
  for (const Json& row : json.at("ee").as_array()) {
    const std::string& status = row.at("status_paper").as_string();
    EXPECT_EQ(row.at("ee_paper"), status == "untested" ? Json(nullptr) : Json(status == "exists"));
  }
  EXPECT_EQ(parse_json(format_json(json), "report.json"), json);
}

// Before the material experiment nothing is known of EE but where every level has artifacts.
TEST_F(Folders, leave_ee_empty_where_it_is_untested) {
  make_answered_folder(temporary_ / "half", "pocket", 4, 12, 0);
  const auto reports = load({"half"});
  const auto tables = make_report_tables(reports);
  const Table& ee = find_table(tables, "ee.csv");
  std::size_t untested = 0;
  for (const auto& row : ee.rows) {
    const std::string status = row[place_of(ee, "status_paper")];
    untested += status == "untested" ? 1 : 0;
    EXPECT_EQ(row[place_of(ee, "ee_paper")], status == "untested" ? "" : "false");
  }
  EXPECT_GT(untested, 0U);
  const Json json = make_report_json(reports);
  for (const Json& row : json.at("ee").as_array())
    EXPECT_EQ(row.at("ee_isotonic").is_null(), row.at("status_isotonic").as_string() == "untested");
}

TEST_F(Folders, leave_out_a_trial_without_an_answer_and_say_so) {
  const StudyFolder folder{temporary_ / "b"};
  const Report whole = load({"b"})[0];
  erase_answer(folder, 1, 3);
  const Report report = load({"b"})[0];
  EXPECT_THAT(report.warnings,
              testing::Contains("1 trials of finished artifact sessions have no answer: they "
                                "are left out."));
  EXPECT_EQ(count_answers(report.artifact), count_answers(whole.artifact) - 1);
  EXPECT_EQ(report.material, whole.material);
  const InterimFindings interim = load_interim(folder, report.study, SubjectKind::kPlanted);
  for (std::size_t c = 0; c < interim.columns.size(); ++c)
    EXPECT_EQ(interim.columns[c].artifact, report.findings[c].artifact);
  EXPECT_NE(format_page({report}).find("AND answer IS NOT NULL GROUP BY cell"), std::string::npos);
  EXPECT_THAT(load({"a", "b"})[0].warnings, testing::Contains(testing::HasSubstr("have no answer")));
}

// A person without whom a verdict is another, or some level free of artifacts, is named once for each such
// column.
TEST_F(Folders, name_in_subjects_whom_the_flips_of_ee_count) {
  const auto tables = make_report_tables(load({"b", "n"}));
  const Table &subjects = find_table(tables, "subjects.csv"), &ee = find_table(tables, "ee.csv");
  std::int64_t all = 0;
  for (const std::string rule : {"paper", "isotonic"}) {
    std::int64_t named = 0, counted = 0, of_free = 0;
    for (const auto& row : subjects.rows) {
      const std::string& keys = row[place_of(subjects, "turns_" + rule)];
      named += keys.empty() ? 0 : 1 + std::count(keys.begin(), keys.end(), ' ');
    }
    for (const auto& row : ee.rows) {
      const std::string& flips = row[place_of(ee, "flips_" + rule)];
      counted += flips.empty() ? 0 : std::stoll(flips);
      const std::string& free = row[place_of(ee, "free_flips_" + rule)];
      of_free += free.empty() ? 0 : std::stoll(free);
    }
    EXPECT_EQ(named, counted + of_free) << rule;
    all += named;
  }
  EXPECT_GT(all, 0);
}

TEST_F(Folders, say_in_every_row_whose_answers_it_has) {
  const auto kinds_of = [](const Table& table) {
    std::set<std::string> kinds;
    for (const auto& row : table.rows) kinds.insert(row.at(place_of(table, "kind")));
    return kinds;
  };
  auto reports = load({"a", "n"});
  for (const char* kind : {"planted", "person"}) {
    for (const ReportTable& table : make_report_tables(reports))
      EXPECT_THAT(kinds_of(table.table), testing::ElementsAre(kind)) << table.file;
    EXPECT_THAT(kinds_of(make_answers_table(reports)), testing::ElementsAre(kind));
    for (Report& report : reports) report.evidence.kind = SubjectKind::kPerson;
  }
}

TEST_F(Folders, trace_what_the_page_alone_would_say) {
  Report report = load({"a"})[0];
  report.flipped_without_marked = {report.findings[2].column, report.findings[5].column};
  const Json study = make_report_json({report}).at("studies").at(0);
  EXPECT_EQ(study.at("flipped_without_marked"),
            make_json({format_key(report.findings[2].column), format_key(report.findings[5].column)}));
  // Half of Beta(1/2, 1/2) and more lies below one half: by numbers, cell by cell.
  for (const auto& [name, tally] :
       {std::pair("artifact", &report.artifact), {"material", &report.material}}) {
    double most = 0;
    for (const auto& [cell, count] : *tally) {
      if (count.n == 0) continue;
      const double a = static_cast<double>(count.k) + .5, b = static_cast<double>(count.n - count.k) + .5;
      const double over = boost::math::ibetac(a, b, .75);
      most = std::max(most, over / boost::math::ibetac(a, b, .5) - over);
    }
    EXPECT_NEAR(study.at(name).at("prior_cut_off_adds_at_most").as_double(), most, 1e-12) << name;
  }
  const std::string page = format_page({report});
  EXPECT_NE(page.find("report.json (<code>flipped_without_marked</code>)"), std::string::npos);
  EXPECT_NE(page.find("report.json (<code>prior_cut_off_adds_at_most</code>)"), std::string::npos);
}

// Of three trends that compare something the least p is thrice itself, then twice the next, and no less.
TEST(LeastHolm, corrects_the_least_p_of_trends_that_compare_something) {
  std::vector<Trend> trends(4);
  const double least[] = {.01, .5, .02, .015};
  for (std::size_t i = 0; i < 4; ++i) {
    trends[i].p_least = least[i];
    trends[i].status = i == 1 ? TrendStatus::kNoPairs : TrendStatus::kTested;
  }
  const std::vector<double> holm = find_least_holm(trends);
  ASSERT_EQ(holm.size(), 4U);
  EXPECT_DOUBLE_EQ(holm[0], .03);
  EXPECT_DOUBLE_EQ(holm[1], 1);
  EXPECT_DOUBLE_EQ(holm[2], .03);
  EXPECT_DOUBLE_EQ(holm[3], .03);
}

// Trials go v0, v0, ... in these folders: one more view by hand.
TEST_F(Folders, count_correct_answers_by_view) {
  RawDatabase(StudyFolder{temporary_ / "a"}.responses())
      .query("UPDATE trial SET test_key = replace(test_key, '-v0', '-v1') WHERE trial % 3 = 1");
  const Report report = load({"a"})[0];
  std::array<Count, 2> expected{};
  std::map<std::int64_t, int> trials;
  for (const AnswerRow& answer : report.evidence.material.answers) {
    Count& count = expected[trials[answer.session]++ % 3 == 1 ? 1 : 0];
    ++count.n;
    count.k += answer.correct ? 1 : 0;
  }
  ASSERT_TRUE(count_by_view(report.evidence.material));
  EXPECT_EQ(*count_by_view(report.evidence.material), expected);
  EXPECT_EQ(make_report_json({report}).at("studies").at(0).at("material").at("by_view").at("v1").at("k"),
            Json(expected[1].k));
  const std::string row =
      fmt::format("<tr><td>material</td><td class=\"number\">{} of {}</td>", expected[0].k, expected[0].n);
  EXPECT_NE(format_page({report}).find(row), std::string::npos);
  erase_answer(StudyFolder{temporary_ / "a"}, 1, 3);
  const Report damaged = load({"a"})[0];
  EXPECT_FALSE(count_by_view(damaged.evidence.artifact));
  EXPECT_TRUE(count_by_view(damaged.evidence.material));
  EXPECT_FALSE(count_by_view(ExperimentEvidence{}));
}

TEST_F(Folders, write_no_number_that_is_not_finite) {
  for (const ReportTable& table : make_report_tables(load({"a", "b", "n"}))) {
    for (const auto& row : table.table.rows) {
      for (const std::string& field : row) {
        EXPECT_NE(field, "nan");
        EXPECT_NE(field, "-nan");
        EXPECT_NE(field, "inf");
      }
    }
  }
}

TEST_F(Folders, make_a_figure_for_each_illumination_and_one_of_plain_above_normalised) {
  make_answered_folder(temporary_ / "paper", "paper", 4, 3, 3);
  const auto reports = load({"paper", "n"});
  const auto figures = make_figures(reports);
  std::vector<std::string> names;
  for (const Figure& figure : figures) names.push_back(figure.name);
  EXPECT_EQ(names, (std::vector<std::string>{"figure-paper-ind", "figure-paper-dir",
                                             "figure-normalisation-ind", "figure-paper+normalisation"}));
  EXPECT_EQ(figures[0].panels.size(), 20U);
  EXPECT_EQ(figures[3].width, 4U);
  EXPECT_EQ(figures[3].panels.size(), 8U);
  const std::string text = format_figure(figures[3], Rule::kPaper, FigureFormat::kPdf, "it's.pdf");
  EXPECT_NE(text.find("set output 'it''s.pdf'"), std::string::npos);
}

std::size_t count_parts(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

// What follows the line that opens a block of cells with this drawing in the panel: its rows.
std::size_t count_cells(const std::string& text, const std::string& label) {
  std::size_t count = 0;
  for (auto at = text.find(", $b"); at != std::string::npos; at = text.find(", $b", at + 1)) {
    const std::string block = text.substr(at + 2, text.find(' ', at + 2) - at - 2);
    if (!text.substr(at).starts_with(", " + block + " using 1:2:('" + label + "')")) continue;
    const auto begin = text.rfind(block + " << EOD\n", at);
    count += count_parts(text.substr(begin, text.find("\nEOD", begin) - begin), " 0.5 0.5");
  }
  return count;
}

// Of each E and (E): whether both experiments were asked there; and of each frame: whether it is supported.
TEST_F(Folders, make_figures_that_say_whose_answers_they_show_and_tell_tested_levels_from_inferred_ones) {
  auto reports = load({"a"});
  std::size_t asked = 0, inferred = 0, supported = 0;
  for (const ColumnFinding& column : reports[0].findings) {
    const RuleFinding& under = column.under(Rule::kPaper);
    supported += under.supported.size();
    for (const int level : under.green) {
      const auto i = static_cast<std::size_t>(level);
      ++(column.artifact[i].count.n > 0 && column.material[i].count.n > 0 ? asked : inferred);
    }
  }
  ASSERT_GT(asked, 0U);
  ASSERT_GT(inferred, 0U);
  ASSERT_GT(supported, 0U);
  const auto format = [&] {
    return format_figure(make_figures(reports)[0], Rule::kPaper, FigureFormat::kSvg, "x.svg");
  };
  const std::string text = format();
  EXPECT_EQ(count_cells(text, "E"), asked);
  EXPECT_EQ(count_cells(text, "(E)"), inferred);
  EXPECT_EQ(count_parts(text, " 0.42 0.40\n"), supported);
  EXPECT_NE(text.find("PLANTED SUBJECTS"), std::string::npos);
  EXPECT_NE(text.find("rule paper"), std::string::npos);
  EXPECT_EQ(count_parts(text, "set xlabel 'VPLs'"), 4U);
  EXPECT_EQ(count_parts(text, "set ylabel 'clamp level, C10 most clamped'"), 4U);
  reports[0].evidence.kind = SubjectKind::kPerson;
  EXPECT_EQ(format().find("PLANTED"), std::string::npos);
  EXPECT_NE(format().find("answers of persons"), std::string::npos);
}

// A normalised study of the name of an illumination.
TEST_F(Folders, make_no_two_figures_of_one_name) {
  auto reports = load({"n"});
  Report plain = reports[0];
  plain.study.name = "main";
  plain.study.normalise = false;
  reports[0].study.name = "ind";
  reports.push_back(std::move(plain));
  std::vector<std::string> names;
  for (const Figure& figure : make_figures(reports)) names.push_back(figure.name);
  EXPECT_THAT(names, testing::UnorderedElementsAre("figure-ind-ind", "figure-main-ind", "figure-main+ind"));
}

TEST_F(Folders, are_drawn_by_gnuplot_as_svg_and_pdf) {
  const ReportFiles files = draw_figures(load({"a"}));
  ASSERT_EQ(files.size(), 2U);
  EXPECT_TRUE(files.at("figure-pocket-ind.pdf").starts_with("%PDF"));
  for (const char* word : {"G0 MS", "G2 GS", "100k", "C10"})
    EXPECT_NE(files.at("figure-pocket-ind.svg").find(word), std::string::npos) << word;
}

// A second and more between them, which a time of day would show.
TEST_F(Folders, reported_twice_give_the_same_bytes_in_every_file) {
  AnalyzeParams params = make_params({temporary_ / "a"}, temporary_ / "one");
  params.plot = true;
  ASSERT_EQ(run_report(params), 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));
  params.out = temporary_ / "two";
  ASSERT_EQ(run_report(params), 0);
  const auto one = read_files(temporary_ / "one"), two = read_files(temporary_ / "two");
  ASSERT_EQ(one.size(), two.size());
  EXPECT_TRUE(one.contains("figure-pocket-ind.pdf") && one.contains(kReportList));
  for (const auto& [name, bytes] : one) EXPECT_TRUE(bytes == two.at(name)) << name;
}

TEST_F(Folders, exported_again_replace_other_answers_only_when_told_to) {
  const fs::path out = temporary_ / "answers";
  const auto run = [&](const std::string& name, bool force) {
    AnalyzeParams params = make_params({temporary_ / name}, out);
    params.force = force;
    EXPECT_EQ(run_export(params), kExitOk);
    return read_files(out);
  };
  const auto refusal_of = [&](const std::string& name) {
    return message_of<InputError>([&] { run(name, false); });
  };
  const auto first = run("a", false);
  EXPECT_EQ(run("a", false), first);
  EXPECT_EQ(refusal_of("b"), (out / "answers.csv").string() +
                                 ": expected a free name or a file with the same bytes, got one with others; "
                                 "--force replaces an earlier export");
  EXPECT_EQ(read_files(out), first);
  EXPECT_NE(run("b", true), first);
  save_text(out / "csv-metadata.json", "{}");
  const auto edited = read_files(out);
  EXPECT_THAT(refusal_of("b"), testing::HasSubstr("csv-metadata.json: expected a free name"));
  EXPECT_EQ(read_files(out), edited);
}

// Each report as the program writes it, one after another into one folder.
TEST_F(Folders, reported_again_with_fewer_figures_or_studies_leave_no_file_of_the_report_before) {
  const auto report = [&](const std::vector<fs::path>& folders, Rule rule, bool plot, const fs::path& out) {
    AnalyzeParams params = make_params(folders, out);
    params.rule = rule;
    params.plot = plot;
    testing::internal::CaptureStdout();
    EXPECT_EQ(run_report(params), kExitOk);
    return testing::internal::GetCapturedStdout();
  };
  const fs::path a = temporary_ / "a", n = temporary_ / "n", out = temporary_ / "out";
  report({a, n}, Rule::kPaper, true, out);
  EXPECT_TRUE(is_file(out / "figure-normalisation-ind.pdf"));
  EXPECT_TRUE(is_file(out / "graph-normalisation-G0-MR-ind.svg"));
  report({a}, Rule::kIsotonic, true, out);
  EXPECT_FALSE(is_file(out / "figure-normalisation-ind.pdf"));
  EXPECT_FALSE(is_file(out / "graph-normalisation-G0-MR-ind.svg"));
  EXPECT_TRUE(is_file(out / "figure-pocket-ind.svg"));
  save_text(out / "notes.txt", "mine");
  const std::string said = report({a}, Rule::kIsotonic, false, out);
  EXPECT_NE(said.find("not of this report, left as found: notes.txt"), std::string::npos) << said;
  fs::remove(out / "notes.txt");
  report({a}, Rule::kIsotonic, false, temporary_ / "fresh");
  EXPECT_EQ(read_files(out), read_files(temporary_ / "fresh"));
}

TEST_F(Folders, with_a_session_that_was_aborted_leave_it_out_and_say_so) {
  TrialLog log(StudyFolder{temporary_ / "a"}.responses());
  SessionRow row = make_fake_session(77, SubjectKind::kPlanted, Experiment::kArtifact);
  row.digests.study = load_protocol("pocket").digest;
  const auto id = log.append_session(row, make_fake_trials(5));
  log.append_answer(id, {0, Side::kLeft, 1000}, 1, 5000);
  const auto reports = load({"a"});
  EXPECT_EQ(reports[0].evidence.artifact.finished.size(), 12U);
  EXPECT_EQ(reports[0].artifact_subjects.sessions.size(), 13U);
  const auto& warnings = reports[0].warnings;
  EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
    return warning ==
           "1 artifact sessions were not finished (0 ended early by the experimenter, 1 left "
           "unfinished): their 1 answers are left out.";
  }));
  EXPECT_NE(format_page(reports).find("not finished, left out"), std::string::npos);
}

}  // namespace
}  // namespace equilux::tests
