// What a study must find if its subjects never err: thresholds and equivalence, worked out from the planted
// truth by the letter of the rules and without the code of analysis/.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "protocols/truth.h"
#include "protocols/windows.h"
#include "tests/walk/report_tables.h"

namespace equilux {

struct PlantedFinding {
  int first = 0;    ///< of the window's four levels
  int visible = 0;  ///< levels of the window in which an artifact is visible, 0 .. 4
  std::optional<int> artifact_cut;
  std::string artifact_status;
  std::vector<int> kept;  ///< levels of the material experiment
  std::optional<int> material_cut;
  std::string material_status;
  std::vector<int> green;

  std::vector<int> window() const { return {first, first + 1, first + 2, first + 3}; }
};

/// The first surviving level, every second, and always C10.
inline std::vector<int> thin_levels(int first) {
  std::vector<int> kept;
  for (int level = first; level <= 10; level += 2) kept.push_back(level);
  if (kept.empty() || kept.back() != 10) kept.push_back(10);
  return kept;
}

/// Artifacts: nothing flagged puts the cut at the window's first level, everything flagged just behind it.
inline void plant_artifact_cut(const PlantedColumn& truth, PlantedFinding& finding) {
  finding.visible = std::clamp(truth.artifact_free_from - finding.first, 0, 4);
  const int cut = finding.first + finding.visible;
  finding.artifact_status = finding.visible == 0   ? "censored_low"
                            : finding.visible == 4 ? "censored_high"
                                                   : "cut";
  if (cut <= 10) finding.artifact_cut = cut;
  if (cut > 10) finding.artifact_status = "none";
}

/// Material: unchanged up to the last tested level before the first changed one. With all changed it lies
/// below the first of them, if that is not C0.
inline void plant_material_cut(const PlantedColumn& truth, PlantedFinding& finding) {
  finding.material_status = "untested";
  if (!finding.artifact_cut) return;
  finding.kept = thin_levels(*finding.artifact_cut);
  for (int level : finding.kept) {
    if (level <= truth.material_same_to) finding.material_cut = level;
  }
  finding.material_status = !finding.material_cut ? *finding.artifact_cut == 0 ? "none" : "censored_low"
                            : *finding.material_cut == 10 ? "censored_high"
                                                          : "cut";
  if (!finding.material_cut) return;
  for (int level = *finding.artifact_cut; level <= *finding.material_cut; ++level)
    finding.green.push_back(level);
}

/// By column_name.
inline std::map<std::string, PlantedFinding> make_planted_findings(const Truth& truth,
                                                                   const Windows& windows) {
  std::map<std::string, PlantedFinding> findings;
  for (const auto& [column, planted] : truth.by_column) {
    PlantedFinding finding;
    finding.first = windows.by_column.at(column).first_level;
    plant_artifact_cut(planted, finding);
    plant_material_cut(planted, finding);
    findings[column_name(column)] = finding;
  }
  return findings;
}

}  // namespace equilux
