// Rows of a log, written and read on an open database: what TrialLog and the merging of logs share.
#pragma once

#include <cstdint>
#include <fmt/format.h>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "experiment/database.h"
#include "experiment/trial_log.h"
#include "protocols/cell_numbers.h"

namespace equilux {

/// That a participant withdrew; who it was can be asked of a known code alone.
struct Tombstone {
  std::string salt;    ///< random
  std::string digest;  ///< of salt and code
  std::string withdrawn_utc;
  bool operator==(const Tombstone&) const = default;
};

Tombstone make_tombstone(const std::string& code);
bool is_of(const Tombstone& tombstone, const std::string& code);
/// The tombstone of a code, if its participant withdrew; of small or capital letters only as it stands there.
std::optional<Tombstone> find_tombstone(const std::vector<Tombstone>& tombstones, const std::string& code);

/// What the number of a trial is.
inline constexpr const char* kTrialNumber = "its place in the order of showing: 0, 1, ...";

/// Of a session's trials, sorted. errors: InputError where one of them is not there
template <typename Trial>
void check_numbers(const std::string& source, std::int64_t session, const std::vector<Trial>& trials) {
  for (std::size_t i = 0; i < trials.size(); ++i) {
    if (trials[i].number == static_cast<int>(i)) continue;
    throw InputError(source, fmt::format("session {}", session), fmt::format("its trial {}", i),
                     fmt::format("none: the next is {}", trials[i].number));
  }
}

std::string load_station(const Database& database);
std::vector<SessionRow> load_sessions(const Database& database);
std::vector<TrialRow> load_trials(const Database& database, std::int64_t session);
/// Of all sessions, see TrialLog::load_brief_trials.
BriefTrials load_brief_trials(const Database& database, CellReader& cells);
std::vector<EventRow> load_events(const Database& database, std::int64_t session);
std::vector<Tombstone> load_tombstones(const Database& database);
std::vector<ExportRow> load_exports(const Database& database);  ///< each path of a station once, sorted

// Within the caller's transaction. errors: StoreError
/// Participant, session and fields; `row.id` is ignored. Gives the session's id.
std::int64_t insert_session(const Database& database, const SessionRow& row);
void insert_trial(const Database& database, std::int64_t session, const TrialRow& trial);
void insert_event(const Database& database, std::int64_t session, const EventRow& event);
void insert_field(const Database& database, std::int64_t session, const std::string& name,
                  const std::string& value);
/// One that is there already is left as it is.
void insert_tombstone(const Database& database, const Tombstone& tombstone);

void insert_export(const Database& database, const ExportRow& row);

std::string format_side(Side side);

}  // namespace equilux
