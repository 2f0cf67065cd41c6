// Rows of answers to a dense matrix, and its weighted column sums.
#include "analysis/response_matrix.h"

#include <algorithm>
#include <limits>
#include <map>
#include <numeric>

#include "base/error.h"

namespace equilux {
namespace {

template <typename T>
void sort_once(std::vector<T>& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

template <typename T>
std::size_t place_of(const std::vector<T>& sorted, const T& value) {
  return static_cast<std::size_t>(std::lower_bound(sorted.begin(), sorted.end(), value) - sorted.begin());
}

// Those with answers, sorted.
std::vector<Cell> find_cells(const Answers& answers) {
  std::vector<char> is_tested(answers.cells().size(), 0);
  for (const CountedAnswer& answer : answers.rows()) is_tested[answer.cell] = 1;
  std::vector<Cell> cells;
  for (std::size_t cell = 0; cell < is_tested.size(); ++cell) {
    if (is_tested[cell]) cells.push_back(answers.cells()[cell]);
  }
  std::sort(cells.begin(), cells.end());
  return cells;
}

void fill(ResponseMatrix& matrix, const Answers& answers) {
  const std::size_t width = matrix.cells.size();
  std::vector<std::size_t> places;
  for (const Cell& cell : answers.cells()) places.push_back(place_of(matrix.cells, cell));
  matrix.asked.assign(matrix.subjects() * width, 0);
  matrix.correct.assign(matrix.subjects() * width, 0);
  std::size_t row = 0;
  for (const CountedAnswer& answer : answers.rows()) {
    if (matrix.sessions[row] != answer.session) row = place_of(matrix.sessions, answer.session);
    const std::size_t at = row * width + places[answer.cell];
    if (matrix.asked[at]) {
      throw InputError("answers", fmt::format("session {}", answer.session), "one answer to each cell",
                       format_key(answers.cell_of(answer)) + " twice");
    }
    matrix.asked[at] = 1;
    matrix.correct[at] = answer.correct ? 1 : 0;
  }
}

// Rows by what they hold; subjects who answered alike are interchangeable.
void sort_rows(ResponseMatrix& matrix) {
  const std::size_t width = matrix.cells.size();
  const auto row = [&](auto& values, std::size_t s) {
    return values.begin() + static_cast<std::ptrdiff_t>(s * width);
  };
  std::vector<std::size_t> order(matrix.subjects());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const auto asked = std::lexicographical_compare_three_way(row(matrix.asked, a), row(matrix.asked, a + 1),
                                                              row(matrix.asked, b), row(matrix.asked, b + 1));
    if (asked != 0) return asked < 0;
    return std::lexicographical_compare(row(matrix.correct, a), row(matrix.correct, a + 1),
                                        row(matrix.correct, b), row(matrix.correct, b + 1));
  });
  const ResponseMatrix before = matrix;
  for (std::size_t s = 0; s < order.size(); ++s) {
    matrix.sessions[s] = before.sessions[order[s]];
    matrix.persons[s] = before.persons[order[s]];
    std::copy_n(row(before.asked, order[s]), width, row(matrix.asked, s));
    std::copy_n(row(before.correct, order[s]), width, row(matrix.correct, s));
  }
}

// The row of a subject of this code, made where there is none.
std::size_t find_row(ResponseMatrix& matrix, std::map<std::string, std::size_t>& rows,
                     const std::string& code, std::int64_t session) {
  const auto known = code.empty() ? rows.end() : rows.find(code);
  if (known != rows.end()) {
    matrix.sessions[known->second] = std::min(matrix.sessions[known->second], session);
    return known->second;
  }
  const std::size_t row = matrix.subjects();
  if (!code.empty()) rows[code] = row;
  matrix.sessions.push_back(session);
  matrix.persons.push_back(code);
  matrix.asked.resize(matrix.subjects() * matrix.cells.size(), 0);
  matrix.correct.resize(matrix.subjects() * matrix.cells.size(), 0);
  return row;
}

void add_to(std::uint16_t& sum, std::uint16_t more, const std::string& code) {
  constexpr int kMost = std::numeric_limits<std::uint16_t>::max();
  if (sum + more > kMost)
    throw InputError("answers", code, fmt::format("at most {} sessions of a participant", kMost), "more");
  sum = static_cast<std::uint16_t>(sum + more);
}

}  // namespace

ResponseMatrix make_response_matrix(const Answers& answers) {
  ResponseMatrix matrix;
  matrix.cells = find_cells(answers);
  for (const CountedAnswer& answer : answers.rows()) {
    if (matrix.sessions.empty() || matrix.sessions.back() != answer.session)
      matrix.sessions.push_back(answer.session);
  }
  sort_once(matrix.sessions);
  matrix.persons.resize(matrix.subjects());
  fill(matrix, answers);
  sort_rows(matrix);
  return matrix;
}

ResponseMatrix group_by_person(const ResponseMatrix& sessions,
                               const std::map<std::int64_t, std::string>& codes) {
  const std::size_t width = sessions.cells.size();
  ResponseMatrix grouped;
  grouped.cells = sessions.cells;
  std::map<std::string, std::size_t> rows;
  for (std::size_t s = 0; s < sessions.subjects(); ++s) {
    const auto code = codes.find(sessions.sessions[s]);
    const std::string name = code == codes.end() ? "" : code->second;
    const std::size_t row = find_row(grouped, rows, name, sessions.sessions[s]);
    for (std::size_t c = 0; c < width; ++c) {
      add_to(grouped.asked[row * width + c], sessions.asked[s * width + c], name);
      add_to(grouped.correct[row * width + c], sessions.correct[s * width + c], name);
    }
  }
  sort_rows(grouped);
  return grouped;
}

std::vector<Count> count_weighted(const ResponseMatrix& matrix, const std::vector<std::uint32_t>& weights) {
  const std::size_t width = matrix.cells.size();
  EQ_CHECK(weights.size() == matrix.subjects(), weights.size(), matrix.subjects());
  std::vector<std::uint32_t> asked(width, 0), correct(width, 0);
  for (std::size_t s = 0; s < weights.size(); ++s) {
    const std::uint32_t weight = weights[s];
    if (weight == 0) continue;
    const std::uint16_t* asked_row = matrix.asked.data() + s * width;
    const std::uint16_t* correct_row = matrix.correct.data() + s * width;
    for (std::size_t c = 0; c < width; ++c) asked[c] += weight * asked_row[c];
    for (std::size_t c = 0; c < width; ++c) correct[c] += weight * correct_row[c];
  }
  std::vector<Count> counts(width);
  for (std::size_t c = 0; c < width; ++c) counts[c] = {correct[c], asked[c]};
  return counts;
}

}  // namespace equilux
