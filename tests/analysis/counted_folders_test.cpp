// Whose answers a report of one or several folders counts, and what it says of the others.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <set>

#include "analysis/interim.h"
#include "base/error.h"
#include "experiment/simulate.h"
#include "experiment/withdraw.h"
#include "protocols/session_protocol.h"
#include "tests/analysis/answered_folders.h"

namespace equilux::tests {
namespace {
namespace fs = std::filesystem;

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
              testing::Contains(fmt::format(fmt::runtime(told), "1 material session")));
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

// A copy from before the session's end, or one that went on after it.
TEST_F(Folders, of_which_one_has_a_session_unfinished_that_another_has_finished_are_refused) {
  const StudyFolder folder{temporary_ / "a"}, other{temporary_ / "b"};
  RawDatabase(other.responses())
      .query("UPDATE session SET uuid = 'one and the same', complete = 0 WHERE id = 3");
  RawDatabase(folder.responses()).query("UPDATE session SET uuid = 'one and the same' WHERE id = 2");
  EXPECT_THAT(message_of<InputError>([&] {
                load({"a", "b"});
              }),
              testing::MatchesRegex(".*/b: session 3 of P2: expected each session in one log: .*, "
                                    "got one that .*/a has too"));
}

// Two logs merged: both have a session of the code.
TEST_F(Folders, of_one_log_with_two_sessions_of_a_code_do_not_speak_of_different_logs) {
  RawDatabase(StudyFolder{temporary_ / "a"}.responses())
      .query("UPDATE session SET participant = (SELECT participant FROM session WHERE id = 1) WHERE id = 2");
  const auto warnings = load({"a"})[0].warnings;
  EXPECT_THAT(warnings, testing::Contains(testing::HasSubstr(
                            "more than once, as a log merged from several may have it: P0 (2 times). The 12 "
                            "sessions are of 11 codes.")));
  EXPECT_THAT(warnings, testing::Not(testing::Contains(testing::HasSubstr("in different logs"))));
}

TEST_F(Folders, with_answers_that_the_study_does_not_allow_name_log_and_session) {
  const StudyFolder folder{temporary_ / "b"};
  const auto refuse = [&](const std::string& cell) {
    RawDatabase(folder.responses())
        .query(fmt::format("UPDATE trial SET cell = '{}' WHERE session = 2 AND trial = 5", cell));
    return message_of<InputError>([&] { load({"a", "b"}); });
  };
  const std::string place = folder.responses().string() + ": session 2 of P1, trial 5: expected ";
  EXPECT_EQ(refuse("G3-MS-ind-1k-C4"), place + "a cell of the study pocket, got G3-MS-ind-1k-C4");
  const std::string first =
      RawDatabase(folder.responses()).value("SELECT cell FROM trial WHERE session = 2 AND trial = 0");
  EXPECT_EQ(refuse(first), place + "one answer to each cell, got " + first + " again");
}

// By the other rule: its selection would be another.
TEST_F(Folders, whose_used_selection_is_missing_are_not_called_frozen) {
  const StudyFolder folder{temporary_ / "a"};
  const auto path = folder.selection(SubjectKind::kPlanted);
  const std::string used = digest_selection(load_selection(path, load_folder_study(folder)));
  fs::remove(path);
  AnalyzeParams params = make_params({folder.root}, {});
  params.rule = Rule::kIsotonic;
  testing::internal::CaptureStdout();
  EXPECT_NE(run_prune(params), 0);
  const std::string told = testing::internal::GetCapturedStdout();
  EXPECT_THAT(told, testing::HasSubstr(path.string() + " is missing, and sessions have used one of digest " +
                                       used.substr(0, 12) + "...;"));
  EXPECT_THAT(told, testing::Not(testing::HasSubstr("frozen")));
  EXPECT_FALSE(fs::exists(path));
}

TEST_F(Folders, of_two_studies_of_one_name_are_refused_by_folder) {
  make_answered_folder(temporary_ / "z", "pocket", 4, 2, 2);
  const StudyFolder folder{temporary_ / "z"};
  std::string text = load_text(folder.study());
  text.replace(text.find("\"description\": \""), 16, "\"description\": \"Another. ");
  save_text(folder.study(), text);
  const std::string digest = load_folder_study(folder).digest;
  RawDatabase(folder.responses()).query("UPDATE session SET study_digest = '" + digest + "'");
  fs::remove(folder.selection(SubjectKind::kPlanted));
  const std::string error = message_of<InputError>([&] { load({"a", "z"}); });
  EXPECT_THAT(error, testing::HasSubstr("pocket"));
  EXPECT_THAT(error, testing::HasSubstr("one of that name with another digest"));
  for (const char* name : {"a", "z"})
    EXPECT_THAT(error, testing::HasSubstr((temporary_ / name).generic_string()));
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
                                   "unfinished one, none to count.")));
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
           "1 artifact session was not finished (0 ended early by the experimenter, 1 left "
           "unfinished): its 1 answer is left out.";
  }));
  EXPECT_NE(format_page(reports).find("not finished, left out"), std::string::npos);
}

}  // namespace
}  // namespace equilux::tests
