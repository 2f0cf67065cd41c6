// The one place where keys are written and read.
#include "protocols/condition.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "base/error.h"

namespace equilux {
namespace {

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t dash = text.find('-');
    parts.push_back(text.substr(0, dash));
    if (dash == std::string_view::npos) return parts;
    text.remove_prefix(dash + 1);
  }
}

std::optional<std::int64_t> read_digits(std::string_view text, std::int64_t limit) {
  if (text.empty() || text.size() > 15 || (text.size() > 1 && text[0] == '0')) return std::nullopt;
  std::int64_t value = 0;
  for (char digit : text) {
    if (digit < '0' || digit > '9') return std::nullopt;
    value = 10 * value + (digit - '0');
  }
  return value <= limit ? std::optional(value) : std::nullopt;
}

std::optional<Illumination> read_illumination(std::string_view text) {
  if (text == "ind") return Illumination::kIndirect;
  if (text == "dir") return Illumination::kDirectAndIndirect;
  return std::nullopt;
}

std::optional<std::int64_t> read_vpl_count(std::string_view text) {
  if (text.empty()) return std::nullopt;
  const std::int64_t unit = text.back() == 'k' ? 1000 : text.back() == 'M' ? 1000000 : 1;
  if (unit > 1) text.remove_suffix(1);
  const auto number = read_digits(text, 1000000000);
  if (!number || *number == 0 || *number * unit > 1000000000) return std::nullopt;
  return *number * unit;
}

struct ClampToken {
  int level;
  bool normalised;
};

std::optional<ClampToken> read_clamp(std::string_view text) {
  if (text.size() < 2 || text[0] != 'C') return std::nullopt;
  const bool normalised = text.back() == 'n';
  const auto level =
      read_digits(text.substr(1, text.size() - 1 - (normalised ? 1 : 0)), kClampLevelCount - 1);
  if (!level) return std::nullopt;
  return ClampToken{static_cast<int>(*level), normalised};
}

std::optional<int> read_view(std::string_view text) {
  if (text.size() != 2 || text[0] != 'v') return std::nullopt;
  const auto view = read_digits(text.substr(1), kViewCount - 1);
  return view ? std::optional(static_cast<int>(*view)) : std::nullopt;
}

std::optional<Object> read_object(const std::vector<std::string_view>& parts) {
  if (parts.size() < 3 || !is_token(parts[0]) || !is_token(parts[1])) return std::nullopt;
  const auto illumination = read_illumination(parts[2]);
  if (!illumination) return std::nullopt;
  return Object{std::string(parts[0]), std::string(parts[1]), *illumination};
}

std::optional<Column> read_column(const std::vector<std::string_view>& parts) {
  const auto object = read_object(parts);
  if (!object || parts.size() < 4) return std::nullopt;
  const auto count = read_vpl_count(parts[3]);
  if (!count || format_vpl_count(*count) != parts[3]) return std::nullopt;
  return Column{*object, *count};
}

std::optional<Cell> read_cell(const std::vector<std::string_view>& parts) {
  const auto column = read_column(parts);
  if (!column || parts.size() < 5) return std::nullopt;
  const auto clamp = read_clamp(parts[4]);
  if (!clamp) return std::nullopt;
  return Cell{*column, clamp->level, clamp->normalised};
}

template <typename T>
T require(const std::optional<T>& value, std::string_view text, std::string_view form,
          std::string_view source, std::string_view place) {
  if (!value) throw InputError(source, place, form, fmt::format("\"{}\"", text.substr(0, 80)));
  return *value;
}

}  // namespace

double clamp_per_m2(int clamp_level) {
  EQ_CHECK(clamp_level >= 0 && clamp_level < kClampLevelCount, clamp_level);
  if (clamp_level == 0) return std::numeric_limits<double>::infinity();
  return std::pow(10.0, 2.5 - (clamp_level - 1) / 2.0);
}

bool is_token(std::string_view text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  return !text.empty() && text.size() <= 32 && is_letter(text[0]) &&
         std::all_of(text.begin(), text.end(),
                     [&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); });
}

bool is_vpl_count(std::string_view text) { return read_vpl_count(text).has_value(); }

std::string format_illumination(Illumination illumination) {
  return illumination == Illumination::kIndirect ? "ind" : "dir";
}

std::string format_vpl_count(std::int64_t vpl_count) {
  if (vpl_count % 1000000 == 0) return std::to_string(vpl_count / 1000000) + 'M';
  if (vpl_count % 1000 == 0) return std::to_string(vpl_count / 1000) + 'k';
  return std::to_string(vpl_count);
}

std::string format_clamp(int clamp_level, bool normalised) {
  return 'C' + std::to_string(clamp_level) + (normalised ? "n" : "");
}

std::string format_key(const Object& object) {
  return object.geometry + '-' + object.material + '-' + format_illumination(object.illumination);
}

std::string format_key(const Column& column) {
  return format_key(column.object) + '-' + format_vpl_count(column.vpl_count);
}

std::string format_key(const Cell& cell) {
  return format_key(cell.column) + '-' + format_clamp(cell.clamp_level, cell.normalised);
}

std::string format_key(const Condition& condition) {
  return fmt::format("{}-v{}", format_key(condition.cell), condition.view);
}

std::string format_key(const Family& family) {
  return fmt::format("{}-ref-v{}", format_key(family.object), family.view);
}

Illumination parse_illumination(std::string_view text, std::string_view source, std::string_view place) {
  return require(read_illumination(text), text, "ind or dir", source, place);
}

std::int64_t parse_vpl_count(std::string_view text, std::string_view source, std::string_view place) {
  return require(read_vpl_count(text), text, "a VPL count such as 1k, 100k or 5M, at most 1000M", source,
                 place);
}

int parse_clamp_level(std::string_view text, std::string_view source, std::string_view place) {
  const auto clamp = require(read_clamp(text), text, "a clamp level C0 .. C10", source, place);
  if (clamp.normalised)
    throw InputError(source, place, "a clamp level C0 .. C10", fmt::format("\"{}\"", text));
  return clamp.level;
}

Column parse_column(std::string_view text, std::string_view source, std::string_view place) {
  const auto parts = split(text);
  return require(parts.size() == 4 ? read_column(parts) : std::nullopt, text,
                 "a column such as G1-MR-ind-100k", source, place);
}

Cell parse_cell(std::string_view text, std::string_view source, std::string_view place) {
  const auto parts = split(text);
  return require(parts.size() == 5 ? read_cell(parts) : std::nullopt, text,
                 "a cell such as G1-MR-ind-100k-C4", source, place);
}

Condition parse_condition(std::string_view text, std::string_view source, std::string_view place) {
  const auto parts = split(text);
  const char* form = "a picture's key such as G1-MR-ind-100k-C4-v0";
  const auto cell = require(parts.size() == 6 ? read_cell(parts) : std::nullopt, text, form, source, place);
  return {cell, require(read_view(parts[5]), text, form, source, place)};
}

Family parse_family(std::string_view text, std::string_view source, std::string_view place) {
  const auto parts = split(text);
  const char* form = "a reference's key such as G1-MR-ind-ref-v0";
  const bool is_reference = parts.size() == 5 && parts[3] == "ref";
  const auto object = require(is_reference ? read_object(parts) : std::nullopt, text, form, source, place);
  return {object, require(read_view(parts[4]), text, form, source, place)};
}

Family family_of(const Condition& condition) { return {condition.cell.column.object, condition.view}; }

}  // namespace equilux
