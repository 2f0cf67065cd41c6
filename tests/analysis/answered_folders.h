// Study folders with logs of planted answers, and what a report makes of them.
#pragma once

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <map>
#include <string>
#include <vector>

#include "analysis/program.h"
#include "analysis/report_tables.h"
#include "base/files.h"
#include "tests/analysis/columns.h"
#include "tests/experiment/fake_trials.h"
#include "tests/experiment/raw_database.h"
#include "tests/support/failures.h"
#include "tests/support/temp_folder.h"

namespace equilux::tests {

/// A study folder with a log of planted answers, as equilux-session leaves it, but without pictures.
inline void make_answered_folder(const std::filesystem::path& root, const std::string& protocol,
                                 std::uint64_t seed, int artifact, int material) {
  const PlantedStudy planted = make_planted_study(protocol, artifact, material, seed, 0.05);
  const StudyFolder folder{root};
  make_folder(root);
  save_text(folder.study(), format_json(planted.study.source));
  std::filesystem::copy_file(planted.study.windows_path, folder.windows());
  std::filesystem::copy_file(planted.study.truth_path, folder.truth());
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

inline AnalyzeParams make_params(const std::vector<std::filesystem::path>& folders,
                                 const std::filesystem::path& out) {
  AnalyzeParams params;
  params.study_folders = folders;
  params.out = out;
  params.plot = false;
  params.uncertainty = {1, 100, 100};
  return params;
}

inline std::map<std::string, std::string> read_files(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
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
    std::vector<std::filesystem::path> folders;
    for (const std::string& name : names) folders.push_back(temporary_ / name);
    return load_reports(make_params(folders, {}));
  }
  const TempFolder temporary_{find_memory_folder()};
};

inline std::size_t place_of(const Table& table, const std::string& column) {
  return static_cast<std::size_t>(std::find(table.columns.begin(), table.columns.end(), column) -
                                  table.columns.begin());
}

inline const Table& find_table(const std::vector<ReportTable>& tables, const std::string& file) {
  return std::find_if(tables.begin(), tables.end(), [&](const auto& table) { return table.file == file; })
      ->table;
}

/// As no program leaves it: an answer is taken from a finished session.
inline void erase_answer(const StudyFolder& folder, int session, int trial) {
  RawDatabase(folder.responses())
      .query(fmt::format("UPDATE trial SET answer = NULL, response_time_ns = NULL, answered_utc = NULL"
                         " WHERE session = {} AND trial = {}",
                         session, trial));
}

}  // namespace equilux::tests
