// The workspace's arithmetic.
#include "experiment/browse.h"

#include <algorithm>

#include "base/error.h"
#include "base/files.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

int find_place(const std::vector<int>& levels, int level) {
  return static_cast<int>(std::find(levels.begin(), levels.end(), level) - levels.begin());
}

// The first level of a window moved along the study's levels: those of a window are adjacent numbers.
int shift_level(const Study& study, int first, int steps) {
  const auto& levels = study.clamp_levels;
  int best = first;
  const int direction = steps > 0 ? 1 : -1;
  for (int moved = 0; moved != steps; moved += direction) {
    const int next = best + direction;
    const int place = find_place(levels, next);
    const bool fits = place + kWindowLevels <= static_cast<int>(levels.size()) &&
                      levels[static_cast<std::size_t>(place + kWindowLevels - 1)] == next + kWindowLevels - 1;
    if (!fits) break;
    best = next;
  }
  return best;
}

void check_not_begun(const StudyFolder& folder) {
  if (!TrialLog::is_at(folder.responses())) return;
  for (const SessionRow& row : TrialLog::load_snapshot(folder.responses()).load_sessions()) {
    if (row.experiment != Experiment::kArtifact) continue;
    throw InputError(
        folder.windows().string(), "", "windows that no artifact session was made from",
        fmt::format("session {} of {}; other windows need a new folder", row.id, row.participant));
  }
}

}  // namespace

Holding find_holding(const Study& study, const std::optional<Manifest>& manifest, const fs::path& root) {
  Holding holding;
  const auto is_there = [&](const std::string& key) {
    if (!manifest) return false;
    const auto picture = manifest->pictures.find(key);
    return picture != manifest->pictures.end() && is_file(root / picture->second.file);
  };
  const auto look = [&](const std::string& key) {
    if (is_there(key)) {
      ++holding.there;
    } else {
      holding.missing.push_back(key);
    }
  };
  for (const Condition& condition : enumerate_conditions(study)) look(format_key(condition));
  for (const Family& family : enumerate_references(study)) look(format_key(family));
  return holding;
}

Coverage tally_coverage(const std::vector<AnswerRow>& answers) {
  Coverage coverage;
  for (const AnswerRow& answer : answers) {
    CellCount& count = coverage[answer.cell];
    ++count.answered;
    count.right += answer.correct ? 1 : 0;
  }
  return coverage;
}

Json shift_window(const Study& study, const Json& windows, const Column& column, int steps) {
  Json rows{Json::Array{}};
  bool is_found = false;
  for (const Json& row : windows.at("windows").as_array()) {
    Json moved = row;
    if (row.at("column").as_string() == format_key(column)) {
      is_found = true;
      const int first = parse_clamp_level(row.at("first").as_string(), "windows", "/first");
      moved.set("first", format_clamp(shift_level(study, first, steps))).set("origin", "by_eye");
    }
    rows.push(std::move(moved));
  }
  if (!is_found) throw InputError("windows", "/windows", "a window of " + format_key(column), "none");
  Json all = windows;
  all.set("windows", std::move(rows));
  return all;
}

Windows save_shifted_window(const StudyFolder& folder, const Study& study, const Column& column, int steps) {
  check_not_begun(folder);
  const Windows windows = load_windows(folder.windows(), study);
  save_text(folder.windows(), format_json(shift_window(study, windows.source, column, steps)));
  return load_windows(folder.windows(), study);
}

LdrImage make_difference(const LdrImage& picture, const LdrImage& reference, int gain) {
  EQ_CHECK(picture.values.size() == reference.values.size(), picture.width, reference.width);
  LdrImage difference = picture;
  for (std::size_t i = 0; i < picture.values.size(); ++i) {
    const int value =
        128 + gain * (static_cast<int>(picture.values[i]) - static_cast<int>(reference.values[i]));
    difference.values[i] = static_cast<std::uint8_t>(std::clamp(value, 0, 255));
  }
  return difference;
}

LdrImage make_thumbnail(const LdrImage& picture, int factor) {
  EQ_CHECK(factor >= 1, factor);
  LdrImage small(picture.width / factor, picture.height / factor);
  const auto value_at = [&](int x, int y, int c) {
    return static_cast<unsigned>(picture.values[static_cast<std::size_t>((y * picture.width + x) * 3 + c)]);
  };
  const auto count = static_cast<unsigned>(factor * factor);
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        unsigned sum = 0;
        for (int i = 0; i < factor * factor; ++i)
          sum += value_at(x * factor + i % factor, y * factor + i / factor, c);
        small.values[static_cast<std::size_t>((y * small.width + x) * 3 + c)] =
            static_cast<std::uint8_t>((sum + count / 2) / count);
      }
    }
  }
  return small;
}

}  // namespace equilux
