// First step from answers to tables: k of n for each cell of the study.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "analysis/answers.h"
#include "protocols/study.h"

namespace equilux {

/// k of n subjects were correct.
struct Count {
  std::int64_t k = 0;
  std::int64_t n = 0;
  bool operator==(const Count&) const = default;
};

/// Counts of one experiment. shape: every cell of the study, with n = 0 where nobody was asked.
using Tally = std::map<Cell, Count>;

/// The counts of a column at a clamp level.
struct LevelCount {
  int level = 0;
  Count count;
  bool operator==(const LevelCount&) const = default;
};

/// A column. shape: every clamp level of the study, from least to most clamped.
using ColumnCounts = std::vector<LevelCount>;

/// Adds up the answers of one kind and experiment, in any order. errors: InputError for a cell that the study
/// does not have, or that one session answered twice.
Tally tally_answers(const Answers& answers, const Study& study);

ColumnCounts counts_of(const Tally& tally, const Column& column, const Study& study);

inline constexpr int kFlagPercent = 75;  ///< correct, at which a cell is flagged

/// True iff 100 k >= percent x n, in integers (4k >= 3n at the study's 75); an untested cell is never
/// flagged.
bool is_flagged(const Count& count, int percent = kFlagPercent);

/// Number of answers behind a tally.
std::int64_t count_answers(const Tally& tally);

}  // namespace equilux
