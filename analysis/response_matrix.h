// The answers of one experiment as a matrix of subjects by cells: what resampling subjects works on.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "analysis/tally.h"

namespace equilux {

/// Subjects stand in the order of their answers' content, so that the matrix does not depend on the order of
/// rows, of subjects or of files, nor on what subjects are called.
struct ResponseMatrix {
  std::vector<Cell> cells;  ///< tested ones, sorted
  std::vector<std::int64_t>
      sessions;                      ///< AnswerRow::session of each subject; of a person's several the first
  std::vector<std::string> persons;  ///< code of each subject; empty where it is not known
  /// shape: subjects x cells, row by row. How often the subject was asked, and how often it was correct: 0 or
  /// 1 in a session. Narrow, since resampling reads all of it again and again.
  std::vector<std::uint16_t> asked;
  std::vector<std::uint16_t> correct;

  std::size_t subjects() const { return sessions.size(); }
};

/// A subject for each session. errors: InputError for a cell that one session answered twice.
ResponseMatrix make_response_matrix(const Answers& answers);

/// A subject for each person: sessions of one code, as pooled logs may have them, are added up, since they
/// are not independent. `codes` names sessions; one without a code is a person of its own. errors: InputError
/// for a code that answered a cell more than 65,535 times.
ResponseMatrix group_by_person(const ResponseMatrix& sessions,
                               const std::map<std::int64_t, std::string>& codes);

/// Counts where each subject counts `weights` times. shape: one for each cell.
std::vector<Count> count_weighted(const ResponseMatrix& matrix, const std::vector<std::uint32_t>& weights);

}  // namespace equilux
