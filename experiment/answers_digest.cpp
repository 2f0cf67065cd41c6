// Answers to one digest, whatever the order in which they are told.
#include <algorithm>
#include <fmt/format.h>
#include <map>

#include "base/digest.h"
#include "base/error.h"
#include "experiment/trial_log.h"
#include "protocols/cell_numbers.h"

namespace equilux {
namespace {

constexpr std::size_t kUsualRest = 16;  // bytes of a line after its key, or less

}  // namespace

void AnswersDigest::add(std::uint32_t cell, std::int64_t subject_index, bool correct) {
  if (subjects_.empty() || subjects_[last_] != subject_index) {
    const auto [rank, is_new] =
        ranks_.try_emplace(subject_index, static_cast<std::uint32_t>(subjects_.size()));
    if (is_new) subjects_.push_back(subject_index);
    last_ = rank->second;
  }
  if (cell >= by_cell_.size()) by_cell_.resize(cell + 1);
  by_cell_[cell].push_back(2 * last_ + (correct ? 1 : 0));
}

// The lines "KEY INDEX correct\n" in the order of their bytes, sorted by the first field and then by the
// rest: no key holds a blank or anything that sorts before it. Of the rests there are few, so they are sorted
// once and then told by their ranks.
std::string AnswersDigest::finish(const std::vector<Cell>& cells) {
  std::vector<std::string> rests;
  for (const std::int64_t subject : subjects_) {
    for (const char* outcome : {"wrong", "correct"})
      rests.push_back(fmt::format(" {} {}\n", subject, outcome));
  }
  std::vector<std::string> sorted = rests;
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::uint32_t> ranks;
  for (const std::string& rest : rests)
    ranks.push_back(
        static_cast<std::uint32_t>(std::lower_bound(sorted.begin(), sorted.end(), rest) - sorted.begin()));
  std::map<std::string, std::vector<std::uint32_t>*> by_key;
  std::size_t size = 0;
  for (std::size_t i = 0; i < by_cell_.size(); ++i) {
    if (by_cell_[i].empty()) continue;
    const auto [entry, is_new] = by_key.emplace(format_key(cells[i]), &by_cell_[i]);
    EQ_CHECK(is_new, entry->first);
    size += by_cell_[i].size() * (entry->first.size() + kUsualRest);
  }
  std::string text;
  text.reserve(size);
  for (const auto& [key, cell] : by_key) {
    for (std::uint32_t& rest : *cell) rest = ranks[rest];
    std::sort(cell->begin(), cell->end());
    for (const std::uint32_t rank : *cell) text.append(key).append(sorted[rank]);
  }
  return digest_text(text);
}

std::string digest_answers(const std::vector<AnswerRow>& answers) {
  CellNumbers numbers;
  AnswersDigest digest;
  for (const AnswerRow& answer : answers)
    digest.add(numbers.number_of(answer.cell), answer.subject_index, answer.correct);
  return digest.finish(numbers.cells());
}

}  // namespace equilux
