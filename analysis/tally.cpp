// Answers to counts; nothing is weighed or judged here but the cut of a single cell.
#include "analysis/tally.h"

#include <algorithm>
#include <utility>

#include "base/error.h"

namespace equilux {

namespace {

// Session in the high half, cell in the low: sorted, two answers to one cell are neighbours.
void check_answered_once(std::vector<std::uint64_t> keys, const std::vector<AnswerRow>& answers,
                         const std::vector<Cell>& cells) {
  std::sort(keys.begin(), keys.end());
  const auto twice = std::adjacent_find(keys.begin(), keys.end());
  if (twice == keys.end()) return;
  const Cell& cell = cells[*twice & 0xffffffff];
  std::vector<std::int64_t> sessions;
  for (const AnswerRow& answer : answers) {
    if (answer.cell == cell) sessions.push_back(answer.session);
  }
  std::sort(sessions.begin(), sessions.end());
  throw InputError("answers",
                   fmt::format("session {}", *std::adjacent_find(sessions.begin(), sessions.end())),
                   "one answer to each cell", format_key(cell) + " twice");
}

std::uint64_t make_answer_key(const AnswerRow& answer, std::uint32_t cell) {
  return static_cast<std::uint64_t>(answer.session) << 32 | cell;
}

}  // namespace

Tally tally_answers(const std::vector<AnswerRow>& answers, const Study& study) {
  CellNumbers numbers;
  for (const Cell& cell : enumerate_cells(study)) numbers.number_of(cell);
  std::vector<Count> counts(numbers.cells().size());
  std::vector<std::uint64_t> keys;
  keys.reserve(answers.size());
  for (const AnswerRow& answer : answers) {
    const std::uint32_t number = numbers.number_of(answer.cell);
    if (number >= counts.size()) {
      throw InputError("answers", fmt::format("session {}", answer.session),
                       fmt::format("a cell of the study {}", study.name), format_key(answer.cell));
    }
    keys.push_back(make_answer_key(answer, number));
    ++counts[number].n;
    counts[number].k += answer.correct ? 1 : 0;
  }
  check_answered_once(std::move(keys), answers, numbers.cells());
  Tally tally;
  for (std::size_t i = 0; i < counts.size(); ++i) tally[numbers.cells()[i]] = counts[i];
  return tally;
}

ColumnCounts counts_of(const Tally& tally, const Column& column, const Study& study) {
  ColumnCounts counts;
  for (int level : study.clamp_levels) {
    counts.push_back({level, tally.at(Cell{column, level, study.normalise})});
  }
  return counts;
}

bool is_flagged(const Count& count, int percent) { return count.n > 0 && 100 * count.k >= percent * count.n; }

std::int64_t count_answers(const Tally& tally) {
  std::int64_t answers = 0;
  for (const auto& [cell, count] : tally) answers += count.n;
  return answers;
}

}  // namespace equilux
