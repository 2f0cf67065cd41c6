// A planted truth: thresholds, lapses and side bias that simulated subjects are given.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "protocols/study.h"

namespace equilux {

struct PlantedColumn {
  int artifact_free_from = 0;  ///< an artifact is visible iff the level is less clamped; 11: at every level
  int material_same_to =
      0;  ///< a material change is visible iff the level is more clamped; -1: at every level
};

/// Neither an artifact nor a change of material is visible at a clamp level.
inline bool is_equivalent(const PlantedColumn& planted, int level) {
  return level >= planted.artifact_free_from && level <= planted.material_same_to;
}

struct Truth {
  double lapse_rate = 0;   ///< probability that a visible difference is not seen
  double side_bias = 0.5;  ///< probability of answering left when nothing is seen
  std::map<Column, PlantedColumn> by_column;
  Json source;
  std::string digest;
};

/// errors: InputError if a column of the study is missing or one is not of the study.
Truth load_truth(const std::filesystem::path& path, const Study& study);

}  // namespace equilux
