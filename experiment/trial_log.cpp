// The one file that knows SQLite: every answer is on the disk before the next pair is on the screen.
#include "experiment/trial_log.h"

#include <algorithm>
#include <sqlite3.h>
#include <string_view>
#include <sys/vfs.h>
#include <utility>

#include "base/digest.h"
#include "base/error.h"
#include "base/program.h"

namespace equilux {

extern const char kResponsesSchema[];

namespace {
namespace fs = std::filesystem;

constexpr std::int64_t kApplicationId = 0x45514C58;  // "EQLX"
constexpr int kBusyTimeoutMs = 5000;

// Checkpoints the WAL away, so that the file alone, copied after the close, is whole.
struct CloseDatabase {
  void operator()(sqlite3* handle) const {
    sqlite3_wal_checkpoint_v2(handle, nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr, nullptr);
    sqlite3_close(handle);
  }
};

class Database {
 public:
  Database(const fs::path& path, bool create) : path_(path) {
    sqlite3* handle = nullptr;
    const int flags = SQLITE_OPEN_READWRITE | (create ? SQLITE_OPEN_CREATE : 0);
    const int code = sqlite3_open_v2(path.c_str(), &handle, flags, nullptr);
    handle_.reset(handle);
    if (code != SQLITE_OK) fail("open");
    sqlite3_extended_result_codes(handle, 1);
    sqlite3_busy_timeout(handle, kBusyTimeoutMs);
  }

  sqlite3* handle() const { return handle_.get(); }
  std::string name() const { return path_.string(); }
  void execute(const char* sql) const {
    if (sqlite3_exec(handle(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) fail("write");
  }
  /// From here on the file is known as a log, and whatever fails is the store's failure.
  void vouch() { vouched_ = true; }

  [[noreturn]] void fail(std::string_view verb) const {
    const int code = handle_ ? sqlite3_errcode(handle()) & 0xff : SQLITE_NOMEM;
    const std::string message = handle_ ? sqlite3_errmsg(handle()) : "out of memory";
    if (!vouched_ && (code == SQLITE_NOTADB || code == SQLITE_CORRUPT)) {
      throw InputError(name(), "", "a whole log of responses (SQLite)", message);
    }
    fail_store(fmt::format("cannot {}: {}", verb, message));
  }
  [[noreturn]] void fail_store(std::string_view what) const {
    throw StoreError(fmt::format("{}: {}", name(), what));
  }

 private:
  fs::path path_;
  std::unique_ptr<sqlite3, CloseDatabase> handle_;
  bool vouched_ = false;
};

// A prepared statement with its values; finalised at the end of its scope.
class Statement {
 public:
  template <typename... Values>
  Statement(const Database& database, std::string_view sql, const Values&... values) : database_(database) {
    sqlite3_stmt* handle = nullptr;
    const int size = static_cast<int>(sql.size());
    if (sqlite3_prepare_v2(database.handle(), sql.data(), size, &handle, nullptr) != SQLITE_OK) {
      database.fail("read");
    }
    handle_.reset(handle);
    (bind(values), ...);
  }

  /// True while there is a row.
  bool step() {
    const int code = sqlite3_step(handle_.get());
    if (code != SQLITE_ROW && code != SQLITE_DONE) {
      database_.fail(sqlite3_stmt_readonly(handle_.get()) ? "read" : "write");
    }
    return code == SQLITE_ROW;
  }
  /// Runs a statement that changes rows; gives how many.
  int run() {
    while (step()) {
    }
    return sqlite3_changes(database_.handle());
  }

  bool is_null(int column) const { return sqlite3_column_type(handle_.get(), column) == SQLITE_NULL; }
  std::int64_t integer(int column) const { return sqlite3_column_int64(handle_.get(), column); }
  double real(int column) const { return sqlite3_column_double(handle_.get(), column); }
  std::string text(int column) const {
    const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(handle_.get(), column));
    if (!bytes) return {};
    return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(handle_.get(), column))};
  }

 private:
  struct Finalise {
    void operator()(sqlite3_stmt* handle) const { sqlite3_finalize(handle); }
  };

  void bind(std::int64_t value) { check(sqlite3_bind_int64(handle_.get(), ++bound_, value)); }
  void bind(int value) { bind(std::int64_t{value}); }
  void bind(double value) { check(sqlite3_bind_double(handle_.get(), ++bound_, value)); }
  void bind(const std::string& value) {
    check(sqlite3_bind_text64(handle_.get(), ++bound_, value.data(), value.size(), SQLITE_TRANSIENT,
                              SQLITE_UTF8));
  }
  void bind(std::nullopt_t) { check(sqlite3_bind_null(handle_.get(), ++bound_)); }
  template <typename T>
  void bind(const std::optional<T>& value) {
    if (value) {
      bind(*value);
    } else {
      bind(std::nullopt);
    }
  }
  void check(int code) const {
    if (code != SQLITE_OK) database_.fail("bind");
  }

  const Database& database_;
  std::unique_ptr<sqlite3_stmt, Finalise> handle_;
  int bound_ = 0;
};

// Holds the writer's lock from the start; rolls back unless committed.
class Transaction {
 public:
  explicit Transaction(const Database& database) : database_(database) {
    database.execute("BEGIN IMMEDIATE");
  }
  ~Transaction() {
    if (!committed_) sqlite3_exec(database_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
  }
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  void commit() {
    database_.execute("COMMIT");
    committed_ = true;
  }

 private:
  const Database& database_;
  bool committed_ = false;
};

std::string format_side(Side side) { return side == Side::kLeft ? "left" : "right"; }

Side parse_side(const std::string& text, const std::string& source) {
  if (text != "left" && text != "right") throw InputError(source, "trial", "left or right", text);
  return text == "left" ? Side::kLeft : Side::kRight;
}

std::int64_t load_integer(const Database& database, std::string_view sql) {
  Statement statement(database, sql);
  return statement.step() ? statement.integer(0) : 0;
}

// Files of nobody: new ones, and those whose maker was killed before its first transaction.
bool is_empty(const Database& database) {
  return load_integer(database, "PRAGMA application_id") == 0 &&
         load_integer(database, "PRAGMA user_version") == 0 &&
         load_integer(database, "SELECT count(*) FROM sqlite_schema") == 0;
}

void make_tables(const Database& database) {
  Transaction transaction(database);
  if (!is_empty(database)) return;  // another program was faster
  database.execute(kResponsesSchema);
  database.execute(fmt::format("PRAGMA application_id = {}", kApplicationId).c_str());
  database.execute(fmt::format("PRAGMA user_version = {}", kLogSchemaVersion).c_str());
  transaction.commit();
}

void check_is_log(const Database& database) {
  const std::int64_t application = load_integer(database, "PRAGMA application_id");
  if (application != kApplicationId) {
    throw InputError(database.name(), "PRAGMA application_id", fmt::format("{}, a log's", kApplicationId),
                     fmt::format("{}", application));
  }
  const std::int64_t version = load_integer(database, "PRAGMA user_version");
  if (version != kLogSchemaVersion) {
    throw InputError(database.name(), "PRAGMA user_version",
                     fmt::format("schema version {}", kLogSchemaVersion),
                     version > kLogSchemaVersion ? fmt::format("{}, of a newer Equilux", version)
                                                 : fmt::format("{}", version));
  }
}

void check_is_whole(const Database& database) {
  Statement statement(database, "PRAGMA quick_check(1)");
  std::string result = statement.step() ? statement.text(0) : "nothing";
  std::replace(result.begin(), result.end(), '\n', ' ');
  if (result != "ok") throw InputError(database.name(), "", "a whole log of responses", result);
}

// The WAL's index is shared memory, which other machines do not see. source: sqlite.org/wal.html
void check_file_system(const Database& database) {
  struct statfs system {};
  if (::statfs(database.name().c_str(), &system) != 0) return;
  constexpr std::uint32_t kNfs = 0x6969, kSmb = 0x517B, kSmb2 = 0xFE534D42, kCifs = 0xFF534D42;
  const auto type = static_cast<std::uint32_t>(system.f_type);
  if (type == kNfs || type == kSmb || type == kSmb2 || type == kCifs) {
    database.fail_store("a log cannot be kept on a network file system; use a local disk");
  }
}

std::string read_setting(const Database& database, const std::string& name) {
  Statement statement(database, "PRAGMA " + name);
  return statement.step() ? statement.text(0) : "";
}

void require_setting(const Database& database, const char* name, const char* value, const char* read_back) {
  read_setting(database, fmt::format("{} = {}", name, value));
  const std::string got = read_setting(database, name);
  if (got != read_back) {
    database.fail_store(fmt::format("a log needs {} = {}, but here it stays {}", name, value, got));
  }
}

// Nothing is written before the file is known to be a log, or to be nobody's.
void prepare(Database& database, bool create) {
  const bool empty = is_empty(database);
  if (!empty || !create) {
    if (empty) throw InputError(database.name(), "", "a log of responses", "an empty file");
    check_is_log(database);
    check_is_whole(database);
  }
  check_file_system(database);
  require_setting(database, "journal_mode", "WAL", "wal");
  require_setting(database, "synchronous", "FULL", "2");
  require_setting(database, "foreign_keys", "ON", "1");
  if (empty) make_tables(database);
  database.vouch();
}

Database open_database(const fs::path& path, bool create) {
  if (fs::is_directory(path)) throw InputError(path.string(), "", "a log of responses", "a folder");
  if (!create && !fs::exists(path)) {
    throw InputError(path.string(), "", "a log of responses", "nothing of that name");
  }
  Database database(path, create);
  prepare(database, create);
  return database;
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

std::int64_t insert_session(const Database& database, const SessionRow& row) {
  const std::int64_t participant = insert_participant(database, row.participant);
  Statement(database,
            "INSERT INTO session (participant, kind, experiment, subject_index, seed, program_version,"
            " study_digest, manifest_digest, windows_digest, selection_digest, truth_digest, monitor,"
            " framebuffer_width, framebuffer_height, viewing_distance_m, degrees_wide, degrees_high,"
            " started_utc) VALUES (?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?,?)",
            participant, format_kind(row.kind), format_experiment(row.experiment), row.subject_index,
            static_cast<std::int64_t>(row.seed), row.program_version, row.digests.study, row.digests.manifest,
            row.digests.windows, row.digests.selection, row.digests.truth, row.screen.monitor,
            row.screen.framebuffer_width, row.screen.framebuffer_height, row.screen.viewing_distance_m,
            row.screen.degrees_wide, row.screen.degrees_high, row.started_utc)
      .run();
  return sqlite3_last_insert_rowid(database.handle());
}

void insert_trial(const Database& database, std::int64_t session, const TrialRow& trial) {
  const auto answer = trial.answer ? std::optional(format_side(*trial.answer)) : std::nullopt;
  Statement(database,
            "INSERT INTO trial (session, trial, cell, test_key, pair_key, upper_key, test_side, answer,"
            " response_time_ns, answered_utc) VALUES (?,?,?,?,?,?,?,?,?,?)",
            session, trial.number, format_key(trial.cell), trial.test_key, trial.pair_key, trial.upper_key,
            format_side(trial.test_side), answer, trial.response_time_ns, trial.answered_utc)
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
  session.digests = {row.text(7), row.text(8), row.text(9), row.text(10), row.text(11)};
  session.screen = {row.text(12),
                    value_unless_null<int>(row, 13, integer),
                    value_unless_null<int>(row, 14, integer),
                    value_unless_null<double>(row, 15, real),
                    value_unless_null<double>(row, 16, real),
                    value_unless_null<double>(row, 17, real)};
  session.started_utc = row.text(18);
  session.complete = row.integer(19) != 0;
  return session;
}

TrialRow read_trial(const Statement& row, const std::string& source) {
  TrialRow trial;
  trial.number = static_cast<int>(row.integer(0));
  trial.cell = parse_cell(row.text(1), source, "trial/cell");
  trial.test_key = row.text(2);
  trial.pair_key = row.text(3);
  trial.upper_key = row.text(4);
  trial.test_side = parse_side(row.text(5), source);
  if (row.is_null(6)) return trial;
  trial.answer = parse_side(row.text(6), source);
  trial.response_time_ns = row.integer(7);
  trial.answered_utc = row.text(8);
  return trial;
}

}  // namespace

struct TrialLog::Impl {
  Database database;
};

TrialLog::TrialLog(const fs::path& path, bool create)
    : impl_(std::make_unique<Impl>(Impl{open_database(path, create)})) {}
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
  Statement statement(impl_->database,
                      "SELECT session.id, code, kind, experiment, subject_index, seed, program_version,"
                      " study_digest, manifest_digest, windows_digest, selection_digest, truth_digest,"
                      " monitor, framebuffer_width, framebuffer_height, viewing_distance_m, degrees_wide,"
                      " degrees_high, started_utc, complete"
                      " FROM session JOIN participant ON participant.id = participant ORDER BY session.id");
  std::vector<SessionRow> sessions;
  while (statement.step()) sessions.push_back(read_session(statement, impl_->database.name()));
  return sessions;
}

std::vector<TrialRow> TrialLog::load_trials(std::int64_t session) const {
  Statement statement(impl_->database,
                      "SELECT trial, cell, test_key, pair_key, upper_key, test_side, answer,"
                      " response_time_ns, answered_utc FROM trial WHERE session = ? ORDER BY trial",
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
  while (statement.step() && statement.integer(0) == free) ++free;
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
                "UPDATE trial SET answer = ?, response_time_ns = ?, answered_utc = ?"
                " WHERE session = ? AND trial = ? AND answer IS NULL",
                format_side(answer.side), answer.response_time_ns, format_utc_now(), session, answer.trial)
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
  Statement statement(impl_->database,
                      "SELECT session, subject_index, cell, answer = test_side FROM trial"
                      " JOIN session ON session.id = session"
                      " WHERE kind = ? AND experiment = ? AND complete = 1 ORDER BY session, trial",
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
