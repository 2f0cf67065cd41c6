// Checks and migrations of responses.sqlite.
#include "experiment/log_schema.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <random>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include "base/digest.h"
#include "base/error.h"
#include "base/files.h"

namespace equilux {

extern const char kResponsesSchema[];

namespace {
namespace fs = std::filesystem;

constexpr std::int64_t kApplicationId = 0x45514C58;  // "EQLX"
constexpr std::size_t kIdentityDigits = 32;
constexpr const char* kPartSuffix = ".part";
// A file that nobody wrote into has a page at most; of a larger one SQLite need not be asked.
constexpr std::uintmax_t kLargestEmpty = 65536;
constexpr const char* kInMemory = ":memory:";  // SQLite's name for no file

fs::path folder_of(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

// Files of nobody: new ones, and those whose maker was killed before its first transaction.
bool is_empty(const Database& database) {
  return load_integer(database, "PRAGMA application_id") == 0 &&
         load_integer(database, "PRAGMA user_version") == 0 &&
         load_integer(database, "SELECT count(*) FROM sqlite_schema") == 0;
}

void write_tables(const Database& database, const std::string& station) {
  database.execute(kResponsesSchema);
  Statement(database, "INSERT INTO log (id, station) VALUES (1, ?)", station).run();
  database.execute(fmt::format("PRAGMA application_id = {}", kApplicationId));
  database.execute(fmt::format("PRAGMA user_version = {}", kLogSchemaVersion));
}

void make_tables(const Database& database) {
  Transaction transaction(database);
  if (!is_empty(database)) return;  // another program was faster
  write_tables(database, draw_identity());
  transaction.commit();
}

[[noreturn]] void refuse_damaged(const Database& database, const std::string& what) {
  throw InputError(database.name(), "", "a whole log of responses",
                   fmt::format("{}; {}", what, kDamageAdvice));
}

void check_is_log(const Database& database) {
  const std::int64_t application = load_integer(database, "PRAGMA application_id");
  if (application != kApplicationId) {
    throw InputError(database.name(), "PRAGMA application_id", "a log of responses",
                     fmt::format("a database of another program, {}", application));
  }
  const std::int64_t version = load_integer(database, "PRAGMA user_version");
  if (version < 1 || version > kLogSchemaVersion) {
    throw InputError(database.name(), "PRAGMA user_version",
                     fmt::format("schema version 1 to {}", kLogSchemaVersion),
                     version > kLogSchemaVersion ? fmt::format("{}, of a newer Equilux", version)
                                                 : fmt::format("{}", version));
  }
}

std::int64_t load_version(const Database& database) { return load_integer(database, "PRAGMA user_version"); }

std::string ask_check(const Database& database, const std::string& pragma) {
  Statement statement(database, "PRAGMA " + pragma);
  std::string result = statement.step() ? statement.text(0) : "nothing";
  std::replace(result.begin(), result.end(), '\n', ' ');
  return result;
}

void require_ok(const Database& database, const std::string& pragma) {
  if (const std::string result = ask_check(database, pragma); result != "ok")
    refuse_damaged(database, result);
}

// Another program may have written a table anew that takes values of any type, which its CHECKs alone refuse.
bool are_strict(const Database& database) {
  return load_integer(database,
                      "SELECT count(*) FROM pragma_table_list WHERE schema = 'main' AND strict = 1"
                      " AND name IN ('trial', 'event')") == 2;
}

// A row of a session that is not there would be counted nowhere, and nobody would miss it.
void refuse_orphans(const Database& database, const char* table, const char* number) {
  Statement row(database, fmt::format("SELECT session, {} FROM {} WHERE session NOT IN"
                                      " (SELECT id FROM session) LIMIT 1",
                                      number, table));
  if (!row.step()) return;
  refuse_orphan(database.name(), row.integer(0), fmt::format("{} {}", table, row.text(1)));
}

// Those of trials, where all of them are read, are left to load_brief_trials.
void check_belonging(const Database& database) {
  refuse_orphans(database, "trial", "trial");
  refuse_orphans(database, "event", "id");
  Statement row(database,
                "SELECT id FROM session WHERE complete = 1 AND NOT EXISTS"
                " (SELECT 1 FROM trial WHERE trial.session = session.id) LIMIT 1");
  if (row.step()) refuse_without_trials(database.name(), row.integer(0));
}

// Of the two tables with rows by the thousand the one is left to load_brief_trials, and the other has a
// single CHECK, which is asked here: quick_check would go through its rows once more.
void check_tables(const Database& database) {
  database.execute("PRAGMA ignore_check_constraints = ON");
  const std::string result = ask_check(database, "quick_check(1)");
  database.execute("PRAGMA ignore_check_constraints = OFF");
  if (result != "ok") refuse_damaged(database, result);
  for (const char* table : {"log", "participant", "session", "field"})
    require_ok(database, fmt::format("quick_check({})", table));
  if (Statement(database, "SELECT 1 FROM event NOT INDEXED WHERE kind = ''").step())
    refuse_damaged(database, "an event without a kind");
}

// Rows are read through indexes too, so that one that lacks an entry would hide an answer. The rows of an
// older schema are read to be written anew, which asks for whole ones.
void check_is_whole(const Database& database, LogCheck check) {
  if (check == LogCheck::kTables && load_version(database) == kLogSchemaVersion && are_strict(database)) {
    check_tables(database);
  } else {
    require_ok(database, check == LogCheck::kWhole ? "integrity_check(1)" : "quick_check(1)");
  }
  // Of other tables the rows refer to is what their indexes hold.
  if (Statement(database, "PRAGMA foreign_key_check(session)").step())
    refuse_damaged(database, "a session whose participant is not there");
  if (load_version(database) < kLogSchemaVersion) return;  // migrate looks at all tables
  refuse_orphans(database, "field", "name");
  if (check == LogCheck::kWhole) check_belonging(database);
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

// A session of schema 1 had no identity: it gets one from what it was, the same in every copy of its log.
std::string find_old_identity(const Statement& row) {
  std::string text = "session of schema 1";
  for (int column = 1; column <= 5; ++column) text.append("\n").append(row.text(column));
  return digest_text(text).substr(0, kIdentityDigits);
}

struct OldSession {
  std::int64_t id = 0;
  std::string identity;
};

std::vector<OldSession> load_old_sessions(const Database& database) {
  Statement row(database,
                "SELECT old_session.id, kind, experiment, code, seed, started_utc FROM old_session"
                " JOIN old_participant ON old_participant.id = participant ORDER BY old_session.id");
  std::vector<OldSession> sessions;
  while (row.step()) sessions.push_back({row.integer(0), find_old_identity(row)});
  return sessions;
}

void copy_old_sessions(const Database& database, const std::vector<OldSession>& sessions) {
  for (const OldSession& session : sessions) {
    Statement(database,
              "INSERT INTO session SELECT id, ?, ?, participant, kind, experiment, subject_index, seed,"
              " program_version, study_digest, manifest_digest, windows_digest, selection_digest,"
              " truth_digest, '', monitor, framebuffer_width, framebuffer_height, viewing_distance_m,"
              " degrees_wide, degrees_high, started_utc, complete FROM old_session WHERE id = ?",
              session.identity, sessions.front().identity, session.id)
        .run();
  }
}

// In one transaction, foreign keys off.
void migrate_from_1(const Database& database) {
  for (const char* table : {"participant", "session", "trial", "event"})
    database.execute(fmt::format("ALTER TABLE {} RENAME TO old_{}", table, table));
  const std::vector<OldSession> sessions = load_old_sessions(database);
  write_tables(database, sessions.empty() ? draw_identity() : sessions.front().identity);
  database.execute("INSERT INTO participant SELECT id, code FROM old_participant");
  copy_old_sessions(database, sessions);
  database.execute(
      "INSERT INTO trial SELECT session, trial, 'main', cell, test_key, pair_key, upper_key, test_side, "
      "answer,"
      " response_time_ns, answered_utc, 0 FROM old_trial");
  database.execute(
      "INSERT INTO event SELECT id, session, trial, kind, time_ns, recorded_utc, detail FROM old_event");
  for (const char* table : {"event", "trial", "session", "participant"})
    database.execute(fmt::format("DROP TABLE old_{}", table));
}

void migrate(const Database& database) {
  database.execute("PRAGMA foreign_keys = OFF");
  Transaction transaction(database);
  if (load_version(database) == kLogSchemaVersion) return;  // another program was faster
  migrate_from_1(database);
  if (Statement(database, "PRAGMA foreign_key_check").step())
    throw InputError(database.name(), "PRAGMA foreign_key_check",
                     "rows whose sessions and participants exist", "some that refer to nothing");
  transaction.commit();
}

fs::path name_kept_copy(const fs::path& path, std::int64_t version, int number) {
  const std::string count = number == 1 ? "" : fmt::format("-{}", number);
  return path.parent_path() /
         fmt::format("{}.v{}{}{}", path.stem().string(), version, count, path.extension().string());
}

// Files named as name_kept_copy does, but for their end.
std::vector<fs::path> find_beside(const fs::path& path, const std::string& end) {
  const std::string begin = fmt::format("{}.v", path.stem().string());
  std::vector<fs::path> found;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder_of(path), ignored)) {
    const std::string name = entry.path().filename().string();
    if (name.size() < begin.size() + end.size() || !name.starts_with(begin) || !name.ends_with(end)) continue;
    const std::string number = name.substr(begin.size(), name.size() - begin.size() - end.size());
    if (!number.empty() && number.find_first_not_of("0123456789-") == std::string::npos)
      found.push_back(path.parent_path() / name);
  }
  std::sort(found.begin(), found.end());
  return found;
}

// Made whole under another name first; never over one that is there.
void keep_copy(const Database& database) {
  int number = 1;
  while (fs::exists(name_kept_copy(database.path(), load_version(database), number))) ++number;
  const fs::path kept = name_kept_copy(database.path(), load_version(database), number);
  const fs::path part = kept.string() + kPartSuffix;
  fs::remove(part);
  {
    const int file = ::open(part.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0600);
    if (file < 0)
      database.fail_store(fmt::format("cannot keep a copy as {}: {}", part.string(), std::strerror(errno)));
    ::close(file);
    const Database copy(part, OpenMode::kWrite);
    copy_database(database, copy);
    read_setting(copy, "journal_mode = DELETE");
  }
  fs::rename(part, kept);
}

// Nothing is written before the file is known to be a log, or to be nobody's.
void prepare(Database& database, bool create) {
  const bool empty = is_empty(database);
  if (!empty || !create) {
    if (empty) throw InputError(database.name(), "", "a log of responses", "an empty file");
    check_is_log(database);
    check_is_whole(database, LogCheck::kWhole);
  }
  check_file_system(database);
  require_setting(database, "journal_mode", "WAL", "wal");
  require_setting(database, "synchronous", "FULL", "2");
  if (empty) {
    make_tables(database);
  } else if (load_version(database) < kLogSchemaVersion) {
    keep_copy(database);
    migrate(database);
  }
  require_setting(database, "foreign_keys", "ON", "1");
  database.vouch();
}

void check_exists(const fs::path& path, bool create) {
  if (fs::is_directory(path)) throw InputError(path.string(), "", "a log of responses", "a folder");
  if (!create && !fs::exists(path))
    throw InputError(path.string(), "", "a log of responses", "nothing of that name");
}

void keep_out_of_file(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || status.st_uid != ::geteuid()) return;
  const bool is_shared = (status.st_mode & S_IWGRP) != 0;
  const mode_t kept = status.st_mode & (is_shared ? 0770 : 0700);
  if (kept != (status.st_mode & 0777)) ::chmod(path.c_str(), kept);
}

// A log that was copied or restored may have become everybody's to read, with its WAL. Of a group that may
// write it too it is meant to be.
void keep_out_others(const fs::path& path) {
  for (const char* suffix : {"", kWalSuffix, kWalIndexSuffix}) keep_out_of_file(path.string() + suffix);
  for (const fs::path& copy : find_beside(path, path.extension().string())) keep_out_of_file(copy);
}

// For its owner alone; SQLite gives the WAL and its index the same permissions. False where it is there.
bool make_private(const fs::path& path) {
  const int file = ::open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0600);
  if (file >= 0) ::close(file);
  return file >= 0;
}

// One into which nothing could be written.
void remove_log(const fs::path& path) {
  std::error_code none;
  for (const char* suffix : {"", kWalSuffix, kWalIndexSuffix}) fs::remove(path.string() + suffix, none);
}

// A reader makes the WAL's index where there is none, if it can.
OpenMode choose_reading(const fs::path& path) {
  const bool can_write = ::faccessat(AT_FDCWD, folder_of(path).c_str(), W_OK, AT_EACCESS) == 0;
  return can_write || fs::exists(path.string() + kWalIndexSuffix) ? OpenMode::kRead : OpenMode::kStill;
}

}  // namespace

void refuse_orphan(const std::string& source, std::int64_t session, const std::string& row) {
  throw InputError(source, fmt::format("session {}, {}", session, row), "a row of a session that is there",
                   fmt::format("one of none; {}", kDamageAdvice));
}

void refuse_without_trials(const std::string& source, std::int64_t session) {
  throw InputError(source, fmt::format("session {}: complete", session),
                   "trials of a session that is finished", fmt::format("none; {}", kDamageAdvice));
}

std::string draw_identity() {
  std::random_device entropy;
  std::string digits;
  while (digits.size() < kIdentityDigits)
    digits += fmt::format("{:08x}", static_cast<std::uint32_t>(entropy()));
  return digits;
}

bool has_log(const fs::path& path) {
  std::error_code none;
  const auto size = fs::file_size(path, none);
  if (none) return fs::exists(path);
  if (size > kLargestEmpty) return true;
  const OpenMode mode = choose_reading(path);
  const auto wal_size = fs::file_size(path.string() + kWalSuffix, none);
  if (mode == OpenMode::kStill && !none && wal_size > 0) return true;  // what it holds cannot be read here
  try {
    return !is_empty(Database(path, mode));
  } catch (const std::exception&) {
    return true;  // what it is instead is told by who opens it
  }
}

Database open_log(const fs::path& path, bool create) {
  check_exists(path, create);
  const bool is_new = create && path != kInMemory && make_private(path);
  if (path != kInMemory) keep_out_others(path);
  try {
    Database database(path, create ? OpenMode::kCreate : OpenMode::kWrite);
    prepare(database, create);
    return database;
  } catch (...) {
    if (is_new && !has_log(path)) remove_log(path);
    throw;
  }
}

Database open_log_alone(const fs::path& path) {
  check_exists(path, false);
  keep_out_others(path);
  Database database(path, OpenMode::kAlone);
  prepare(database, false);
  return database;
}

Database open_log_snapshot(const fs::path& path, LogCheck check) {
  check_exists(path, false);
  Database database(path, OpenMode::kMemory);
  copy_database(Database(path, choose_reading(path)), database);
  if (is_empty(database)) throw InputError(database.name(), "", "a log of responses", "an empty file");
  check_is_log(database);
  check_is_whole(database, check);
  if (load_version(database) < kLogSchemaVersion) migrate(database);
  require_setting(database, "foreign_keys", "ON", "1");
  database.vouch();
  return database;
}

std::vector<fs::path> find_kept_copies(const fs::path& path) {
  return find_beside(path, path.extension().string());
}

Database open_kept_copy(const fs::path& path) {
  check_exists(path, false);
  Database database(path, OpenMode::kWrite);
  check_is_log(database);
  require_setting(database, "journal_mode", "DELETE", "delete");
  database.vouch();
  return database;
}

std::vector<fs::path> find_unfinished_copies(const fs::path& path) {
  return find_beside(path, fmt::format("{}{}", path.extension().string(), kPartSuffix));
}

}  // namespace equilux
