// Files with one row a column of the study: each column once, none missing, none unknown.
#pragma once

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "base/error.h"
#include "protocols/study.h"

namespace equilux {

/// Reads rows with a member "column" into a map that covers the study exactly. `read(row, place)` makes the
/// value. errors: InputError naming the row, or the column that is missing.
template <typename T, typename Read>
std::map<Column, T> read_by_column(const Json& rows, const Study& study, const std::string& source,
                                   const std::string& place, const Read& read) {
  const auto columns = enumerate_columns(study);
  const std::set<Column> known(columns.begin(), columns.end());
  std::map<Column, T> values;
  for (std::size_t i = 0; i < rows.as_array().size(); ++i) {
    const Json& row = rows.at(i);
    const std::string row_place = fmt::format("{}/{}", place, i);
    const Column column = parse_column(row.at("column").as_string(), source, row_place + "/column");
    if (!known.contains(column)) {
      throw InputError(source, row_place + "/column", fmt::format("a column of the study {}", study.name),
                       format_key(column));
    }
    if (!values.emplace(column, read(row, row_place)).second) {
      throw InputError(source, row_place + "/column", "each column once", format_key(column) + " again");
    }
  }
  for (const Column& column : columns) {
    if (!values.contains(column)) {
      throw InputError(source, place, fmt::format("a row for {}", format_key(column)), "none");
    }
  }
  return values;
}

}  // namespace equilux
