// The answers that are counted, by the million: each in sixteen bytes, its cell by number.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <vector>

#include "experiment/trial_log.h"
#include "protocols/cell_numbers.h"

namespace equilux {

/// As an AnswerRow.
struct CountedAnswer {
  std::int64_t session = 0;
  std::uint32_t cell = 0;  ///< index into Answers::cells
  bool correct = false;
};

/// Answers of one experiment.
class Answers {
 public:
  Answers() = default;
  /// So that a log's rows can stand for them.
  Answers(const std::vector<AnswerRow>& answers);
  Answers(std::initializer_list<AnswerRow> answers) : Answers(std::vector(answers)) {}

  /// Each once, in no order; some may have no answer.
  const std::vector<Cell>& cells() const { return numbers_.cells(); }
  const Cell& cell_of(const CountedAnswer& answer) const { return cells()[answer.cell]; }
  /// In order of trial within a session.
  const std::vector<CountedAnswer>& rows() const { return rows_; }
  std::size_t size() const { return rows_.size(); }
  bool empty() const { return rows_.empty(); }

  void reserve(std::size_t answers) { rows_.reserve(answers); }
  std::uint32_t number_of(const Cell& cell) { return numbers_.number_of(cell); }
  void push_back(const CountedAnswer& answer) { rows_.push_back(answer); }
  void push_back(const AnswerRow& answer);
  /// Puts those of others behind these.
  void append(const Answers& others);
  /// Gives each answer the session that `number_of` has for its own.
  void renumber_sessions(const auto& number_of) {
    std::int64_t before = 0, after = 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (i == 0 || rows_[i].session != before) after = number_of(before = rows_[i].session);
      rows_[i].session = after;
    }
  }

 private:
  CellNumbers numbers_;
  std::vector<CountedAnswer> rows_;
};

}  // namespace equilux
