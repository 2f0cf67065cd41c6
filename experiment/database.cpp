// SQLite's C interface behind three classes.
#include "experiment/database.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include "base/error.h"

namespace equilux {
namespace {

constexpr int kBusyTimeoutMs = 5000;

int open_flags(OpenMode mode) {
  switch (mode) {
    case OpenMode::kRead:
      return SQLITE_OPEN_READONLY;
    case OpenMode::kWrite:
      return SQLITE_OPEN_READWRITE;
    default:
      return SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
  }
}

}  // namespace

void Database::Close::operator()(sqlite3* handle) const {
  sqlite3_wal_checkpoint_v2(handle, nullptr, SQLITE_CHECKPOINT_TRUNCATE, nullptr, nullptr);
  sqlite3_close(handle);
}

Database::Database(const std::filesystem::path& path, OpenMode mode) : path_(path) {
  sqlite3* handle = nullptr;
  const std::string file = mode == OpenMode::kMemory ? ":memory:" : path.string();
  const int code = sqlite3_open_v2(file.c_str(), &handle, open_flags(mode), nullptr);
  handle_.reset(handle);
  if (code != SQLITE_OK) fail("open");
  sqlite3_extended_result_codes(handle, 1);
  sqlite3_busy_timeout(handle, kBusyTimeoutMs);
}

void Database::execute(const std::string& sql) const {
  if (sqlite3_exec(handle(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail("write");
}

void Database::fail(std::string_view verb) const {
  const int code = handle_ ? sqlite3_errcode(handle()) & 0xff : SQLITE_NOMEM;
  const std::string message = handle_ ? sqlite3_errmsg(handle()) : "out of memory";
  if (!vouched_ && (code == SQLITE_NOTADB || code == SQLITE_CORRUPT)) {
    throw InputError(name(), "", "a whole log of responses (SQLite)", message);
  }
  fail_store(fmt::format("cannot {}: {}", verb, message));
}

void Database::fail_store(std::string_view what) const {
  throw StoreError(fmt::format("{}: {}", name(), what));
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
std::string Statement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(handle_.get(), column));
  if (!bytes) return {};
  return {bytes, static_cast<std::size_t>(sqlite3_column_bytes(handle_.get(), column))};
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

void copy_database(const Database& source, const Database& target) {
  sqlite3_backup* backup = sqlite3_backup_init(target.handle(), "main", source.handle(), "main");
  if (!backup) target.fail("copy");
  sqlite3_backup_step(backup, -1);
  if (sqlite3_backup_finish(backup) != SQLITE_OK) target.fail("copy");
}

}  // namespace equilux
