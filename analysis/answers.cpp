// Rows of a log to numbers, and numbers of one list to those of another.
#include "analysis/answers.h"

namespace equilux {

Answers::Answers(const std::vector<AnswerRow>& answers) {
  reserve(answers.size());
  for (const AnswerRow& answer : answers) push_back(answer);
}

void Answers::push_back(const AnswerRow& answer) {
  push_back(CountedAnswer{answer.session, number_of(answer.cell), answer.correct});
}

void Answers::append(const Answers& others) {
  std::vector<std::uint32_t> numbers;
  for (const Cell& cell : others.cells()) numbers.push_back(number_of(cell));
  for (const CountedAnswer& answer : others.rows())
    push_back(CountedAnswer{answer.session, numbers[answer.cell], answer.correct});
}

}  // namespace equilux
