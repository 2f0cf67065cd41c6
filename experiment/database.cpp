// SQLite's C interface behind three classes.
#include "experiment/database.h"

#include <cctype>
#include <fmt/format.h>
#include <sqlite3.h>

#include "base/error.h"

namespace equilux {
namespace {

constexpr int kBusyTimeoutMs = 5000;
constexpr int kCloseTimeoutMs = 500;  ///< who holds the log longer empties the WAL at its own end

namespace fs = std::filesystem;

// How sqlite3_open_v2 is asked.
struct Opening {
  std::string file;
  int flags = 0;
  const char* vfs = nullptr;
};

// SQLite's form of a path to which parameters can be added. source: sqlite.org/uri.html
std::string format_uri(const fs::path& path) {
  std::string uri = "file:";
  for (const char c : fs::absolute(path).string()) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) || c == '/' || c == '.' || c == '-';
    uri += plain ? std::string(1, c) : fmt::format("%{:02x}", static_cast<unsigned char>(c));
  }
  return uri;
}

bool has_wal(const fs::path& path) {
  std::error_code error;
  const auto size = fs::file_size(path.string() + kWalSuffix, error);
  return !error && size > 0;
}

// A WAL needs an index, and that a file, unless the connection is alone: then it is in memory.
Opening plan_still(const fs::path& path) {
  if (has_wal(path)) return {path.string(), SQLITE_OPEN_READONLY, "unix-none"};
  return {format_uri(path) + "?immutable=1", SQLITE_OPEN_READONLY | SQLITE_OPEN_URI};
}

Opening plan_opening(const fs::path& path, OpenMode mode) {
  switch (mode) {
    case OpenMode::kStill:
      return plan_still(path);
    case OpenMode::kRead:
      return {path.string(), SQLITE_OPEN_READONLY};
    case OpenMode::kCreate:
      return {path.string(), SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE};
    case OpenMode::kMemory:
      return {":memory:", SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE};
    default:
      return {path.string(), SQLITE_OPEN_READWRITE};
  }
}

bool is_to_be_written(OpenMode mode) {
  return mode == OpenMode::kWrite || mode == OpenMode::kAlone || mode == OpenMode::kCreate;
}

std::string explain_code(int code) {
  if (code == SQLITE_BUSY) return "; another program has it open";
  if (code == SQLITE_READONLY) return "; look at the permissions of the file and its folder";
  if (code == SQLITE_IOERR || code == SQLITE_CANTOPEN)
    return "; is the disk still there, and its folder writable?";
  return "";
}

// SQLite counts its memory under a lock that logs read side by side would wait for; nothing asks for the
// counts. Without effect where the program has used SQLite before.
void leave_memory_uncounted() {
  static const int once = sqlite3_config(SQLITE_CONFIG_MEMSTATUS, 0);
  static_cast<void>(once);
}

void checkpoint(sqlite3* handle) {
  sqlite3_wal_checkpoint_v2(handle, nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr, nullptr);
}

}  // namespace

void Database::Close::operator()(sqlite3* handle) const {
  sqlite3_busy_timeout(handle, kCloseTimeoutMs);
  if (checkpoints) checkpoint(handle);
  sqlite3_close(handle);
}

Database::Database(const std::filesystem::path& path, OpenMode mode)
    : path_(path), handle_(nullptr, Close{is_to_be_written(mode)}) {
  leave_memory_uncounted();
  sqlite3* handle = nullptr;
  const Opening opening = plan_opening(path, mode);
  const int code =
      sqlite3_open_v2(opening.file.c_str(), &handle, opening.flags | SQLITE_OPEN_NOMUTEX, opening.vfs);
  handle_.reset(handle);
  if (code != SQLITE_OK) fail("open");
  sqlite3_extended_result_codes(handle, 1);
  sqlite3_busy_timeout(handle, kBusyTimeoutMs);
  if (mode == OpenMode::kStill || mode == OpenMode::kAlone) execute("PRAGMA locking_mode = EXCLUSIVE");
}

void Database::execute(const std::string& sql) const {
  if (sqlite3_exec(handle(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail("write");
}

void Database::fail(std::string_view verb) const {
  const int code = handle_ ? sqlite3_errcode(handle()) & 0xff : SQLITE_NOMEM;
  const std::string message = handle_ ? sqlite3_errmsg(handle()) : "out of memory";
  if (!vouched_ && (code == SQLITE_NOTADB || code == SQLITE_CORRUPT)) {
    throw InputError(name(), "", "a whole log of responses (SQLite)",
                     message + "; keep this file as it is, and go on with a copy from before");
  }
  fail_store(fmt::format("cannot {}: {}{}", verb, message, explain_code(code)));
}

void Database::fail_store(std::string_view what) const {
  throw StoreError(fmt::format("{}: {}", name(), what));
}

void Database::check_in_place() const {
  int moved = 0;
  sqlite3_file_control(handle(), "main", SQLITE_FCNTL_HAS_MOVED, &moved);
  if (moved) fail_store("moved or removed while it was open; put its folder back and open it again");
}

void Database::empty_wal() const {
  sqlite3_busy_timeout(handle(), kCloseTimeoutMs);
  checkpoint(handle());
  sqlite3_busy_timeout(handle(), kBusyTimeoutMs);
}

int Database::count_changes() const { return sqlite3_changes(handle()); }

std::int64_t Database::last_row_id() const { return sqlite3_last_insert_rowid(handle()); }

void Statement::Finalise::operator()(sqlite3_stmt* handle) const { sqlite3_finalize(handle); }

Statement::Statement(const Database& database, std::string_view sql, Prepared) : database_(database) {
  sqlite3_stmt* handle = nullptr;
  const int size = static_cast<int>(sql.size());
  if (sqlite3_prepare_v2(database.handle(), sql.data(), size, &handle, nullptr) != SQLITE_OK)
    database.fail("read");
  handle_.reset(handle);
}

bool Statement::step() {
  const int code = sqlite3_step(handle_.get());
  if (code != SQLITE_ROW && code != SQLITE_DONE) {
    database_.fail(sqlite3_stmt_readonly(handle_.get()) ? "read" : "write");
  }
  return code == SQLITE_ROW;
}

int Statement::run() {
  while (step()) {
  }
  return database_.count_changes();
}

void Statement::reset() {
  sqlite3_reset(handle_.get());
  bound_ = 0;
}

bool Statement::is_null(int column) const {
  return sqlite3_column_type(handle_.get(), column) == SQLITE_NULL;
}
std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(handle_.get(), column); }
double Statement::real(int column) const { return sqlite3_column_double(handle_.get(), column); }
std::string Statement::text(int column) const { return std::string(view(column)); }

// By the value itself, since a statement is used by one thread: in half the time of sqlite3_column_text.
std::string_view Statement::view(int column) const {
  sqlite3_value* value = sqlite3_column_value(handle_.get(), column);
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_value_text(value));
  if (!bytes) return {};
  return {bytes, static_cast<std::size_t>(sqlite3_value_bytes(value))};
}

void Statement::bind(std::int64_t value) { check(sqlite3_bind_int64(handle_.get(), ++bound_, value)); }
void Statement::bind(double value) { check(sqlite3_bind_double(handle_.get(), ++bound_, value)); }
void Statement::bind(const std::string& value) {
  check(sqlite3_bind_text64(handle_.get(), ++bound_, value.data(), value.size(), SQLITE_TRANSIENT,
                            SQLITE_UTF8));
}
void Statement::bind(std::nullopt_t) { check(sqlite3_bind_null(handle_.get(), ++bound_)); }
void Statement::check(int code) const {
  if (code != SQLITE_OK) database_.fail("bind");
}

Transaction::~Transaction() {
  if (!committed_) sqlite3_exec(database_.handle(), "ROLLBACK", nullptr, nullptr, nullptr);
}

void Transaction::commit() {
  database_.execute("COMMIT");
  committed_ = true;
  database_.check_in_place();
}

std::int64_t load_integer(const Database& database, std::string_view sql) {
  Statement statement(database, sql);
  return statement.step() ? statement.integer(0) : 0;
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

void rewrite_database(const Database& database) {
  const auto empty_wal = [&] {
    if (load_integer(database, "PRAGMA wal_checkpoint(TRUNCATE)") != 0)
      database.fail_store("its WAL cannot be emptied; another program has it open");
  };
  empty_wal();
  database.execute("PRAGMA temp_store = MEMORY");
  database.execute("VACUUM");
  empty_wal();
}

void copy_database(const Database& source, const Database& target) {
  sqlite3_backup* backup = sqlite3_backup_init(target.handle(), "main", source.handle(), "main");
  if (!backup) target.fail("copy");
  sqlite3_backup_step(backup, -1);
  if (sqlite3_backup_finish(backup) != SQLITE_OK) target.fail("copy");
}

}  // namespace equilux
