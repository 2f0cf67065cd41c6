// The rules that every schedule must keep, as functions that name each breach: run on schedules, and on
// mutants.
#pragma once

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fmt/format.h>
#include <map>
#include <string>
#include <vector>

#include "experiment/schedule.h"

namespace equilux {

using Breaches = std::vector<std::string>;

inline void require(Breaches& breaches, bool kept, const std::string& rule, const std::string& where) {
  if (!kept) breaches.push_back(rule + ": " + where);
}

/// Two pictures: same geometry and illumination, different materials, different views.
inline void check_artifact_pair(Breaches& breaches, const Study& study, const TrialRow& trial) {
  const Condition test = parse_condition(trial.test_key, "schedule");
  const Family pair = parse_family(trial.pair_key, "schedule");
  const Object& object = test.cell.column.object;
  const auto materials = enumerate_reference_materials(study, object);
  require(breaches, pair.object.geometry == object.geometry, "same geometry", trial.test_key);
  require(breaches, pair.object.illumination == object.illumination, "same illumination", trial.test_key);
  require(breaches, pair.object.material != object.material, "different materials", trial.test_key);
  require(breaches, std::ranges::count(materials, pair.object.material) == 1, "a material of the study",
          trial.pair_key);
  require(breaches, pair.view == 1 - test.view, "different views", trial.test_key);
  require(breaches, trial.upper_key.empty(), "the upper place stays empty", trial.upper_key);
}

/// Three pictures of one object; which of them is turned is the study's view mode.
inline void check_material_triple(Breaches& breaches, const Study& study, const TrialRow& trial) {
  const Condition test = parse_condition(trial.test_key, "schedule");
  const Family pair = parse_family(trial.pair_key, "schedule");
  const Family upper = parse_family(trial.upper_key, "schedule");
  const bool pair_turned = study.view_mode == ViewMode::kPairTurned;
  require(breaches, pair.object == test.cell.column.object, "same object", trial.pair_key);
  require(breaches, upper.object == test.cell.column.object, "same object", trial.upper_key);
  require(breaches, (pair.view == test.view) != pair_turned, "views of the lower pair", trial.test_key);
  require(breaches, (upper.view == test.view) == pair_turned, "view of the upper picture", trial.test_key);
}

inline Breaches check_pairing(const Study& study, Experiment experiment,
                              const std::vector<TrialRow>& trials) {
  Breaches breaches;
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const TrialRow& trial = trials[i];
    require(breaches, trial.number == static_cast<int>(i), "numbered in order", trial.test_key);
    require(breaches, parse_condition(trial.test_key, "schedule").cell == trial.cell, "shows its cell",
            trial.test_key);
    require(breaches, !trial.answer && !trial.response_time_ns && !trial.answered_utc, "not answered yet",
            trial.test_key);
    if (experiment == Experiment::kArtifact) {
      check_artifact_pair(breaches, study, trial);
    } else {
      check_material_triple(breaches, study, trial);
    }
  }
  return breaches;
}

/// 0 .. 3: view x side.
inline std::size_t combo_of(const TrialRow& trial) {
  const int view = parse_condition(trial.test_key, "schedule").view;
  return static_cast<std::size_t>(2 * view + (trial.test_side == Side::kRight ? 1 : 0));
}

using ComboCounts = std::array<int, 4>;

/// Joint counts differ by at most one, and so do those of sides and of views: exactly half left where the
/// number is even.
inline void check_even(Breaches& breaches, const ComboCounts& counts, const std::string& where) {
  const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
  require(breaches, *most - *least <= 1, "view x side differ by at most one", where);
  const int more_right = counts[1] + counts[3] - counts[0] - counts[2];
  const int more_turned = counts[2] + counts[3] - counts[0] - counts[1];
  require(breaches, std::abs(more_right) <= 1, "half left, half right", where);
  require(breaches, std::abs(more_turned) <= 1, "half v0, half v1", where);
}

inline Breaches check_session_balance(const std::vector<TrialRow>& trials) {
  Breaches breaches;
  ComboCounts counts{};
  for (const TrialRow& trial : trials) ++counts[combo_of(trial)];
  check_even(breaches, counts, "within the session");
  return breaches;
}

/// Adds up subjects in order of index and checks each cell after every one of them.
class BalanceOverSubjects {
 public:
  BalanceOverSubjects(const Study& study, Experiment experiment) : study_(study), experiment_(experiment) {}

  Breaches add(const std::vector<TrialRow>& trials) {
    Breaches breaches;
    for (const TrialRow& trial : trials) {
      ComboCounts& counts = combos_[trial.cell];
      ++counts[combo_of(trial)];
      check_even(breaches, counts, format_key(trial.cell));
      if (experiment_ == Experiment::kArtifact) add_material(breaches, trial);
    }
    return breaches;
  }

 private:
  void add_material(Breaches& breaches, const TrialRow& trial) {
    auto& counts = materials_[trial.cell];
    if (counts.empty()) {
      for (const auto& material : enumerate_reference_materials(study_, trial.cell.column.object)) {
        counts[material] = 0;
      }
    }
    ++counts[parse_family(trial.pair_key, "schedule").object.material];
    const auto [least, most] = std::minmax_element(
        counts.begin(), counts.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    require(breaches, most->second - least->second <= 1, "reference materials differ by at most one",
            format_key(trial.cell));
  }

  const Study& study_;
  Experiment experiment_;
  std::map<Cell, ComboCounts> combos_;
  std::map<Cell, std::map<std::string, int>> materials_;
};

}  // namespace equilux
