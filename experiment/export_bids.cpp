// The answers as a BIDS folder. source: Brain Imaging Data Structure 1.8.0, "Common principles", "Modality
// agnostic files" and "Behavioral experiments (with no neural recordings)".
#include <algorithm>
#include <cctype>
#include <map>

#include "base/digest.h"
#include "base/error.h"
#include "base/json.h"
#include "base/version.h"
#include "experiment/delimited.h"
#include "experiment/export_log.h"

namespace equilux {
namespace {

constexpr const char* kMissing = "n/a";

bool is_alphanumeric(char c) { return std::isalnum(static_cast<unsigned char>(c)) && (c & 0x80) == 0; }

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::vector<ParticipantRecord> list_participants(const std::vector<SessionRecord>& records) {
  std::map<std::string, ParticipantRecord> by_code;
  for (const SessionRecord& record : records) {
    const std::string& code = record.row.participant;
    auto& participant =
        by_code.try_emplace(code, ParticipantRecord{make_bids_label(code), code, {}}).first->second;
    participant.sessions.push_back(&record);
  }
  std::vector<ParticipantRecord> participants;
  for (auto& [code, participant] : by_code) participants.push_back(std::move(participant));
  return participants;
}

// File systems that do not tell a from A would keep one of the two.
void check_labels(const std::vector<ParticipantRecord>& participants) {
  std::map<std::string, std::string> codes;
  for (const ParticipantRecord& participant : participants) {
    const auto [place, is_new] = codes.emplace(lower(participant.label), participant.code);
    if (!is_new)
      throw InputError("log", "participant/code", "codes that differ in more than the case of letters",
                       fmt::format("{} and {}", place->second, participant.code));
  }
}

Json describe_column(const ColumnNote& note) {
  Json json;
  json.set("Description",
           note.clock.empty() ? note.meaning : fmt::format("{} ({} clock)", note.meaning, note.clock));
  if (!note.unit.empty()) json.set("Units", note.unit);
  if (note.levels.empty()) return json;
  Json levels;
  for (const auto& [level, meaning] : note.levels) levels.set(level, meaning);
  return json.set("Levels", std::move(levels));
}

template <typename Record>
void describe_columns(Json& json, const std::vector<ExportColumn<Record>>& columns) {
  for (const auto& column : columns) json.set(column.note.name, describe_column(column.note));
}

std::string format_description(const Study& study, SubjectKind kind) {
  Json generated{Json::Array{}};
  generated.push(Json().set("Name", "equilux-session").set("Version", kVersion));
  Json json;
  json.set("Name", fmt::format("{}: answers of kind {}", study.name, format_kind(kind)));
  json.set("BIDSVersion", "1.8.0").set("DatasetType", "raw").set("GeneratedBy", std::move(generated));
  return format_json(json);
}

std::string format_readme(const Study& study, SubjectKind kind) {
  return fmt::format(
      "Answers to the study {} (digest {}), of kind {}.\n\nOne folder a participant, one table a session: "
      "two-alternative"
      " forced choice without time limit, artifact or material.\nOnly lines with counted = 1 are in tallies. "
      "The JSON"
      " file beside each table describes its columns and its session.\n{}",
      study.name, study.digest, format_kind(kind),
      kind == SubjectKind::kPerson ? "" : "\nSIMULATED answers: they tell nothing about persons.\n");
}

std::string format_participant_sidecar() {
  Json json;
  describe_columns(json, participant_columns());
  return format_json(json);
}

// What CSV has in sessions.csv and fields.csv; what is not known is left out.
Json describe_session(const SessionRecord& record) {
  Json session;
  for (const auto& column : session_columns()) {
    const std::string value = column.value(record);
    if (!value.empty() && column.note.name != "participant") session.set(column.note.name, value);
  }
  Json fields{Json::Object{}};
  for (const auto& [name, value] : record.row.fields) fields.set(name, value);
  return session.set("fields", std::move(fields));
}

// As the subject read it; sessions of older programs recorded no question.
std::string find_prompt(const SessionRow& row) {
  const auto recorded = row.fields.find("prompt");
  return recorded == row.fields.end() ? prompt_of(row.experiment) : recorded->second;
}

std::string format_session_sidecar(const SessionRecord& record) {
  Json json;
  json.set("TaskName", format_experiment(record.row.experiment));
  json.set("Instructions", find_prompt(record.row));
  json.set("EquiluxSession", describe_session(record));
  describe_columns(json, trial_columns(ExportFormat::kBids));
  return format_json(json);
}

std::string format_session_table(const SessionRecord& record) {
  std::vector<TrialRecord> trials;
  for (const TrialRow& trial : record.trials)
    trials.push_back({record, trial, parse_condition(trial.test_key, "log", "trial/test_key")});
  return format_records(trial_columns(ExportFormat::kBids), trials, '\t', kMissing);
}

// A participant has one session in an experiment, but where logs were merged; then runs tell them apart.
void add_sessions(ExportFiles& files, const ParticipantRecord& participant) {
  std::map<Experiment, int> totals, runs;
  for (const SessionRecord* session : participant.sessions) ++totals[session->row.experiment];
  for (const SessionRecord* session : participant.sessions) {
    const Experiment task = session->row.experiment;
    const std::string run = totals[task] > 1 ? fmt::format("_run-{}", ++runs[task]) : "";
    const std::string stem =
        fmt::format("sub-{0}/beh/sub-{0}_task-{1}{2}_beh", participant.label, format_experiment(task), run);
    files[stem + ".tsv"] = format_session_table(*session);
    files[stem + ".json"] = format_session_sidecar(*session);
  }
}

}  // namespace

std::string make_bids_label(const std::string& code) {
  std::string label;
  std::copy_if(code.begin(), code.end(), std::back_inserter(label), is_alphanumeric);
  constexpr std::size_t kDigits = 8;
  return label == code ? label : label + digest_text(code).substr(0, kDigits);
}

ExportFiles make_bids_export(const std::vector<SessionRecord>& records, const Study& study,
                             SubjectKind kind) {
  const auto participants = list_participants(records);
  check_labels(participants);
  ExportFiles files;
  files["dataset_description.json"] = format_description(study, kind);
  files["README"] = format_readme(study, kind);
  files[".bidsignore"] = fmt::format("{}\n", kExportRecord);
  files["participants.tsv"] = format_records(participant_columns(), participants, '\t', kMissing);
  files["participants.json"] = format_participant_sidecar();
  for (const ParticipantRecord& participant : participants) add_sessions(files, participant);
  files[kExportRecord] = format_export_record(files, study, kind, ExportFormat::kBids);
  return files;
}

}  // namespace equilux
