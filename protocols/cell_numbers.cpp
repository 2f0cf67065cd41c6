// Hashing of cells and of their keys.
#include "protocols/cell_numbers.h"

#include "base/random.h"

namespace equilux {

std::size_t CellNumbers::Hash::operator()(const Cell& cell) const {
  const Object& object = cell.column.object;
  // Names of two or three letters: a byte at a time is faster than what is made for long texts.
  std::size_t value = hash_name(object.geometry) * 31 + hash_name(object.material);
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
  return cells_[number_of(text, source, place)];
}

std::optional<std::uint32_t> CellReader::find(std::string_view text) const {
  const auto known = numbers_.find(text);
  return known != numbers_.end() ? std::optional(known->second) : std::nullopt;
}

std::uint32_t CellReader::number_of(std::string_view text, std::string_view source, std::string_view place) {
  if (const auto known = find(text)) return *known;
  cells_.push_back(parse_cell(text, source, place));
  return numbers_.emplace(text, static_cast<std::uint32_t>(cells_.size() - 1)).first->second;
}

}  // namespace equilux
