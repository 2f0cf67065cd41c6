// Answers to counts; nothing is weighed or judged here but the cut of a single cell.
#include "analysis/tally.h"

#include <set>
#include <utility>

#include "base/error.h"

namespace equilux {

Tally tally_answers(const std::vector<AnswerRow>& answers, const Study& study) {
  Tally tally;
  for (const Cell& cell : enumerate_cells(study)) tally[cell] = {};
  std::set<std::pair<std::int64_t, Cell>> seen;
  for (const AnswerRow& answer : answers) {
    const std::string place = fmt::format("session {}", answer.session);
    const auto found = tally.find(answer.cell);
    if (found == tally.end()) {
      throw InputError("answers", place, fmt::format("a cell of the study {}", study.name),
                       format_key(answer.cell));
    }
    if (!seen.emplace(answer.session, answer.cell).second) {
      throw InputError("answers", place, "one answer to each cell", format_key(answer.cell) + " twice");
    }
    ++found->second.n;
    if (answer.correct) ++found->second.k;
  }
  return tally;
}

ColumnCounts counts_of(const Tally& tally, const Column& column, const Study& study) {
  ColumnCounts counts;
  for (int level : study.clamp_levels) {
    counts.push_back({level, tally.at(Cell{column, level, study.normalise})});
  }
  return counts;
}

bool is_flagged(const Count& count) { return count.n > 0 && 4 * count.k >= 3 * count.n; }

std::int64_t count_answers(const Tally& tally) {
  std::int64_t answers = 0;
  for (const auto& [cell, count] : tally) answers += count.n;
  return answers;
}

}  // namespace equilux
