// The answers of one experiment as a matrix of subjects by cells: what resampling subjects works on.
#pragma once

#include <cstdint>
#include <vector>

#include "analysis/tally.h"

namespace equilux {

/// Subjects stand in the order of their answers' content, so that the matrix does not depend on the order of
/// rows, of subjects or of files, nor on what subjects are called.
struct ResponseMatrix {
  std::vector<Cell> cells;             ///< tested ones, sorted
  std::vector<std::int64_t> sessions;  ///< AnswerRow::session of each subject
  /// shape: subjects x cells, row by row. 1 where the subject was asked, and where it was correct.
  std::vector<std::uint8_t> asked;
  std::vector<std::uint8_t> correct;

  std::size_t subjects() const { return sessions.size(); }
};

/// errors: InputError for a cell that one session answered twice.
ResponseMatrix make_response_matrix(const std::vector<AnswerRow>& answers);

/// Counts where each subject counts `weights` times. shape: one for each cell.
std::vector<Count> count_weighted(const ResponseMatrix& matrix, const std::vector<std::uint32_t>& weights);

}  // namespace equilux
