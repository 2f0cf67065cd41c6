// A log as any other program would read or damage it: past the code under test.
#pragma once

#include <filesystem>
#include <memory>
#include <sqlite3.h>
#include <string>
#include <vector>

#include "base/error.h"

namespace equilux {

class RawDatabase {
 public:
  explicit RawDatabase(const std::filesystem::path& path) {
    sqlite3* handle = nullptr;
    const int code = sqlite3_open(path.c_str(), &handle);
    handle_.reset(handle);
    EQ_CHECK(code == SQLITE_OK, path.string());
  }

  /// shape: rows x columns, as text; NULL is "NULL".
  std::vector<std::vector<std::string>> query(const std::string& sql) const {
    std::vector<std::vector<std::string>> rows;
    const auto append = [](void* target, int count, char** values, char**) {
      auto& row = static_cast<std::vector<std::vector<std::string>>*>(target)->emplace_back();
      for (int i = 0; i < count; ++i) row.push_back(values[i] ? values[i] : "NULL");
      return 0;
    };
    char* message = nullptr;
    const int code = sqlite3_exec(handle_.get(), sql.c_str(), append, &rows, &message);
    const std::string text = message ? message : "";
    sqlite3_free(message);
    if (code != SQLITE_OK) throw std::runtime_error(text);
    return rows;
  }
  std::string value(const std::string& sql) const { return query(sql).at(0).at(0); }

 private:
  struct Close {
    void operator()(sqlite3* handle) const { sqlite3_close(handle); }
  };
  std::unique_ptr<sqlite3, Close> handle_;
};

using Rows = std::vector<std::vector<std::string>>;

/// Everything of a log that two runs of the same subjects must share: no UTC times, and no events, which tell
/// of interruptions.
inline std::vector<Rows> load_shared_content(const std::filesystem::path& path) {
  const RawDatabase database(path);
  return {database.query("SELECT id, code FROM participant ORDER BY id"),
          database.query("SELECT id, participant, kind, experiment, subject_index, seed, program_version,"
                         " study_digest, manifest_digest, windows_digest, selection_digest, truth_digest,"
                         " monitor, framebuffer_width, framebuffer_height, viewing_distance_m, degrees_wide,"
                         " degrees_high, complete FROM session ORDER BY id"),
          database.query("SELECT session, trial, cell, test_key, pair_key, upper_key, test_side, answer,"
                         " response_time_ns FROM trial ORDER BY session, trial")};
}

inline Rows load_events(const std::filesystem::path& path) {
  return RawDatabase(path).query("SELECT session, trial, kind, time_ns, detail FROM event ORDER BY id");
}

/// Every row and column, times and events too.
inline std::vector<Rows> load_whole_content(const std::filesystem::path& path) {
  const RawDatabase database(path);
  std::vector<Rows> tables;
  for (const char* table : {"participant", "session", "trial", "event"}) {
    tables.push_back(database.query(fmt::format("SELECT * FROM {} ORDER BY rowid", table)));
  }
  return tables;
}

}  // namespace equilux
