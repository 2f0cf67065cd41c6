// Cells by number: what sums over millions of answers are indexed by.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "protocols/condition.h"

namespace equilux {

/// Numbers cells 0, 1, 2, ... as they come.
class CellNumbers {
 public:
  /// The cell's number, a new one where it has none.
  std::uint32_t number_of(const Cell& cell);
  /// The cells by their numbers.
  const std::vector<Cell>& cells() const { return cells_; }

 private:
  struct Hash {
    std::size_t operator()(const Cell& cell) const;
  };
  std::unordered_map<Cell, std::uint32_t, Hash> numbers_;
  std::vector<Cell> cells_;
};

/// Reads keys of cells, each different one once, and numbers them as they come.
class CellReader {
 public:
  /// As parse_cell. The reference holds until the next new key.
  const Cell& read(std::string_view text, std::string_view source, std::string_view place);
  /// The number of a key that was read before.
  std::optional<std::uint32_t> find(std::string_view text) const;
  /// The number of a key, which is read where it is new. errors: as parse_cell
  std::uint32_t number_of(std::string_view text, std::string_view source, std::string_view place);
  /// The cells by their numbers.
  const std::vector<Cell>& cells() const { return cells_; }

 private:
  struct Hash {
    using is_transparent = void;
    std::size_t operator()(std::string_view text) const { return std::hash<std::string_view>{}(text); }
  };
  std::unordered_map<std::string, std::uint32_t, Hash, std::equal_to<>> numbers_;
  std::vector<Cell> cells_;
};

}  // namespace equilux
