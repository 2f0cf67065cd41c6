// Who took part and before what screens, as counts and ranges over the finished sessions of an experiment.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>

#include "analysis/evidence.h"
#include "base/json.h"

namespace equilux {

struct ValueRange {
  double least = 0;
  double greatest = 0;
  std::size_t sessions = 0;  ///< that recorded it
};

/// Of fewer sessions what was asked of a person is not told: beside the codes of `subjects.csv` it would be.
inline constexpr std::size_t kFewestTold = 5;

/// Nothing of a single participant: no codes, and no two things that were asked are crossed.
struct Participation {
  std::size_t sessions = 0;
  std::string first_day;  ///< UTC, ISO 8601; empty without sessions
  std::string last_day;
  /// Sessions by value, a value of those that did not record it being "". shape: by name as in the log
  /// (age_band, acuity, colour_vision, ambient_light, monitor, framebuffer, ...); without the first three of
  /// fewer than kFewestTold sessions.
  std::map<std::string, std::map<std::string, std::size_t>> counts;
  /// shape: by name as in the log; what no session recorded is left out. units: as in docs/responses.md
  std::map<std::string, ValueRange> ranges;
};

Participation find_participation(const ExperimentEvidence& evidence);

/// Participants, by their codes, with a finished session of both experiments.
std::size_t count_in_both(const Evidence& evidence);

/// Different codes of the finished sessions; those without a code are not counted.
std::size_t count_participants(const ExperimentEvidence& evidence);

Json make_participation_json(const Participation& participation);

}  // namespace equilux
