// selection-<kind>.json, read and written.
#include "stimuli/selection.h"

#include <algorithm>

#include "base/files.h"
#include "base/version.h"
#include "protocols/by_column.h"

namespace equilux {

extern const char kSelectionSchema[];

namespace {

Json content_of(const Selection& selection) {
  Json json;
  json.set("schema", "equilux-selection").set("schema_version", 1);
  json.set("kind", format_kind(selection.kind)).set("rule", selection.rule);
  json.set("study_digest", selection.study_digest).set("answers_digest", selection.answers_digest);
  Json columns{Json::Array{}};
  for (const SelectedColumn& column : selection.columns) {
    Json levels{Json::Array{}};
    for (int level : column.levels) levels.push(format_clamp(level));
    Json row;
    row.set("column", format_key(column.column)).set("status", column.status);
    row.set("artifact_cut", column.artifact_cut ? format_clamp(*column.artifact_cut) : "none");
    row.set("levels", std::move(levels));
    columns.push(std::move(row));
  }
  json.set("columns", std::move(columns));
  return json;
}

}  // namespace

std::string digest_selection(const Selection& selection) { return digest_json(content_of(selection)); }

Selection load_selection(const std::filesystem::path& path, const Study& study) {
  const Json json = load_json(path, kSelectionSchema);
  Selection selection;
  selection.kind = parse_kind(json.at("kind").as_string(), path.string(), "/kind");
  selection.rule = json.at("rule").as_string();
  selection.study_digest = json.at("study_digest").as_string();
  selection.answers_digest = json.at("answers_digest").as_string();
  if (selection.study_digest != study.digest) {
    throw InputError(path.string(), "/study_digest", fmt::format("{}, the study's", study.digest),
                     selection.study_digest);
  }
  const auto by_column = read_by_column<SelectedColumn>(
      json.at("columns"), study, path.string(), "/columns", [&](const Json& row, const std::string& place) {
        SelectedColumn column;
        column.column = parse_column(row.at("column").as_string(), path.string(), place + "/column");
        column.status = row.at("status").as_string();
        const std::string& cut = row.at("artifact_cut").as_string();
        if (cut != "none")
          column.artifact_cut = parse_clamp_level(cut, path.string(), place + "/artifact_cut");
        for (const std::string& text : row.at("levels").as_strings()) {
          column.levels.push_back(parse_clamp_level(text, path.string(), place + "/levels"));
          if (std::find(study.clamp_levels.begin(), study.clamp_levels.end(), column.levels.back()) ==
              study.clamp_levels.end()) {
            throw InputError(path.string(), place + "/levels", "clamp levels of the study", text);
          }
          if (column.artifact_cut && column.levels.back() < *column.artifact_cut)
            throw InputError(path.string(), place + "/levels",
                             fmt::format("levels from the artifact cut {} on", cut), text);
        }
        return column;
      });
  for (const Json& row : json.at("columns").as_array()) {
    selection.columns.push_back(by_column.at(parse_column(row.at("column").as_string(), path.string())));
  }
  return selection;
}

void save_selection(const Selection& selection, const std::filesystem::path& path) {
  Json json = content_of(selection);
  json.set("producer_version", kVersion);
  save_text(path, format_json(json));
}

std::vector<Cell> enumerate_selected_cells(const Selection& selection, const Study& study) {
  std::vector<Cell> cells;
  for (const SelectedColumn& column : selection.columns) {
    for (int level : column.levels) cells.push_back({column.column, level, study.normalise});
  }
  return cells;
}

}  // namespace equilux
