// Hashing of cells and of their keys.
#include "protocols/cell_numbers.h"

namespace equilux {

std::size_t CellNumbers::Hash::operator()(const Cell& cell) const {
  const Object& object = cell.column.object;
  const std::hash<std::string_view> hash;
  std::size_t value = hash(object.geometry) * 31 + hash(object.material);
  value = value * 31 + static_cast<std::size_t>(cell.column.vpl_count);
  return value * 64 + static_cast<std::size_t>(cell.clamp_level) * 4 +
         static_cast<std::size_t>(object.illumination) * 2 + (cell.normalised ? 1 : 0);
}

std::uint32_t CellNumbers::number_of(const Cell& cell) {
  const auto [entry, is_new] = numbers_.try_emplace(cell, static_cast<std::uint32_t>(cells_.size()));
  if (is_new) cells_.push_back(cell);
  return entry->second;
}

const Cell& CellReader::read(std::string_view text, std::string_view source, std::string_view place) {
  if (const auto known = cells_.find(text); known != cells_.end()) return known->second;
  return cells_.emplace(text, parse_cell(text, source, place)).first->second;
}

}  // namespace equilux
