// Answers to counts; nothing is weighed or judged here but the cut of a single cell.
#include "analysis/tally.h"

#include <algorithm>
#include <utility>

#include "base/error.h"

namespace equilux {

namespace {

// Whether the sessions stand one after another, none with two answers to a cell.
bool are_in_turn_and_once(const Answers& answers) {
  std::vector<std::size_t> last(answers.cells().size(), 0);  // session of a cell's last answer, from 1
  std::vector<std::int64_t> sessions;
  for (const CountedAnswer& answer : answers.rows()) {
    if (sessions.empty() || sessions.back() != answer.session) sessions.push_back(answer.session);
    if (last[answer.cell] == sessions.size()) return false;
    last[answer.cell] = sessions.size();
  }
  std::sort(sessions.begin(), sessions.end());
  return std::adjacent_find(sessions.begin(), sessions.end()) == sessions.end();
}

void check_answered_once(const Answers& answers) {
  if (are_in_turn_and_once(answers)) return;
  std::vector<std::pair<std::int64_t, std::uint32_t>> keys;
  for (const CountedAnswer& answer : answers.rows()) keys.emplace_back(answer.session, answer.cell);
  std::sort(keys.begin(), keys.end());
  const auto twice = std::adjacent_find(keys.begin(), keys.end());
  if (twice == keys.end()) return;
  throw InputError("answers", fmt::format("session {}", twice->first), "one answer to each cell",
                   format_key(answers.cells()[twice->second]) + " twice");
}

}  // namespace

Tally tally_answers(const Answers& answers, const Study& study) {
  Tally tally;
  for (const Cell& cell : enumerate_cells(study)) tally[cell] = {};
  std::vector<Count*> counts;
  for (const Cell& cell : answers.cells()) {
    const auto found = tally.find(cell);
    counts.push_back(found == tally.end() ? nullptr : &found->second);
  }
  for (const CountedAnswer& answer : answers.rows()) {
    Count* count = counts[answer.cell];
    if (!count) {
      throw InputError("answers", fmt::format("session {}", answer.session),
                       fmt::format("a cell of the study {}", study.name),
                       format_key(answers.cell_of(answer)));
    }
    ++count->n;
    count->k += answer.correct ? 1 : 0;
  }
  check_answered_once(answers);
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
