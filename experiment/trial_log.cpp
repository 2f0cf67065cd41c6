// Every answer is on the disk before the next pair is on the screen.
#include "experiment/trial_log.h"

#include <algorithm>
#include <utility>

#include "base/digest.h"
#include "base/error.h"
#include "base/program.h"
#include "experiment/database.h"
#include "experiment/log_schema.h"

namespace equilux {

namespace {
namespace fs = std::filesystem;

std::string format_side(Side side) { return side == Side::kLeft ? "left" : "right"; }

Side parse_side(const std::string& text, const std::string& source) {
  if (text != "left" && text != "right") throw InputError(source, "trial", "left or right", text);
  return text == "left" ? Side::kLeft : Side::kRight;
}

void insert_event(const Database& database, std::int64_t session, std::optional<int> trial,
                  const std::string& kind, std::int64_t time_ns, const std::string& detail = "") {
  Statement(database,
            "INSERT INTO event (session, trial, kind, time_ns, recorded_utc, detail) VALUES (?,?,?,?,?,?)",
            session, trial, kind, time_ns, format_utc_now(), detail)
      .run();
}

std::int64_t insert_participant(const Database& database, const std::string& code) {
  Statement(database, "INSERT INTO participant (code) VALUES (?) ON CONFLICT DO NOTHING", code).run();
  Statement statement(database, "SELECT id FROM participant WHERE code = ?", code);
  EQ_CHECK(statement.step(), code);
  return statement.integer(0);
}

void insert_field(const Database& database, std::int64_t session, const std::string& name,
                  const std::string& value) {
  Statement(database, "INSERT INTO field (session, name, value) VALUES (?,?,?)", session, name, value).run();
}

std::int64_t insert_session(const Database& database, const SessionRow& row) {
  const std::int64_t participant = insert_participant(database, row.participant);
  Statement(database,
            "INSERT INTO session (uuid, station, participant, kind, experiment, subject_index, seed, "
            "program_version,"
            " study_digest, manifest_digest, windows_digest, selection_digest, truth_digest, protocol_digest,"
            " monitor, framebuffer_width, framebuffer_height, viewing_distance_m, degrees_wide, degrees_high,"
            " started_utc) VALUES (?,(SELECT station FROM log),?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)",
            row.uuid.empty() ? draw_identity() : row.uuid, participant, format_kind(row.kind),
            format_experiment(row.experiment), row.subject_index, static_cast<std::int64_t>(row.seed),
            row.program_version, row.digests.study, row.digests.manifest, row.digests.windows,
            row.digests.selection, row.digests.truth, row.digests.protocol, row.screen.monitor,
            row.screen.framebuffer_width, row.screen.framebuffer_height, row.screen.viewing_distance_m,
            row.screen.degrees_wide, row.screen.degrees_high, row.started_utc)
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

void check_can_begin(const Database& database, const SessionRow& row) {
  if (row.seed > static_cast<std::uint64_t>(INT64_MAX)) {
    throw InputError(database.name(), "session/seed", "a seed below 2^63", fmt::format("{}", row.seed));
  }
  if (row.participant.empty()) {
    throw InputError(database.name(), "participant/code", "a code", "an empty text");
  }
  Statement holder(database, "SELECT id FROM session WHERE kind = ? AND experiment = ? AND subject_index = ?",
                   format_kind(row.kind), format_experiment(row.experiment), row.subject_index);
  if (holder.step()) {
    throw InputError(database.name(), "session/subject_index", "an index that no session of its kind holds",
                     fmt::format("{}, which session {} holds", row.subject_index, holder.integer(0)));
  }
}

Phase parse_phase(const std::string& text, const std::string& source) {
  for (const Phase phase : {Phase::kPractice, Phase::kMain, Phase::kCatch}) {
    if (text == format_phase(phase)) return phase;
  }
  throw InputError(source, "trial/phase", "practice, main or catch", text);
}

template <typename T, typename Get>
std::optional<T> value_unless_null(const Statement& statement, int column, const Get& get) {
  return statement.is_null(column) ? std::nullopt : std::optional<T>(static_cast<T>(get(column)));
}

SessionRow read_session(const Statement& row, const std::string& source) {
  const auto integer = [&](int column) { return row.integer(column); };
  const auto real = [&](int column) { return row.real(column); };
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
                    value_unless_null<double>(row, 16, real),
                    value_unless_null<double>(row, 17, real),
                    value_unless_null<double>(row, 18, real)};
  session.started_utc = row.text(19);
  session.complete = row.integer(20) != 0;
  session.uuid = row.text(21);
  session.station = row.text(22);
  return session;
}

TrialRow read_trial(const Statement& row, const std::string& source) {
  TrialRow trial;
  trial.number = static_cast<int>(row.integer(0));
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

std::map<std::string, std::string> load_fields(const Database& database, std::int64_t session) {
  Statement statement(database, "SELECT name, value FROM field WHERE session = ?", session);
  std::map<std::string, std::string> fields;
  while (statement.step()) fields[statement.text(0)] = statement.text(1);
  return fields;
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

TrialLog TrialLog::load_snapshot(const fs::path& path) {
  return TrialLog(std::make_unique<Impl>(Impl{open_log_snapshot(path)}));
}

TrialLog::~TrialLog() = default;
TrialLog::TrialLog(TrialLog&&) noexcept = default;
TrialLog& TrialLog::operator=(TrialLog&&) noexcept = default;

std::int64_t TrialLog::append_session(const SessionRow& row, const std::vector<TrialRow>& trials) {
  Transaction transaction(impl_->database);
  check_can_begin(impl_->database, row);
  const std::int64_t session = insert_session(impl_->database, row);
  for (const TrialRow& trial : trials) insert_trial(impl_->database, session, trial);
  transaction.commit();
  return session;
}

std::vector<SessionRow> TrialLog::load_sessions() const {
  Statement statement(
      impl_->database,
      "SELECT session.id, code, kind, experiment, subject_index, seed, program_version,"
      " study_digest, manifest_digest, windows_digest, selection_digest, truth_digest,"
      " protocol_digest, monitor, framebuffer_width, framebuffer_height, viewing_distance_m, degrees_wide,"
      " degrees_high, started_utc, complete, uuid, station"
      " FROM session JOIN participant ON participant.id = participant ORDER BY session.id");
  std::vector<SessionRow> sessions;
  while (statement.step()) sessions.push_back(read_session(statement, impl_->database.name()));
  for (SessionRow& session : sessions) session.fields = load_fields(impl_->database, session.id);
  return sessions;
}

std::vector<TrialRow> TrialLog::load_trials(std::int64_t session) const {
  Statement statement(impl_->database,
                      "SELECT trial, phase, cell, test_key, pair_key, upper_key, test_side, answer,"
                      " response_time_ns, answered_utc, too_fast FROM trial WHERE session = ? ORDER BY trial",
                      session);
  std::vector<TrialRow> trials;
  while (statement.step()) trials.push_back(read_trial(statement, impl_->database.name()));
  return trials;
}

std::int64_t TrialLog::find_free_index(SubjectKind kind, Experiment experiment) const {
  Statement statement(impl_->database,
                      "SELECT subject_index FROM session WHERE kind = ? AND experiment = ?"
                      " ORDER BY subject_index",
                      format_kind(kind), format_experiment(experiment));
  std::int64_t free = 0;
  while (statement.step() && statement.integer(0) <= free) free = std::max(free, statement.integer(0) + 1);
  return free;
}

bool TrialLog::has_session_using_selection(const std::string& selection_digest) const {
  return Statement(impl_->database, "SELECT 1 FROM session WHERE selection_digest = ?", selection_digest)
      .step();
}

void TrialLog::append_showing(std::int64_t session, int trial, std::int64_t time_ns) {
  Transaction transaction(impl_->database);
  insert_event(impl_->database, session, trial, "showing", time_ns);
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
  insert_event(impl_->database, session, answer.trial, "answer", time_ns);
  if (next_trial) insert_event(impl_->database, session, next_trial, "showing", time_ns);
  transaction.commit();
}

void TrialLog::append_event(std::int64_t session, const std::string& kind, std::int64_t time_ns,
                            const std::string& detail) {
  Transaction transaction(impl_->database);
  insert_event(impl_->database, session, std::nullopt, kind, time_ns, detail);
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
  insert_event(impl_->database, session, std::nullopt, "finish", time_ns);
  transaction.commit();
}

std::vector<AnswerRow> TrialLog::load_answers(SubjectKind kind, Experiment experiment) const {
  Statement statement(
      impl_->database,
      "SELECT session, subject_index, cell, answer = test_side FROM trial"
      " JOIN session ON session.id = session"
      " WHERE kind = ? AND experiment = ? AND complete = 1 AND phase = 'main' ORDER BY session, trial",
      format_kind(kind), format_experiment(experiment));
  std::vector<AnswerRow> answers;
  while (statement.step()) {
    answers.push_back({statement.integer(0), statement.integer(1),
                       parse_cell(statement.text(2), impl_->database.name(), "trial/cell"),
                       statement.integer(3) != 0});
  }
  return answers;
}

std::string TrialLog::load_setting(const std::string& name) const {
  return read_setting(impl_->database, name);
}

std::string digest_answers(const std::vector<AnswerRow>& answers) {
  std::vector<std::string> lines;
  for (const AnswerRow& answer : answers) {
    lines.push_back(fmt::format("{} {} {}\n", format_key(answer.cell), answer.subject_index,
                                answer.correct ? "correct" : "wrong"));
  }
  std::sort(lines.begin(), lines.end());
  return digest_text(fmt::format("{}", fmt::join(lines, "")));
}

}  // namespace equilux
