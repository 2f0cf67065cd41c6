// A SQLite database of this program: opened, asked and written. With database.cpp the one place that knows
// SQLite.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace equilux {

/// How a database is opened.
enum class OpenMode {
  kRead,    ///< must exist; nothing is written
  kStill,   ///< as kRead, where nothing can be made beside it and nobody is writing it: without locks
  kWrite,   ///< must exist
  kAlone,   ///< as kWrite, while no other program has it open
  kCreate,  ///< made where there is none
  kMemory,  ///< of this process alone; the path is a name for messages
};

/// SQLite's names for the files beside a database.
inline constexpr const char* kWalSuffix = "-wal";
inline constexpr const char* kWalIndexSuffix = "-shm";

/// An open connection. Closing one that may write checkpoints the WAL away, so that the file alone, copied
/// after the close, is whole.
class Database {
 public:
  /// errors: StoreError
  Database(const std::filesystem::path& path, OpenMode mode);

  sqlite3* handle() const { return handle_.get(); }
  const std::filesystem::path& path() const { return path_; }
  std::string name() const { return path_.string(); }
  /// Statements without results. errors: as fail
  void execute(const std::string& sql) const;
  /// From here on the file is known as a log, and whatever fails is the store's failure.
  void vouch() { vouched_ = true; }

  /// Throws what the last failure means: InputError while the file may be anything and is no database, else
  /// StoreError.
  [[noreturn]] void fail(std::string_view verb) const;
  [[noreturn]] void fail_store(std::string_view what) const;

  /// errors: StoreError if the file is no more what stands under its name: what is written now would be lost
  void check_in_place() const;

  /// Brings what stands in the WAL into the file, as far as readers and the disk let it: nothing is lost
  /// where they do not.
  void empty_wal() const;

  /// Rows that the last statement changed.
  int count_changes() const;
  std::int64_t last_row_id() const;

 private:
  struct Close {
    bool checkpoints;  ///< those who write; a reader would wait for writers
    void operator()(sqlite3* handle) const;
  };
  std::filesystem::path path_;
  std::unique_ptr<sqlite3, Close> handle_;
  bool vouched_ = false;
};

/// A prepared statement with its values; finalised at the end of its scope.
class Statement {
 public:
  template <typename... Values>
  Statement(const Database& database, std::string_view sql, const Values&... values)
      : Statement(database, sql, Prepared{}) {
    (bind(values), ...);
  }

  /// True while there is a row.
  bool step();
  /// Runs a statement that changes rows; gives how many.
  int run();
  /// Runs it once more with other values.
  template <typename... Values>
  int run_with(const Values&... values) {
    reset();
    (bind(values), ...);
    return run();
  }

  bool is_null(int column) const;
  std::int64_t integer(int column) const;
  double real(int column) const;
  std::string text(int column) const;
  std::string_view view(int column) const;  ///< of text, until the next step

 private:
  struct Prepared {};
  struct Finalise {
    void operator()(sqlite3_stmt* handle) const;
  };
  Statement(const Database& database, std::string_view sql, Prepared);

  void reset();
  void bind(std::int64_t value);
  void bind(int value) { bind(std::int64_t{value}); }
  void bind(bool value) { bind(std::int64_t{value}); }
  void bind(double value);
  void bind(const std::string& value);
  void bind(const char* value) { bind(std::string(value)); }
  void bind(std::nullopt_t);
  template <typename T>
  void bind(const std::optional<T>& value) {
    if (value) {
      bind(*value);
    } else {
      bind(std::nullopt);
    }
  }
  void check(int code) const;

  const Database& database_;
  std::unique_ptr<sqlite3_stmt, Finalise> handle_;
  int bound_ = 0;
};

/// Holds the writer's lock from the start; rolls back unless committed.
class Transaction {
 public:
  explicit Transaction(const Database& database) : database_(database) {
    database.execute("BEGIN IMMEDIATE");
  }
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;

  /// errors: StoreError where it is not kept for certain, also if the file was moved or removed meanwhile
  void commit();

 private:
  const Database& database_;
  bool committed_ = false;
};

/// The first column of the first row; 0 without a row.
std::int64_t load_integer(const Database& database, std::string_view sql);
/// A PRAGMA as this connection has it.
std::string read_setting(const Database& database, const std::string& name);
/// Sets a PRAGMA. errors: StoreError where it reads back as something else
void require_setting(const Database& database, const char* name, const char* value, const char* read_back);

/// Writes the database anew, without what was deleted, and empties its WAL. errors: StoreError
void rewrite_database(const Database& database);

/// Copies all of `source`, as the last commit left it, a WAL that was left included, into `target`. errors:
/// StoreError
void copy_database(const Database& source, const Database& target);

}  // namespace equilux
