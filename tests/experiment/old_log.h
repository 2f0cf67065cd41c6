// A log as a program of schema 1 left it.
#pragma once

#include <filesystem>
#include <string>

#include "tests/experiment/raw_database.h"

namespace equilux {

extern const char kResponsesSchema1[];

/// One finished session of P01, and one interrupted one of `code`, who said `reason`.
inline void make_old_log(const std::filesystem::path& path, const std::string& code = "P02",
                         const std::string& reason = "tired") {
  const RawDatabase database(path);
  database.query("PRAGMA journal_mode = WAL");
  database.query(kResponsesSchema1);
  database.query("PRAGMA application_id = 1162955864");
  database.query("PRAGMA user_version = 1");
  database.query("INSERT INTO participant VALUES (1, 'P01'), (2, '" + code + "')");
  for (const char* session : {"1, 1, 'person', 'artifact', 0, 5", "2, 2, 'person', 'artifact', 1, 6"}) {
    database.query(std::string("INSERT INTO session VALUES (") + session +
                   ", '0.1.0', 's', 'm', 'w', '', '', 'HDMI', 1920, 1080, .4572, 16, 12,"
                   " '2026-01-31T12:00:00.000Z', 0)");
  }
  database.query(
      "WITH RECURSIVE numbers (value) AS (VALUES (2) UNION ALL SELECT value + 1 FROM numbers WHERE value < 5)"
      " INSERT INTO trial SELECT value / 2, value % 2, 'G1-MR-ind-100k-C' || (value % 2), 'test', 'pair', '',"
      " 'left', 'left', 1000, '2026-01-31T12:00:01.000Z' FROM numbers");
  database.query(
      "UPDATE trial SET answer = NULL, response_time_ns = NULL, answered_utc = NULL"
      " WHERE session = 2 AND trial = 1");
  database.query("UPDATE session SET complete = 1 WHERE id = 1");
  database.query(
      "INSERT INTO event VALUES (1, 1, 0, 'showing', 7, '2026-01-31T12:00:00.500Z', ''),"
      " (2, 2, NULL, 'abort', 9, '2026-01-31T12:00:02.000Z', '" +
      reason + "')");
}

}  // namespace equilux
