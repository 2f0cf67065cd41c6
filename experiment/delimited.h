// Tables of text in files: CSV, and the tab-separated form of BIDS.
#pragma once

#include <string>
#include <vector>

#include "experiment/export_columns.h"

namespace equilux {

/// One line with its line feed. A field that holds the separator, a quotation mark or a line's end is quoted
/// as in RFC 4180; an empty one becomes `missing`.
std::string format_fields(const std::vector<std::string>& fields, char separator, const std::string& missing);

/// The line of the columns' names, then a line for each record.
template <typename Record>
std::string format_records(const std::vector<ExportColumn<Record>>& columns,
                           const std::vector<Record>& records, char separator,
                           const std::string& missing = "") {
  std::vector<std::string> fields;
  for (const auto& column : columns) fields.push_back(column.note.name);
  std::string text = format_fields(fields, separator, missing);
  for (const Record& record : records) {
    fields.clear();
    for (const auto& column : columns) fields.push_back(column.value(record));
    text += format_fields(fields, separator, missing);
  }
  return text;
}

}  // namespace equilux
