// Combinations of sessions to counts, counts to their spread.
#include "analysis/balance.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <unordered_map>
#include <vector>

#include "base/error.h"

namespace equilux {
namespace {

using ComboCounts = std::array<std::int64_t, kComboCount>;

void add_counts(Spread& spread, const ComboCounts& counts) {
  const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
  const std::int64_t difference = *most - *least;
  ++spread.measured;
  spread.largest = std::max(spread.largest, difference);
  spread.over += difference > kBalanceAllows ? 1 : 0;
}

// The combinations of a session and how many of its trials were read.
struct SessionReading {
  const std::vector<std::uint8_t>* combos = nullptr;
  std::size_t read = 0;

  // Of the next trial that was answered: the others have no answer in the list.
  std::uint8_t next(std::int64_t session) {
    while (read < combos->size() && (*combos)[read] >= kUnansweredCombo) ++read;
    EQ_CHECK(read < combos->size(), read, session);
    return (*combos)[read++];
  }
};

using SessionReadings = std::unordered_map<std::int64_t, SessionReading>;

SessionReadings find_readings(const ExperimentEvidence& evidence) {
  SessionReadings readings;
  for (const SessionSummary& summary : evidence.summaries) {
    if (summary.complete && !summary.combos.empty()) readings[summary.session] = {&summary.combos, 0};
  }
  return readings;
}

Spread measure_sessions(const SessionReadings& readings) {
  Spread spread;
  for (const auto& [session, reading] : readings) {
    ComboCounts counts{};
    for (const std::uint8_t combo : *reading.combos) ++counts.at(combo % kUnansweredCombo);
    add_counts(spread, counts);
  }
  return spread;
}

// Answers stand in the order of their trials within a session.
Spread measure_cells(const ExperimentEvidence& evidence, SessionReadings readings) {
  const Answers& answers = evidence.answers;
  std::vector<ComboCounts> counts(answers.cells().size(), ComboCounts{});
  auto found = readings.end();
  std::optional<std::int64_t> session;
  for (const CountedAnswer& answer : answers.rows()) {
    if (session != answer.session) found = readings.find(*(session = answer.session));
    if (found != readings.end()) ++counts[answer.cell].at(found->second.next(answer.session));
  }
  Spread spread;
  for (const ComboCounts& of_cell : counts) {
    if (of_cell != ComboCounts{}) add_counts(spread, of_cell);
  }
  return spread;
}

// A number for each code, the same for all its sessions. shape: by session
std::unordered_map<std::int64_t, std::size_t> number_persons(const ExperimentEvidence& evidence,
                                                             std::size_t& persons) {
  std::map<std::string, std::size_t> codes;
  std::unordered_map<std::int64_t, std::size_t> numbers;
  for (const SessionRow& row : evidence.finished) {
    const auto [entry, is_new] = codes.try_emplace(row.participant, persons);
    numbers[row.id] = row.participant.empty() || is_new ? persons++ : entry->second;
  }
  return numbers;
}

std::int64_t count_most_answers(const ExperimentEvidence& evidence) {
  std::size_t persons = 0;
  const auto numbers = number_persons(evidence, persons);
  const std::size_t cells = evidence.answers.cells().size();
  std::vector<std::int64_t> answers(persons * cells, 0);  // by person, then by cell
  std::int64_t most = 0;
  auto person = numbers.end();
  std::optional<std::int64_t> session;
  for (const CountedAnswer& answer : evidence.answers.rows()) {
    if (session != answer.session) person = numbers.find(*(session = answer.session));
    if (person == numbers.end()) continue;
    most = std::max(most, ++answers[person->second * cells + answer.cell]);
  }
  return most;
}

}  // namespace

Balance find_balance(const ExperimentEvidence& evidence) {
  const SessionReadings readings = find_readings(evidence);
  return {measure_sessions(readings), measure_cells(evidence, readings), count_most_answers(evidence)};
}

}  // namespace equilux
