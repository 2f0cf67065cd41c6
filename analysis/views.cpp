// Answers beside the views of their trials, which stand in the same order within a session.
#include "analysis/views.h"

#include <unordered_map>

#include "base/error.h"

namespace equilux {

std::optional<std::array<Count, 2>> count_by_view(const ExperimentEvidence& evidence) {
  std::unordered_map<std::int64_t, const std::vector<std::uint8_t>*> combos;
  for (const SessionSummary& summary : evidence.summaries) {
    if (!summary.complete) continue;
    if (summary.answered > 0 && summary.combos.empty()) return std::nullopt;
    combos[summary.session] = &summary.combos;
  }
  std::unordered_map<std::int64_t, std::size_t> read;
  std::array<Count, 2> counts{};
  std::optional<std::int64_t> session;
  const std::vector<std::uint8_t>* of_session = nullptr;
  std::size_t* next = nullptr;
  for (const CountedAnswer& answer : evidence.answers.rows()) {
    if (session != answer.session) {
      session = answer.session;
      const auto found = combos.find(answer.session);
      if (found == combos.end()) return std::nullopt;
      of_session = found->second;
      next = &read[answer.session];
    }
    while (*next < of_session->size() && (*of_session)[*next] >= kUnansweredCombo) ++*next;
    EQ_CHECK(*next < of_session->size(), *next, answer.session);
    Count& count = counts.at((*of_session)[(*next)++] >> 1);
    ++count.n;
    count.k += answer.correct ? 1 : 0;
  }
  if (evidence.answers.empty()) return std::nullopt;
  return counts;
}

}  // namespace equilux
