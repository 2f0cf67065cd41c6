// Columns and answers made by hand or by chance, for the tests of this folder.
#pragma once

#include <functional>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "analysis/equivalence.h"
#include "analysis/prune.h"
#include "base/random.h"
#include "protocols/truth.h"
#include "protocols/windows.h"

namespace equilux::tests {

/// A column of all eleven levels of which only these were tested, k of n each.
inline ColumnCounts make_column(const std::vector<std::pair<int, Count>>& tested) {
  ColumnCounts counts;
  for (int level = 0; level < kClampLevelCount; ++level) counts.push_back({level, {}});
  for (const auto& [level, count] : tested) counts[static_cast<std::size_t>(level)].count = count;
  return counts;
}

/// Four adjacent levels from `first`, k of 12 each.
inline ColumnCounts make_window(int first, const std::vector<std::int64_t>& correct, std::int64_t n = 12) {
  std::vector<std::pair<int, Count>> tested;
  for (std::size_t i = 0; i < correct.size(); ++i) {
    tested.push_back({first + static_cast<int>(i), {correct[i], n}});
  }
  return make_column(tested);
}

inline Study load_protocol(const std::string& name) {
  return load_study(std::string(EQUILUX_SOURCE_DIR) + "/protocols/" + name + ".json");
}

inline bool is_visible(const PlantedColumn& planted, Experiment experiment, int level) {
  return experiment == Experiment::kArtifact ? level < planted.artifact_free_from
                                             : level > planted.material_same_to;
}

/// Answers of `subjects` planted subjects to these cells: a visible difference without a lapse is always
/// found, everything else by a fair coin. Independent of the program's own simulated subjects.
inline std::vector<AnswerRow> answer_by_truth(const Truth& truth, const std::vector<Cell>& cells,
                                              Experiment experiment, int subjects, std::uint64_t seed,
                                              double lapse_rate) {
  std::vector<AnswerRow> answers;
  for (int subject = 0; subject < subjects; ++subject) {
    RandomStream random(seed, format_experiment(experiment), static_cast<std::uint64_t>(subject));
    for (const Cell& cell : cells) {
      const bool seen = is_visible(truth.by_column.at(cell.column), experiment, cell.clamp_level);
      const bool found = seen && random.next_double() >= lapse_rate;
      const bool coin = random.next_below(2) == 0;
      answers.push_back({subject + 1, subject, cell, found || coin});
    }
  }
  return answers;
}

inline std::vector<Cell> enumerate_window_cells(const Study& study, const Windows& windows) {
  std::vector<Cell> cells;
  for (const Column& column : enumerate_columns(study)) {
    const int first = windows.by_column.at(column).first_level;
    for (int level = first; level < first + kWindowLevels; ++level) {
      cells.push_back({column, level, study.normalise});
    }
  }
  return cells;
}

/// A whole study answered by planted subjects, pruned between the experiments.
struct PlantedStudy {
  Study study;
  Truth truth;
  std::vector<AnswerRow> artifact;
  std::vector<AnswerRow> material;
  Selection selection;
};

inline PlantedStudy make_planted_study(const std::string& name, int artifact_subjects, int material_subjects,
                                       std::uint64_t seed, double lapse_rate, Rule rule = Rule::kPaper) {
  PlantedStudy planted;
  planted.study = load_protocol(name);
  planted.truth = load_truth(planted.study.truth_path, planted.study);
  const Windows windows = load_windows(planted.study.windows_path, planted.study);
  planted.artifact = answer_by_truth(planted.truth, enumerate_window_cells(planted.study, windows),
                                     Experiment::kArtifact, artifact_subjects, seed, lapse_rate);
  planted.selection = make_selection(planted.study, tally_answers(planted.artifact, planted.study),
                                     SubjectKind::kPlanted, rule, std::string(64, 'a'));
  planted.material =
      answer_by_truth(planted.truth, enumerate_selected_cells(planted.selection, planted.study),
                      Experiment::kMaterial, material_subjects, seed, lapse_rate);
  return planted;
}

inline std::vector<ColumnFinding> find_in(const PlantedStudy& planted) {
  return find_equivalence(planted.study, tally_answers(planted.artifact, planted.study),
                          tally_answers(planted.material, planted.study), &planted.selection);
}

}  // namespace equilux::tests
