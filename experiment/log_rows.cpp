// Each row has one place where its columns are named to be written, and one where they are read.
#include "experiment/log_rows.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "base/digest.h"
#include "base/error.h"
#include "base/program.h"
#include "experiment/log_schema.h"

namespace equilux {
namespace {

constexpr char kStationEnd = ':';  // what was exported at another station is STATION:PATH

Side parse_side(std::string_view text, const std::string& source) {
  if (text != "left" && text != "right")
    throw InputError(source, "trial", "left or right", std::string(text));
  return text == "left" ? Side::kLeft : Side::kRight;
}

std::int64_t insert_participant(const Database& database, const std::string& code) {
  Statement(database, "INSERT INTO participant (code) VALUES (?) ON CONFLICT DO NOTHING", code).run();
  Statement statement(database, "SELECT id FROM participant WHERE code = ?", code);
  EQ_CHECK(statement.step(), code);
  return statement.integer(0);
}

Phase parse_phase(std::string_view text, const std::string& source) {
  for (const Phase phase : {Phase::kPractice, Phase::kMain, Phase::kCatch}) {
    if (text == format_phase(phase)) return phase;
  }
  throw InputError(source, "trial/phase", "practice, main or catch", std::string(text));
}

template <typename T, typename Get>
std::optional<T> value_unless_null(const Statement& statement, int column, const Get& get) {
  return statement.is_null(column) ? std::nullopt : std::optional<T>(static_cast<T>(get(column)));
}

// No program measures an infinity, and no file that is made from a log can hold one.
std::optional<double> read_measure(const Statement& row, int column, const std::string& source,
                                   const char* name) {
  if (row.is_null(column)) return std::nullopt;
  const double value = row.real(column);
  if (!std::isfinite(value))
    throw InputError(source, fmt::format("session {}: {}", row.integer(0), name), "a finite number",
                     fmt::format("{}; {}", value, kDamageAdvice));
  return value;
}

SessionRow read_session(const Statement& row, const std::string& source) {
  const auto integer = [&](int column) { return row.integer(column); };
  SessionRow session;
  session.id = row.integer(0);
  session.participant = row.text(1);
  session.kind = parse_kind(row.text(2), source, "session/kind");
  session.experiment = parse_experiment(row.text(3), source, "session/experiment");
  session.subject_index = row.integer(4);
  session.seed = static_cast<std::uint64_t>(row.integer(5));
  session.program_version = row.text(6);
  session.digests = {row.text(7), row.text(8), row.text(9), row.text(10), row.text(11), row.text(12)};
  session.screen = {row.text(13),
                    value_unless_null<int>(row, 14, integer),
                    value_unless_null<int>(row, 15, integer),
                    read_measure(row, 16, source, "viewing_distance_m"),
                    read_measure(row, 17, source, "degrees_wide"),
                    read_measure(row, 18, source, "degrees_high")};
  session.started_utc = row.text(19);
  session.complete = row.integer(20) != 0;
  session.uuid = row.text(21);
  session.station = row.text(22);
  return session;
}

// A number of a damaged log may be any of 64 bits: cut to 32 it would be that of another trial.
int read_trial_number(const Statement& row, const std::string& source, std::int64_t session) {
  const std::int64_t number = row.integer(0);
  if (number < 0 || number > std::numeric_limits<int>::max()) {
    throw InputError(source, fmt::format("session {}, trial {}: trial", session, number), kTrialNumber,
                     fmt::format("{}; {}", number, kDamageAdvice));
  }
  return static_cast<int>(number);
}

TrialRow read_trial(const Statement& row, const std::string& source, std::int64_t session) {
  TrialRow trial;
  trial.number = read_trial_number(row, source, session);
  trial.phase = parse_phase(row.text(1), source);
  trial.cell = parse_cell(row.text(2), source, "trial/cell");
  trial.test_key = row.text(3);
  trial.pair_key = row.text(4);
  trial.upper_key = row.text(5);
  trial.test_side = parse_side(row.text(6), source);
  if (row.is_null(7)) return trial;
  trial.answer = parse_side(row.text(7), source);
  trial.response_time_ns = row.integer(8);
  trial.answered_utc = row.text(9);
  trial.too_fast = row.integer(10) != 0;
  return trial;
}

// Of all sessions, in their order: a question for each would be prepared as often as a log has sessions. Of
// the table itself, since its index may lack a row.
void load_fields(const Database& database, std::vector<SessionRow>& sessions) {
  Statement row(database, "SELECT session, name, value FROM field NOT INDEXED ORDER BY session");
  auto session = sessions.begin();
  while (row.step()) {
    while (session != sessions.end() && session->id < row.integer(0)) ++session;
    if (session == sessions.end()) return;
    if (session->id == row.integer(0)) session->fields[row.text(1)] = row.text(2);
  }
}

// A path is absolute, so that no station is mistaken for the beginning of one.
ExportRow read_export(const std::string& place, const std::string& made_utc) {
  const std::size_t end = place.starts_with('/') ? std::string::npos : place.find(kStationEnd);
  if (end == std::string::npos) return {place, made_utc};
  return {place.substr(end + 1), made_utc, place.substr(0, end)};
}

}  // namespace

Tombstone make_tombstone(const std::string& code) {
  const std::string salt = draw_identity();
  return {salt, digest_text(salt + code), format_utc_now()};
}

bool is_of(const Tombstone& tombstone, const std::string& code) {
  return digest_text(tombstone.salt + code) == tombstone.digest;
}

std::optional<Tombstone> find_tombstone(const std::vector<Tombstone>& tombstones, const std::string& code) {
  for (const Tombstone& tombstone : tombstones) {
    if (is_of(tombstone, code)) return tombstone;
  }
  return std::nullopt;
}

std::string format_side(Side side) { return side == Side::kLeft ? "left" : "right"; }

std::string load_station(const Database& database) {
  Statement statement(database, "SELECT station FROM log");
  if (!statement.step()) throw InputError(database.name(), "log", "a row that names the station", "none");
  return statement.text(0);
}

std::vector<SessionRow> load_sessions(const Database& database) {
  Statement statement(
      database,
      "SELECT session.id, code, kind, experiment, subject_index, seed, program_version,"
      " study_digest, manifest_digest, windows_digest, selection_digest, truth_digest,"
      " protocol_digest, monitor, framebuffer_width, framebuffer_height, viewing_distance_m, degrees_wide,"
      " degrees_high, started_utc, complete, uuid, station"
      " FROM session JOIN participant ON participant.id = participant ORDER BY session.id");
  std::vector<SessionRow> sessions;
  while (statement.step()) sessions.push_back(read_session(statement, database.name()));
  load_fields(database, sessions);
  return sessions;
}

std::vector<TrialRow> load_trials(const Database& database, std::int64_t session) {
  Statement statement(database,
                      "SELECT trial, phase, cell, test_key, pair_key, upper_key, test_side, answer,"
                      " response_time_ns, answered_utc, too_fast FROM trial WHERE session = ? ORDER BY trial",
                      session);
  std::vector<TrialRow> trials;
  while (statement.step()) trials.push_back(read_trial(statement, database.name(), session));
  check_numbers(database.name(), session, trials);
  return trials;
}

std::vector<EventRow> load_events(const Database& database, std::int64_t session) {
  Statement row(database,
                "SELECT trial, kind, time_ns, recorded_utc, detail FROM event WHERE session = ? ORDER BY id",
                session);
  std::vector<EventRow> events;
  while (row.step()) {
    const auto trial =
        row.is_null(0) ? std::nullopt : std::optional(read_trial_number(row, database.name(), session));
    events.push_back({trial, row.text(1), row.integer(2), row.text(3), row.text(4)});
  }
  return events;
}

std::vector<Tombstone> load_tombstones(const Database& database) {
  Statement row(database, "SELECT salt, digest, withdrawn_utc FROM tombstone ORDER BY withdrawn_utc, salt");
  std::vector<Tombstone> tombstones;
  while (row.step()) tombstones.push_back({row.text(0), row.text(1), row.text(2)});
  return tombstones;
}

std::vector<ExportRow> load_exports(const Database& database) {
  Statement row(database, "SELECT path, max(made_utc) FROM export GROUP BY path ORDER BY path");
  std::vector<ExportRow> exports;
  while (row.step()) exports.push_back(read_export(row.text(0), row.text(1)));
  return exports;
}

std::int64_t insert_session(const Database& database, const SessionRow& row) {
  const std::int64_t participant = insert_participant(database, row.participant);
  Statement(database,
            "INSERT INTO session (uuid, station, participant, kind, experiment, subject_index, seed, "
            "program_version,"
            " study_digest, manifest_digest, windows_digest, selection_digest, truth_digest, protocol_digest,"
            " monitor, framebuffer_width, framebuffer_height, viewing_distance_m, degrees_wide, degrees_high,"
            " started_utc, complete) VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)",
            row.uuid, row.station, participant, format_kind(row.kind), format_experiment(row.experiment),
            row.subject_index, static_cast<std::int64_t>(row.seed), row.program_version, row.digests.study,
            row.digests.manifest, row.digests.windows, row.digests.selection, row.digests.truth,
            row.digests.protocol, row.screen.monitor, row.screen.framebuffer_width,
            row.screen.framebuffer_height, row.screen.viewing_distance_m, row.screen.degrees_wide,
            row.screen.degrees_high, row.started_utc, row.complete)
      .run();
  const std::int64_t session = database.last_row_id();
  for (const auto& [name, value] : row.fields) insert_field(database, session, name, value);
  return session;
}

void insert_trial(const Database& database, std::int64_t session, const TrialRow& trial) {
  const auto answer = trial.answer ? std::optional(format_side(*trial.answer)) : std::nullopt;
  Statement(
      database,
      "INSERT INTO trial (session, trial, phase, cell, test_key, pair_key, upper_key, test_side, answer,"
      " response_time_ns, answered_utc, too_fast) VALUES (?,?,?,?,?,?,?,?,?,?,?,?)",
      session, trial.number, format_phase(trial.phase), format_key(trial.cell), trial.test_key,
      trial.pair_key, trial.upper_key, format_side(trial.test_side), answer, trial.response_time_ns,
      trial.answered_utc, trial.too_fast)
      .run();
}

void insert_event(const Database& database, std::int64_t session, const EventRow& event) {
  Statement(database,
            "INSERT INTO event (session, trial, kind, time_ns, recorded_utc, detail) VALUES (?,?,?,?,?,?)",
            session, event.trial, event.kind, event.time_ns, event.recorded_utc, event.detail)
      .run();
}

void insert_field(const Database& database, std::int64_t session, const std::string& name,
                  const std::string& value) {
  Statement(database, "INSERT INTO field (session, name, value) VALUES (?,?,?)", session, name, value).run();
}

void insert_export(const Database& database, const ExportRow& row) {
  const std::string place = row.station.empty() ? row.path : row.station + kStationEnd + row.path;
  Statement(database, "INSERT INTO export (path, made_utc) VALUES (?,?)", place, row.made_utc).run();
}

void insert_tombstone(const Database& database, const Tombstone& tombstone) {
  Statement(database, "INSERT INTO tombstone VALUES (?,?,?) ON CONFLICT DO NOTHING", tombstone.salt,
            tombstone.digest, tombstone.withdrawn_utc)
      .run();
}

}  // namespace equilux
