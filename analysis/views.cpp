// Answers beside the views of their trials, which stand in the same order within a session.
#include "analysis/views.h"

#include <unordered_map>

#include "base/error.h"

namespace equilux {

std::optional<std::array<Count, 2>> count_by_view(const ExperimentEvidence& evidence) {
  std::unordered_map<std::int64_t, const std::vector<std::uint8_t>*> combos;
  for (const SessionSummary& summary : evidence.summaries) {
    if (!summary.complete) continue;
    if (summary.answered != std::ssize(summary.combos)) return std::nullopt;
    combos[summary.session] = &summary.combos;
  }
  std::unordered_map<std::int64_t, std::size_t> read;
  std::array<Count, 2> counts{};
  for (const AnswerRow& answer : evidence.answers) {
    const auto found = combos.find(answer.session);
    const std::size_t place = read[answer.session]++;
    if (found == combos.end()) return std::nullopt;
    EQ_CHECK(place < found->second->size(), place, answer.session);
    Count& count = counts.at((*found->second)[place] >> 1);
    ++count.n;
    count.k += answer.correct ? 1 : 0;
  }
  if (evidence.answers.empty()) return std::nullopt;
  return counts;
}

}  // namespace equilux
