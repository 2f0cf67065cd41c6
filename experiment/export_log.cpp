// From a snapshot of the log to tidy tables.
#include "experiment/export_log.h"

#include <algorithm>
#include <fmt/format.h>
#include <tuple>

#include "base/digest.h"
#include "base/json.h"
#include "base/version.h"
#include "experiment/delimited.h"
#include "experiment/field_notes.h"

namespace equilux {
namespace {

std::vector<FieldRecord> list_fields(const std::vector<SessionRecord>& records) {
  std::vector<FieldRecord> fields;
  for (const SessionRecord& record : records) {
    for (const auto& [name, value] : record.row.fields) fields.push_back({record, name, value});
  }
  return fields;
}

std::vector<TrialRecord> list_trials(const std::vector<SessionRecord>& records) {
  std::vector<TrialRecord> trials;
  for (const SessionRecord& record : records) {
    for (const TrialRow& trial : record.trials)
      trials.push_back({record, trial, parse_condition(trial.test_key, "log", "trial/test_key")});
  }
  return trials;
}

std::vector<EventRecord> list_events(const std::vector<SessionRecord>& records) {
  std::vector<EventRecord> events;
  for (const SessionRecord& record : records) {
    for (int i = 0; const EventRow& event : record.events) events.push_back({record, i++, event});
  }
  return events;
}

std::string format_levels(const ColumnNote& note) {
  if (note.levels.empty()) return note.type;
  std::vector<std::string> levels;
  for (const auto& [level, meaning] : note.levels) levels.push_back(level + ": " + meaning);
  return fmt::format("{}", fmt::join(levels, "; "));
}

std::string format_dictionary() {
  std::string text = format_fields({"table", "column", "type", "unit", "clock", "meaning"}, ',', "");
  std::vector<TableNote> tables = describe_tables(ExportFormat::kCsv);
  tables.push_back({"fields.name", "", field_notes()});
  for (const TableNote& table : tables) {
    for (const ColumnNote& note : table.columns)
      text += format_fields({table.name, note.name, format_levels(note), note.unit, note.clock, note.meaning},
                            ',', "");
  }
  return text;
}

}  // namespace

std::vector<SessionRecord> load_records(const TrialLog& log, SubjectKind kind) {
  std::vector<SessionRecord> records;
  for (const SessionRow& row : log.load_sessions()) {
    if (row.kind != kind) continue;
    SessionRecord record{row, log.load_trials(row.id), log.load_events(row.id), {}};
    record.summary = find_outcome(record.row, record.trials, record.events);
    records.push_back(std::move(record));
  }
  const auto order = [](const SessionRecord& record) {
    return std::tie(record.row.experiment, record.row.subject_index, record.row.started_utc, record.row.uuid);
  };
  std::sort(records.begin(), records.end(),
            [&](const auto& a, const auto& b) { return order(a) < order(b); });
  return records;
}

ExportFiles make_csv_export(const std::vector<SessionRecord>& records, const Study& study, SubjectKind kind) {
  ExportFiles files;
  files["sessions.csv"] = format_records(session_columns(), records, ',');
  files["fields.csv"] = format_records(field_columns(), list_fields(records), ',');
  files["trials.csv"] = format_records(trial_columns(ExportFormat::kCsv), list_trials(records), ',');
  files["events.csv"] = format_records(event_columns(), list_events(records), ',');
  files["dictionary.csv"] = format_dictionary();
  files[kExportRecord] = format_export_record(files, study, kind, ExportFormat::kCsv);
  return files;
}

std::string format_export_record(const ExportFiles& files, const Study& study, SubjectKind kind,
                                 ExportFormat format) {
  Json record;
  record.set("schema", "equilux-export").set("schema_version", 1).set("program_version", kVersion);
  record.set("format", format == ExportFormat::kCsv ? "csv" : "bids").set("kind", format_kind(kind));
  record.set("study", study.name).set("study_digest", study.digest);
  Json list{Json::Array{}};
  for (const auto& [name, bytes] : files)
    list.push(Json().set("file", name).set("digest", digest_text(bytes)));
  return format_json(record.set("files", std::move(list)));
}

}  // namespace equilux
