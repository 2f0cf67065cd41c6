// Every column of an export: what it holds, and from where it is taken. The one table of which the files, the
// data dictionary and docs/data-dictionary.md are made.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "experiment/session_outcome.h"
#include "experiment/trial_log.h"

namespace equilux {

enum class ExportFormat { kCsv, kBids };

/// A session with all that belongs to it.
struct SessionRecord {
  SessionRow row;
  std::vector<TrialRow> trials;
  std::vector<EventRow> events;
  SessionOutcome summary;
};

// What a row of each table is made of; a record is valid while its session is.
struct FieldRecord {
  const SessionRecord& session;
  const std::string& name;
  const std::string& value;
};
struct TrialRecord {
  const SessionRecord& session;
  const TrialRow& trial;
  Condition condition;  ///< of the test picture
};
struct EventRecord {
  const SessionRecord& session;
  int number = 0;  ///< in the session, from 0
  const EventRow& event;
};
struct ParticipantRecord {
  std::string label;  ///< of BIDS, without "sub-"
  std::string code;
  std::vector<const SessionRecord*> sessions;
};

struct ColumnNote {
  std::string name;
  std::string type;     ///< text, integer, real, 0 or 1; of a level the levels
  std::string unit;     ///< empty where there is none
  std::string clock;    ///< monotonic, system; empty where none
  std::string meaning;  ///< what it is and where it comes from
  std::vector<std::pair<std::string, std::string>> levels = {};  ///< each with its meaning
};

/// A column with the way from a record to its text; nothing known is the empty text.
template <typename Record>
struct ExportColumn {
  ColumnNote note;
  std::string (*value)(const Record&);
};

const std::vector<ExportColumn<SessionRecord>>& session_columns();
const std::vector<ExportColumn<FieldRecord>>& field_columns();
/// In BIDS what names the session is in the file's name and its description, and times are in seconds.
const std::vector<ExportColumn<TrialRecord>>& trial_columns(ExportFormat format);
const std::vector<ExportColumn<EventRecord>>& event_columns();
const std::vector<ExportColumn<ParticipantRecord>>& participant_columns();

/// A table of the export with its columns, for those who describe them.
struct TableNote {
  std::string name;  ///< sessions, fields, trials, events, participants, beh
  std::string meaning;
  std::vector<ColumnNote> columns;
};
std::vector<TableNote> describe_tables(ExportFormat format);

/// docs/data-dictionary.md.
std::string format_data_dictionary();

}  // namespace equilux
