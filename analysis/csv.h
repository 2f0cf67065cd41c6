// Tables as comma-separated values (RFC 4180, lines ended by a line feed).
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace equilux {

/// shape: every row has as many fields as there are columns.
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  bool operator==(const Table&) const = default;
};

std::string format_csv(const Table& table);

/// Exact inverse of format_csv. errors: InputError naming `source` and the line.
Table parse_csv(std::string_view text, std::string_view source);

}  // namespace equilux
