// One line a column: its name, type, unit, clock, meaning, and the way to its value.
#include "experiment/export_columns.h"

#include <fmt/format.h>

#include "experiment/field_notes.h"

namespace equilux {
namespace {

std::string text_of(bool value) { return value ? "1" : "0"; }
std::string text_of(std::int64_t value) { return fmt::format("{}", value); }
template <typename T>
std::string text_of(const std::optional<T>& value) {
  return value ? fmt::format("{}", *value) : "";
}
std::string text_of(Side side) { return side == Side::kLeft ? "left" : "right"; }

std::string format_seconds_exactly(std::int64_t ns) {
  constexpr std::int64_t kNsPerSecond = 1'000'000'000;
  return fmt::format("{}.{:09}", ns / kNsPerSecond, ns % kNsPerSecond);
}

const ColumnNote kSessionNote{"session", "text", "", "", "UUID of the session, the same in any log"};
const std::vector<std::pair<std::string, std::string>> kSides = {{"left", "the left of the lower pair"},
                                                                 {"right", "the right of the lower pair"}};
const std::vector<std::pair<std::string, std::string>> kStates = {
    {"complete", "every trial is answered"},
    {"unfinished", "interrupted, or going on at the time of the export"},
    {"aborted", "ended early with a reason, and not resumed"}};

using Session = const SessionRecord&;
using Field = const FieldRecord&;
using Trial = const TrialRecord&;
using Event = const EventRecord&;
using Participant = const ParticipantRecord&;

// Columns that both formats have, in this order.
std::vector<ExportColumn<TrialRecord>> make_shared_trial_columns() {
  return {
      {{"trial", "integer", "", "", "place in the order of showing, from 0"},
       [](Trial t) { return text_of(std::int64_t{t.trial.number}); }},
      {{"phase",
        "level",
        "",
        "",
        "why the pair was shown",
        {{"practice", "before the experiment, with feedback"},
         {"main", "the experiment; alone counted"},
         {"catch", "of a known answer, to tell whether the subject attends"}}},
       [](Trial t) { return format_phase(t.trial.phase); }},
      {{"cell", "text", "", "", "key of what is counted, the views pooled: G1-MR-ind-100k-C4"},
       [](Trial t) { return format_key(t.trial.cell); }},
      {{"geometry", "text", "", "", "of the test picture's object, from the cell"},
       [](Trial t) { return t.trial.cell.column.object.geometry; }},
      {{"material", "text", "", "", "of the test picture's object, from the cell"},
       [](Trial t) { return t.trial.cell.column.object.material; }},
      {{"illumination",
        "level",
        "",
        "",
        "from the cell",
        {{"ind", "no light reaches the object directly"}, {"dir", "an area fixture does too"}}},
       [](Trial t) { return format_illumination(t.trial.cell.column.object.illumination); }},
      {{"vpl_count", "integer", "VPLs", "", "virtual point lights of the test picture, from the cell"},
       [](Trial t) { return text_of(t.trial.cell.column.vpl_count); }},
      {{"clamp_level", "integer", "", "",
        "0: not clamped; i from 1: clamped at 10^(2.5 - (i-1)/2) per square metre; from the cell"},
       [](Trial t) { return text_of(std::int64_t{t.trial.cell.clamp_level}); }},
      {{"normalised", "0 or 1", "", "", "1: the test picture's luminance is normalised; from the cell"},
       [](Trial t) { return text_of(t.trial.cell.normalised); }},
      {{"test_view", "integer", "", "", "camera of the test picture, 0 or 1; from its key"},
       [](Trial t) { return text_of(std::int64_t{t.condition.view}); }},
      {{"test_key", "text", "", "", "the VPL picture"}, [](Trial t) { return t.trial.test_key; }},
      {{"pair_key", "text", "", "", "the reference beside it"}, [](Trial t) { return t.trial.pair_key; }},
      {{"upper_key", "text", "", "", "the reference above; none in the artifact experiment"},
       [](Trial t) { return t.trial.upper_key; }},
      {{"test_side", "level", "", "", "where the VPL picture stood; the correct answer", kSides},
       [](Trial t) { return text_of(t.trial.test_side); }},
      {{"answer", "level", "", "", "the side that was pressed; none until answered", kSides},
       [](Trial t) { return t.trial.answer ? text_of(*t.trial.answer) : ""; }},
      {{"correct", "0 or 1", "", "", "1: answer is test_side; none until answered"},
       [](Trial t) { return t.trial.answer ? text_of(t.trial.answer == t.trial.test_side) : ""; }},
      {{"too_fast", "0 or 1", "", "", "1: answered in less than the protocol's least time; kept and counted"},
       [](Trial t) { return text_of(t.trial.too_fast); }},
      {{"answered_utc", "text", "ISO 8601", "system",
        "when the answer was written; for people, not for measuring"},
       [](Trial t) { return t.trial.answered_utc.value_or(""); }},
      {{"counted", "0 or 1", "", "", "1: of the main phase of a complete session, so in every tally"},
       [](Trial t) { return text_of(t.session.row.complete && t.trial.phase == Phase::kMain); }}};
}

std::vector<ExportColumn<TrialRecord>> make_csv_trial_columns() {
  std::vector<ExportColumn<TrialRecord>> columns = {
      {kSessionNote, [](Trial t) { return t.session.row.uuid; }},
      {{"participant", "text", "", "", "code of the participant"},
       [](Trial t) { return t.session.row.participant; }},
      {{"experiment",
        "level",
        "",
        "",
        "the question that was asked",
        {{"artifact", "which picture has the artifacts"},
         {"material", "which object's material is different"}}},
       [](Trial t) { return format_experiment(t.session.row.experiment); }},
      {{"subject_index", "integer", "", "", "of the session"},
       [](Trial t) { return text_of(t.session.row.subject_index); }}};
  for (const auto& column : make_shared_trial_columns()) columns.push_back(column);
  columns.push_back({{"response_time_ns", "integer", "ns", "monotonic",
                      "from the onset of the last showing of the pair to the press; none until answered"},
                     [](Trial t) { return text_of(t.trial.response_time_ns); }});
  return columns;
}

std::vector<ExportColumn<TrialRecord>> make_bids_trial_columns() {
  std::vector<ExportColumn<TrialRecord>> columns = make_shared_trial_columns();
  columns.push_back({{"response_time", "real", "s", "monotonic",
                      "from the onset of the last showing of the pair to the press; none until answered"},
                     [](Trial t) {
                       return t.trial.response_time_ns ? format_seconds_exactly(*t.trial.response_time_ns)
                                                       : "";
                     }});
  return columns;
}

std::string format_states(Participant p, Experiment experiment) {
  std::vector<std::string> states;
  for (const SessionRecord* session : p.sessions) {
    if (session->row.experiment == experiment) states.push_back(format_state(session->summary.state));
  }
  return fmt::format("{}", fmt::join(states, " "));
}

template <typename Record>
std::vector<ColumnNote> notes_of(const std::vector<ExportColumn<Record>>& columns) {
  std::vector<ColumnNote> notes;
  for (const auto& column : columns) notes.push_back(column.note);
  return notes;
}

std::string format_type(const ColumnNote& note) {
  if (note.levels.empty()) return note.type;
  std::vector<std::string> levels;
  for (const auto& [level, meaning] : note.levels) levels.push_back(fmt::format("`{}`", level));
  return fmt::format("{}", fmt::join(levels, ", "));
}

std::string format_table(const TableNote& table) {
  std::string text =
      fmt::format("\n## {}\n{}\n\n| column | type | unit | clock | meaning |\n|---|---|---|---|---|\n",
                  table.name, table.meaning);
  for (const ColumnNote& note : table.columns) {
    text += fmt::format("| `{}` | {} | {} | {} | {} |\n", note.name, format_type(note), note.unit, note.clock,
                        note.meaning);
  }
  return text;
}

}  // namespace

const std::vector<ExportColumn<SessionRecord>>& session_columns() {
  static const std::vector<ExportColumn<SessionRecord>> columns = {
      {kSessionNote, [](Session s) { return s.row.uuid; }},
      {{"participant", "text", "", "", "code of the participant, by the experimenter"},
       [](Session s) { return s.row.participant; }},
      {{"kind",
        "level",
        "",
        "",
        "who answered; one kind in an export",
        {{"person", "somebody"},
         {"planted", "simulated, by thresholds put in"},
         {"looking", "simulated, from the pixels"}}},
       [](Session s) { return format_kind(s.row.kind); }},
      {{"experiment",
        "level",
        "",
        "",
        "the question that was asked",
        {{"artifact", "which picture has the artifacts"},
         {"material", "which object's material is different"}}},
       [](Session s) { return format_experiment(s.row.experiment); }},
      {{"subject_index", "integer", "", "", "from 0; decides views, sides and reference materials"},
       [](Session s) { return text_of(s.row.subject_index); }},
      {{"state", "level", "", "", "what became of it, from complete and the events", kStates},
       [](Session s) { return format_state(s.summary.state); }},
      {{"abort_reason", "text", "", "", "why it was ended early; none unless aborted"},
       [](Session s) { return s.summary.abort_reason; }},
      {{"complete", "0 or 1", "", "", "1: set after the last answer; only these sessions are counted"},
       [](Session s) { return text_of(s.row.complete); }},
      {{"trials", "integer", "trials", "", "scheduled, of all phases"},
       [](Session s) { return text_of(std::int64_t{s.summary.trials}); }},
      {{"answered", "integer", "trials", "", "answered, of all phases"},
       [](Session s) { return text_of(std::int64_t{s.summary.answered}); }},
      {{"started_utc", "text", "ISO 8601", "system", "when the session was begun"},
       [](Session s) { return s.row.started_utc; }},
      {{"station", "text", "", "", "random name of the log in which it was begun"},
       [](Session s) { return s.row.station; }},
      {{"seed", "integer", "", "", "decides the order of trials"},
       [](Session s) { return fmt::format("{}", s.row.seed); }},
      {{"program_version", "text", "", "", "of equilux-session when it was begun"},
       [](Session s) { return s.row.program_version; }},
      {{"study_digest", "text", "", "",
        "SHA-256 of study.json as canonical JSON (members sorted, no white space)"},
       [](Session s) { return s.row.digests.study; }},
      {{"manifest_digest", "text", "", "", "SHA-256 over all pictures that might be shown"},
       [](Session s) { return s.row.digests.manifest; }},
      {{"windows_digest", "text", "", "",
        "SHA-256 of windows.json as canonical JSON; none in the material experiment"},
       [](Session s) { return s.row.digests.windows; }},
      {{"selection_digest", "text", "", "", "SHA-256 of the selection; none in the artifact experiment"},
       [](Session s) { return s.row.digests.selection; }},
      {{"truth_digest", "text", "", "",
        "SHA-256 of the planted truth as canonical JSON; none unless planted"},
       [](Session s) { return s.row.digests.truth; }},
      {{"protocol_digest", "text", "", "",
        "SHA-256 of session.json as canonical JSON, without description, language and consent; none before "
        "schema 2"},
       [](Session s) { return s.row.digests.protocol; }},
      {{"monitor", "text", "", "", "the window system's name of the monitor; none if simulated"},
       [](Session s) { return s.row.screen.monitor; }},
      {{"framebuffer_width", "integer", "pixels", "", "of the window; none if simulated"},
       [](Session s) { return text_of(s.row.screen.framebuffer_width); }},
      {{"framebuffer_height", "integer", "pixels", "", "of the window; none if simulated"},
       [](Session s) { return text_of(s.row.screen.framebuffer_height); }},
      {{"viewing_distance_m", "real", "m", "", "as set up; none if simulated"},
       [](Session s) { return text_of(s.row.screen.viewing_distance_m); }},
      {{"degrees_wide", "real", "degrees of visual angle", "",
        "of one picture, as achieved; none if simulated"},
       [](Session s) { return text_of(s.row.screen.degrees_wide); }},
      {{"degrees_high", "real", "degrees of visual angle", "",
        "of one picture, as achieved; none if simulated"},
       [](Session s) { return text_of(s.row.screen.degrees_high); }}};
  return columns;
}

const std::vector<ExportColumn<FieldRecord>>& field_columns() {
  static const std::vector<ExportColumn<FieldRecord>> columns = {
      {kSessionNote, [](Field f) { return f.session.row.uuid; }},
      {{"name", "text", "", "",
        "what was asked or measured; the dictionary has a line for each, of the table fields.name"},
       [](Field f) { return f.name; }},
      {{"value", "text", "as the name says", "", "the answer or measurement"},
       [](Field f) { return f.value; }}};
  return columns;
}

const std::vector<ExportColumn<TrialRecord>>& trial_columns(ExportFormat format) {
  static const auto csv = make_csv_trial_columns(), bids = make_bids_trial_columns();
  return format == ExportFormat::kCsv ? csv : bids;
}

const std::vector<ExportColumn<EventRecord>>& event_columns() {
  static const std::vector<ExportColumn<EventRecord>> columns = {
      {kSessionNote, [](Event e) { return e.session.row.uuid; }},
      {{"number", "integer", "", "", "in the order of recording within the session, from 0"},
       [](Event e) { return text_of(std::int64_t{e.number}); }},
      {{"trial", "integer", "", "", "the pair; none for events of the whole session"},
       [](Event e) { return text_of(e.event.trial); }},
      {{"kind", "text", "", "",
        "showing, answer, resume, abort, interrupt, finish, and others of the window"},
       [](Event e) { return e.event.kind; }},
      {{"time_ns", "integer", "ns", "monotonic",
        "when it happened; differences mean something within one sitting only"},
       [](Event e) { return text_of(e.event.time_ns); }},
      {{"recorded_utc", "text", "ISO 8601", "system", "when it was written"},
       [](Event e) { return e.event.recorded_utc; }},
      {{"detail", "text", "", "",
        "of an abort or interrupt the reason, of a resume JSON; else as the kind has it"},
       [](Event e) { return e.event.detail; }}};
  return columns;
}

const std::vector<ExportColumn<ParticipantRecord>>& participant_columns() {
  static const std::vector<ExportColumn<ParticipantRecord>> columns = {
      {{"participant_id", "text", "", "",
        "sub- and the code; of a code that is not of letters and digits, these and 8 digits of its SHA-256"},
       [](Participant p) { return "sub-" + p.label; }},
      {{"participant_code", "text", "", "", "as the log has it, by the experimenter"},
       [](Participant p) { return p.code; }},
      {{"artifact", "text", "", "",
        "state of the sessions in the artifact experiment: complete, unfinished, aborted"},
       [](Participant p) { return format_states(p, Experiment::kArtifact); }},
      {{"material", "text", "", "",
        "state of the sessions in the material experiment: complete, unfinished, aborted"},
       [](Participant p) { return format_states(p, Experiment::kMaterial); }}};
  return columns;
}

std::vector<TableNote> describe_tables(ExportFormat format) {
  const auto trials = notes_of(trial_columns(format));
  if (format == ExportFormat::kBids) {
    return {{"participants", "A line for each participant.", notes_of(participant_columns())},
            {"beh", "A line for each scheduled trial of a session, of all phases.", trials}};
  }
  return {
      {"sessions", "A line for each session: one participant in one experiment.",
       notes_of(session_columns())},
      {"fields", "What was asked and measured at a session's start, a line each.", notes_of(field_columns())},
      {"trials", "A line for each scheduled trial, of all phases; counted says which are in tallies.",
       trials},
      {"events", "What happened, in order. Nothing of it is needed to count answers.",
       notes_of(event_columns())}};
}

std::string format_data_dictionary() {
  std::string text =
      "# Data dictionary of exports\n\nMade from the table in `experiment/export_columns.cpp`, of which the "
      "exported"
      " files are made too. An empty\nplace in a CSV file, and `n/a` in a BIDS file, is a value that there "
      "is none"
      " of. *Monotonic* is the clock of the program\nthat ran the session, *system* that of the computer, UTC"
      " ([more](responses.md)).\n\n# CSV\n`sessions.csv`, `fields.csv`, `trials.csv`, `events.csv`, and"
      " `dictionary.csv`, which says of them what stands here.\n";
  for (const TableNote& table : describe_tables(ExportFormat::kCsv)) text += format_table(table);
  text += format_table({"fields.name", "What each `name` of `fields` says.", field_notes()});
  text += "\n# BIDS\n`participants.tsv` and `sub-LABEL/beh/sub-LABEL_task-EXPERIMENT_beh.tsv`.\n";
  for (const TableNote& table : describe_tables(ExportFormat::kBids)) text += format_table(table);
  return text;
}

}  // namespace equilux
