// A report as its readers get it: CSV files, their fields found by the names in the first line.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "analysis/csv.h"
#include "base/error.h"
#include "base/files.h"
#include "protocols/condition.h"

namespace equilux {

/// A row: field by column name.
using Record = std::map<std::string, std::string>;

inline std::vector<Record> parse_records(const std::string& text, const std::string& source) {
  const Table table = parse_csv(text, source);
  std::vector<Record> records;
  for (const auto& row : table.rows) {
    EQ_CHECK(row.size() == table.columns.size(), source);
    Record& record = records.emplace_back();
    for (std::size_t i = 0; i < row.size(); ++i) record[table.columns[i]] = row[i];
  }
  return records;
}

struct ReportTables {
  std::vector<Record> cells;
  std::vector<Record> thresholds;
  std::vector<Record> ee;
};

inline ReportTables load_report_tables(const std::filesystem::path& folder) {
  const auto load = [&](const char* name) { return parse_records(load_text(folder / name), name); };
  return {load("cells.csv"), load("thresholds.csv"), load("ee.csv")};
}

/// What names a column in every table: "G0 MS ind 1000".
inline std::string column_name(const Record& record) {
  return record.at("geometry") + " " + record.at("material") + " " + record.at("illumination") + " " +
         record.at("vpls");
}

inline std::string column_name(const Column& column) {
  return fmt::format("{} {} {} {}", column.object.geometry, column.object.material,
                     format_illumination(column.object.illumination), column.vpl_count);
}

/// "C7" gives 7, "" gives nothing.
inline std::optional<int> parse_cut(const std::string& field) {
  if (field.empty()) return std::nullopt;
  return parse_clamp_level(field, "a table");
}

/// "C4 C6 C8": no levels give "".
inline std::string list_levels(const std::vector<int>& levels) {
  std::string text;
  for (int level : levels) text += (text.empty() ? "C" : " C") + std::to_string(level);
  return text;
}

}  // namespace equilux
