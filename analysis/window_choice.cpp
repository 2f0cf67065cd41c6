// Cuts to windows.
#include "analysis/window_choice.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>

#include "analysis/csv.h"
#include "base/error.h"

namespace equilux {
namespace {

constexpr std::int64_t kPredictedN = 1'000'000;

int find_first_tested(const ColumnCounts& counts) {
  const auto found =
      std::find_if(counts.begin(), counts.end(), [](const auto& level) { return level.count.n > 0; });
  return found->level;
}

// As parse_csv wants it: without a BOM, lines ended by a line feed, none blank at the end.
std::string tidy_lines(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  const std::size_t last = text.find_last_not_of(" \t\r\n");
  text = text.substr(0, last == text.npos ? 0 : last + 1);
  std::string tidy;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text.substr(i, 2) != "\r\n") tidy += text[i];
  }
  return tidy + "\n";
}

void check_columns(const Table& table, std::string_view source) {
  std::set<std::string> names;
  for (const std::string& name : table.columns) {
    if (!names.insert(name).second)
      throw InputError(source, "line 1", "columns of different names",
                       fmt::format("two of the name \"{}\"", name.substr(0, 80)));
  }
}

std::size_t place_of(const Table& table, const std::string& name, std::string_view source) {
  const auto found = std::find(table.columns.begin(), table.columns.end(), name);
  if (found == table.columns.end())
    throw InputError(source, "line 1", "the columns column, clamp and proportion",
                     fmt::format("no {}", name));
  return static_cast<std::size_t>(found - table.columns.begin());
}

double parse_proportion(const std::string& text, std::string_view source, const std::string& place) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(value >= 0 && value <= 1))
    throw InputError(source, place, "a proportion of 0 to 1", fmt::format("\"{}\"", text.substr(0, 80)));
  return value;
}

// As cells.csv spells it, "C4n" of a normalised study, or without the n.
int parse_level(const std::string& text, const Study& study, std::string_view source,
                const std::string& place) {
  const bool is_marked = study.normalise && text.ends_with('n');
  return parse_clamp_level(is_marked ? text.substr(0, text.size() - 1) : text, source, place);
}

// Whether a window that begins at this level has all its levels in the study.
bool is_start(int first, const std::vector<int>& clamp_levels) {
  for (int level = first; level < first + kWindowLevels; ++level) {
    if (std::find(clamp_levels.begin(), clamp_levels.end(), level) == clamp_levels.end()) return false;
  }
  return true;
}

// The nearest to the level that is wanted, of two the less clamped.
int find_start(int wanted, const std::vector<int>& clamp_levels) {
  std::optional<int> best;
  for (const int level : clamp_levels) {
    if (is_start(level, clamp_levels) && (!best || std::abs(level - wanted) < std::abs(*best - wanted)))
      best = level;
  }
  if (best) return *best;
  std::vector<std::string> names;
  for (const int level : clamp_levels) names.push_back(format_clamp(level));
  throw InputError("study", "/clamp_levels", fmt::format("{} adjacent clamp levels", kWindowLevels),
                   fmt::format("{}", fmt::join(names, " ")));
}

}  // namespace

std::optional<int> choose_first_level(const ColumnCounts& counts, const std::vector<int>& clamp_levels,
                                      Rule rule, int percent) {
  const Threshold threshold = find_cut(counts, Experiment::kArtifact, rule, percent);
  switch (threshold.status) {
    case CutStatus::kUntested:
      return std::nullopt;
    case CutStatus::kCensoredLow:
      return find_start(find_first_tested(counts) - kWindowLevels + 1, clamp_levels);
    case CutStatus::kCensoredHigh:
      return find_start(*threshold.cut - 1, clamp_levels);
    case CutStatus::kNone:
      return find_start(clamp_levels.back(), clamp_levels);
    case CutStatus::kCut:
      break;
  }
  return find_start(*threshold.cut - kWindowLevels / 2, clamp_levels);
}

std::map<Column, Window> choose_windows(const Study& study, const Tally& artifact, const Windows& standing,
                                        Rule rule, WindowOrigin origin) {
  std::map<Column, Window> windows;
  for (const Column& column : enumerate_columns(study)) {
    const auto first = choose_first_level(counts_of(artifact, column, study), study.clamp_levels, rule);
    windows[column] = first ? Window{*first, origin} : standing.by_column.at(column);
  }
  return windows;
}

Tally parse_prediction(std::string_view text, std::string_view source, const Study& study) {
  Tally tally;
  for (const Cell& cell : enumerate_cells(study)) tally[cell] = {};
  const Table table = parse_csv(tidy_lines(text), source);
  check_columns(table, source);
  const std::size_t column = place_of(table, "column", source), clamp = place_of(table, "clamp", source),
                    proportion = place_of(table, "proportion", source);
  if (table.rows.empty())
    throw InputError(source, "line 2", "a row for each cell that is predicted", "the end of the file");
  std::map<Cell, std::string> places;
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    const std::string place = fmt::format("line {}", row + 2);
    const Cell cell{parse_column(table.rows[row][column], source, place),
                    parse_level(table.rows[row][clamp], study, source, place), study.normalise};
    const auto found = tally.find(cell);
    if (found == tally.end())
      throw InputError(source, place, fmt::format("a cell of the study {}", study.name), format_key(cell));
    const auto [first, is_new] = places.try_emplace(cell, place);
    if (!is_new)
      throw InputError(source, place, "one row for each cell",
                       fmt::format("{} again, as in {}", format_key(cell), first->second));
    const double value = parse_proportion(table.rows[row][proportion], source, place);
    found->second = {std::llround(value * static_cast<double>(kPredictedN)), kPredictedN};
  }
  return tally;
}

std::string format_windows(const std::map<Column, Window>& windows, const Study& study,
                           std::string_view description) {
  Json rows{Json::Array{}};
  for (const Column& column : enumerate_columns(study)) {
    const Window& window = windows.at(column);
    Json row;
    row.set("column", format_key(column)).set("first", format_clamp(window.first_level));
    rows.push(std::move(row.set("origin", format_origin(window.origin))));
  }
  Json json;
  json.set("schema", "equilux-windows").set("schema_version", 1).set("description", description);
  return format_json(json.set("windows", std::move(rows)));
}

}  // namespace equilux
