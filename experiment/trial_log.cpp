// Every answer is on the disk before the next pair is on the screen.
#include "experiment/trial_log.h"

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "base/program.h"
#include "experiment/database.h"
#include "experiment/intake.h"
#include "experiment/log_rows.h"
#include "experiment/log_schema.h"

namespace equilux {

namespace {
namespace fs = std::filesystem;

void insert_event_now(const Database& database, std::int64_t session, std::optional<int> trial,
                      const std::string& kind, std::int64_t time_ns, const std::string& detail = "") {
  insert_event(database, session, {trial, kind, time_ns, format_utc_now(), detail});
}

void check_not_withdrawn(const Database& database, const std::string& code) {
  const std::vector<Tombstone> tombstones = load_tombstones(database);
  for (const std::string& spelling : list_spellings(code)) {
    const auto tombstone = find_tombstone(tombstones, spelling);
    if (!tombstone) continue;
    throw InputError(database.name(), "participant/code", "the code of somebody who has not withdrawn",
                     fmt::format("{}, withdrawn on {}", spelling, tombstone->withdrawn_utc.substr(0, 10)));
  }
}

void check_can_begin(const Database& database, const SessionRow& row) {
  if (row.seed > static_cast<std::uint64_t>(INT64_MAX)) {
    throw InputError(database.name(), "session/seed", "a seed below 2^63", fmt::format("{}", row.seed));
  }
  if (row.participant.empty()) {
    throw InputError(database.name(), "participant/code", "a code", "an empty text");
  }
  check_not_withdrawn(database, row.participant);
  Statement holder(database, "SELECT id FROM session WHERE kind = ? AND experiment = ? AND subject_index = ?",
                   format_kind(row.kind), format_experiment(row.experiment), row.subject_index);
  if (holder.step()) {
    throw InputError(database.name(), "session/subject_index", "an index that no session of its kind holds",
                     fmt::format("{}, which session {} holds", row.subject_index, holder.integer(0)));
  }
}

// A hundred logs of a study have the same cells.
CellReader& known_cells() {
  thread_local CellReader cells;
  return cells;
}

// The detail of the last event of this kind after which nothing went on.
std::optional<std::string> find_last_end(const std::vector<EventRow>& events, const std::string& kind) {
  std::optional<std::string> reason;
  for (const EventRow& event : events) {
    if (event.kind == kind) reason = event.detail;
    if (event.kind == "resume" || event.kind == "showing" || event.kind == "answer") reason.reset();
  }
  return reason;
}

}  // namespace

std::string format_phase(Phase phase) {
  switch (phase) {
    case Phase::kPractice:
      return "practice";
    case Phase::kCatch:
      return "catch";
    default:
      return "main";
  }
}

struct TrialLog::Impl {
  Database database;
};

TrialLog::TrialLog(const fs::path& path, bool create)
    : impl_(std::make_unique<Impl>(Impl{open_log(path, create)})) {}
TrialLog::TrialLog(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

bool TrialLog::is_at(const fs::path& path) { return has_log(path); }

TrialLog TrialLog::load_snapshot(const fs::path& path, LogCheck check) {
  return TrialLog(std::make_unique<Impl>(Impl{open_log_snapshot(path, check)}));
}

TrialLog::~TrialLog() = default;
TrialLog::TrialLog(TrialLog&&) noexcept = default;
TrialLog& TrialLog::operator=(TrialLog&&) noexcept = default;

std::int64_t TrialLog::append_session(const SessionRow& asked, const std::vector<TrialRow>& trials) {
  Transaction transaction(impl_->database);
  SessionRow row = asked;
  row.station = equilux::load_station(impl_->database);
  row.complete = false;
  if (row.uuid.empty()) row.uuid = draw_identity();
  check_can_begin(impl_->database, row);
  const std::int64_t session = insert_session(impl_->database, row);
  for (const TrialRow& trial : trials) insert_trial(impl_->database, session, trial);
  transaction.commit();
  empty_wal();
  return session;
}

std::vector<SessionRow> TrialLog::load_sessions() const { return equilux::load_sessions(impl_->database); }

std::vector<TrialRow> TrialLog::load_trials(std::int64_t session) const {
  return equilux::load_trials(impl_->database, session);
}

BriefTrials TrialLog::load_brief_trials() const {
  return equilux::load_brief_trials(impl_->database, known_cells());
}

std::vector<EventRow> TrialLog::load_events(std::int64_t session) const {
  return equilux::load_events(impl_->database, session);
}

std::int64_t TrialLog::find_free_index(SubjectKind kind, Experiment experiment, const Lane& lane) const {
  EQ_CHECK(lane.first >= 0 && lane.step >= 1, lane.first, lane.step);
  Statement statement(impl_->database,
                      "SELECT subject_index FROM session WHERE kind = ? AND experiment = ?"
                      " AND subject_index >= ? AND (subject_index - ?) % ? = 0 ORDER BY subject_index",
                      format_kind(kind), format_experiment(experiment), lane.first, lane.first, lane.step);
  std::int64_t free = lane.first;
  while (statement.step() && statement.integer(0) <= free)
    free = std::max(free, statement.integer(0) + lane.step);
  return free;
}

bool TrialLog::has_session_using_selection(const std::string& selection_digest) const {
  return Statement(impl_->database, "SELECT 1 FROM session WHERE selection_digest = ?", selection_digest)
      .step();
}

void TrialLog::append_showing(std::int64_t session, int trial, std::int64_t time_ns) {
  Transaction transaction(impl_->database);
  insert_event_now(impl_->database, session, trial, "showing", time_ns);
  transaction.commit();
}

void TrialLog::append_answer(std::int64_t session, const Answer& answer, std::optional<int> next_trial,
                             std::int64_t time_ns) {
  Transaction transaction(impl_->database);
  const int filled =
      Statement(impl_->database,
                "UPDATE trial SET answer = ?, response_time_ns = ?, answered_utc = ?, too_fast = ?"
                " WHERE session = ? AND trial = ? AND answer IS NULL",
                format_side(answer.side), answer.response_time_ns, format_utc_now(), answer.too_fast, session,
                answer.trial)
          .run();
  if (filled != 1) {
    impl_->database.fail_store(
        fmt::format("trial {} of session {} does not wait for an answer", answer.trial, session));
  }
  insert_event_now(impl_->database, session, answer.trial, "answer", time_ns);
  if (next_trial) insert_event_now(impl_->database, session, next_trial, "showing", time_ns);
  transaction.commit();
}

void TrialLog::append_event(std::int64_t session, const std::string& kind, std::int64_t time_ns,
                            const std::string& detail) {
  Transaction transaction(impl_->database);
  insert_event_now(impl_->database, session, std::nullopt, kind, time_ns, detail);
  transaction.commit();
}

void TrialLog::append_field(std::int64_t session, const std::string& name, const std::string& value) {
  Transaction transaction(impl_->database);
  insert_field(impl_->database, session, name, value);
  transaction.commit();
}

void TrialLog::finish_session(std::int64_t session, std::int64_t time_ns) {
  Transaction transaction(impl_->database);
  const int finished =
      Statement(impl_->database,
                "UPDATE session SET complete = 1 WHERE id = ? AND complete = 0 AND NOT EXISTS"
                " (SELECT 1 FROM trial WHERE trial.session = session.id AND answer IS NULL)",
                session)
          .run();
  if (finished != 1) {
    impl_->database.fail_store(
        fmt::format("session {} cannot be finished: a trial waits for an answer, it is finished already, or"
                    " there is none of that number",
                    session));
  }
  insert_event_now(impl_->database, session, std::nullopt, "finish", time_ns);
  transaction.commit();
}

void TrialLog::empty_wal() const { impl_->database.empty_wal(); }

std::vector<AnswerRow> TrialLog::load_answers(SubjectKind kind, Experiment experiment) const {
  Statement statement(
      impl_->database,
      "SELECT session, subject_index, cell, answer = test_side FROM trial"
      " JOIN session ON session.id = session"
      " WHERE kind = ? AND experiment = ? AND complete = 1 AND phase = 'main' AND answer IS NOT NULL"
      " ORDER BY session, trial",
      format_kind(kind), format_experiment(experiment));
  std::vector<AnswerRow> answers;
  while (statement.step()) {
    answers.push_back({statement.integer(0), statement.integer(1),
                       known_cells().read(statement.view(2), impl_->database.name(), "trial/cell"),
                       statement.integer(3) != 0});
  }
  return answers;
}

std::int64_t TrialLog::count_withdrawn() const {
  return load_integer(impl_->database, "SELECT count(DISTINCT salt) FROM tombstone");
}

void TrialLog::check_not_withdrawn(const std::string& code) const {
  equilux::check_not_withdrawn(impl_->database, code);
}

bool TrialLog::has_withdrawn(const std::string& code) const {
  return find_tombstone(load_tombstones(impl_->database), code).has_value();
}

void TrialLog::append_export(const std::string& path) {
  Transaction transaction(impl_->database);
  insert_export(impl_->database, {path, format_utc_now()});
  transaction.commit();
}

std::vector<ExportRow> TrialLog::load_exports() const { return equilux::load_exports(impl_->database); }

std::string TrialLog::load_station() const { return equilux::load_station(impl_->database); }

std::string TrialLog::load_setting(const std::string& name) const {
  return read_setting(impl_->database, name);
}

std::optional<std::string> find_abort_reason(const std::vector<EventRow>& events) {
  return find_last_end(events, "abort");
}

std::optional<std::string> find_interruption(const std::vector<EventRow>& events) {
  return find_last_end(events, "interrupt");
}

}  // namespace equilux
