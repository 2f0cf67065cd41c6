// One transaction for the log; then every file that held the answers is written anew.
#include "experiment/withdraw.h"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <set>

#include "base/error.h"
#include "base/files.h"
#include "experiment/export_log.h"
#include "experiment/intake.h"
#include "experiment/log_rows.h"
#include "experiment/log_schema.h"
#include "experiment/rename_codes.h"
#include "stimuli/study_folder.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

std::vector<SessionRow> load_sessions_of(const Database& database, const std::string& code) {
  std::vector<SessionRow> sessions = load_sessions(database);
  std::erase_if(sessions, [&](const SessionRow& row) { return row.participant != code; });
  return sessions;
}

// Whoever asks to be erased may tell the code that a station gave.
std::vector<std::string> find_namesakes(const Database& database, const std::string& code) {
  std::set<std::string> codes;
  for (const SessionRow& row : load_sessions(database)) {
    if (row.participant != code && find_home_code(row) == code) codes.insert(row.participant);
  }
  return {codes.begin(), codes.end()};
}

// What the log has in place of a code that it does not have.
std::string format_unknown(const Database& database, const std::string& code) {
  for (const SessionRow& row : load_sessions(database)) {
    if (is_same_but_for_case(row.participant, code))
      return fmt::format("{}, where {} differs in nothing but the case of letters", code, row.participant);
  }
  return code;
}

std::string format_namesakes(const std::string& code, const std::vector<std::string>& namesakes) {
  return fmt::format("{} of another station is {} here", code, fmt::join(namesakes, ", "));
}

int count_answers(const Database& database, const std::vector<SessionRow>& sessions) {
  int answers = 0;
  for (const SessionRow& session : sessions) {
    const auto trials = load_trials(database, session.id);
    answers += static_cast<int>(std::count_if(trials.begin(), trials.end(),
                                              [](const auto& trial) { return trial.answer.has_value(); }));
  }
  return answers;
}

bool knows(const Database& database, const std::string& code) {
  return Statement(database, "SELECT 1 FROM participant WHERE code = ?", code).step();
}

// To be written: one whose rewriting was interrupted cannot be read before it is whole again.
std::vector<fs::path> find_copies_with(const fs::path& log, const std::string& code) {
  std::vector<fs::path> copies = find_kept_copies(log);
  std::erase_if(copies, [&](const fs::path& copy) { return !knows(open_kept_copy(copy), code); });
  return copies;
}

std::string format_session(const SessionRow& row) {
  return fmt::format("  session {}: {}, {}, index {}, begun {}{}\n", row.id, format_kind(row.kind),
                     format_experiment(row.experiment), row.subject_index, row.started_utc,
                     row.complete ? ", complete" : "");
}

// Not where it cannot be told.
bool is_gone(const fs::path& path) {
  std::error_code ignored;
  return fs::status(path, ignored).type() == fs::file_type::not_found;
}

std::string format_export(const ExportRow& row) {
  if (!row.station.empty())
    return fmt::format("  at station {}: {}, of {}\n", row.station.substr(0, 8), row.path, row.made_utc);
  const fs::path part = find_export_part(row.path);
  return fmt::format("  {}, of {}{}\n", row.path, row.made_utc,
                     is_gone(row.path) ? ": not there any more; if it was moved, it holds them still" : "") +
         (is_gone(part)
              ? ""
              : fmt::format("  {}, which an export that was broken off left there\n", part.string()));
}

bool has_table(const Database& database, const std::string& table) {
  return Statement(database, "SELECT 1 FROM sqlite_schema WHERE type = 'table' AND name = ?", table).step();
}

// In small and capital letters too, but where that is somebody else's code here.
void insert_tombstones(const Database& database, const Tombstone& tombstone, const std::string& name) {
  for (const std::string& spelling : list_spellings(name)) {
    if (spelling == name || !knows(database, spelling))
      insert_tombstone(database, make_tombstone_beside(tombstone, spelling));
  }
}

void bury(const Database& database, const std::string& code) {
  Transaction transaction(database);
  const Tombstone tombstone = find_tombstone(load_tombstones(database), code).value_or(make_tombstone(code));
  insert_tombstones(database, tombstone, code);
  for (const SessionRow& session : load_sessions_of(database, code)) {
    for (const std::string& name : list_names(session)) insert_tombstones(database, tombstone, name);
  }
  erase_participant(database, code);
  transaction.commit();
}

std::vector<std::string> load_codes(const Database& database) {
  Statement row(database, "SELECT code FROM participant");
  std::vector<std::string> codes;
  while (row.step()) codes.push_back(row.text(0));
  return codes;
}

// Rewritten also where nobody is left to erase: an earlier time may have been interrupted before that.
void erase_from_copy(const fs::path& copy, const std::vector<Tombstone>& tombstones) {
  const Database database = open_kept_copy(copy);
  overwrite_what_is_deleted(database);
  Transaction transaction(database);
  for (const std::string& code : load_codes(database)) {
    if (find_tombstone(tombstones, code)) erase_participant(database, code);
  }
  transaction.commit();
  rewrite_database(database);
}

// Not as a part of a longer code.
bool has_word(const std::string& text, const std::string& word) {
  const auto is_part = [&](std::size_t at) {
    return at < text.size() && std::isalnum(static_cast<unsigned char>(text[at])) != 0;
  };
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    if (!(at > 0 && is_part(at - 1)) && !is_part(at + word.size())) return true;
  }
  return false;
}

// Of analysis, in its usual place beside the log; of one elsewhere nothing is known. What cannot be read
// stops no withdrawal, but may hold the code.
void find_reports(Withdrawal& withdrawal, const fs::path& folder) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (!is_file(entry.path())) continue;
    try {
      if (has_word(load_text(entry.path()), withdrawal.code)) withdrawal.reports.push_back(entry.path());
    } catch (const InputError&) {
      withdrawal.unread.push_back(entry.path());
    }
  }
  if (error && !is_gone(folder)) withdrawal.unread.push_back(folder);
  std::sort(withdrawal.reports.begin(), withdrawal.reports.end());
  std::sort(withdrawal.unread.begin(), withdrawal.unread.end());
}

}  // namespace

Withdrawal plan_withdrawal(const fs::path& log, const std::string& code) {
  const Database database = open_log_snapshot(log);
  Withdrawal withdrawal;
  withdrawal.code = code;
  if (const auto tombstone = find_tombstone(load_tombstones(database), code))
    withdrawal.withdrawn_utc = tombstone->withdrawn_utc;
  withdrawal.sessions = load_sessions_of(database, code);
  withdrawal.answers = count_answers(database, withdrawal.sessions);
  withdrawal.copies = find_copies_with(log, code);
  withdrawal.exports = load_exports(database);
  find_reports(withdrawal, StudyFolder{log.parent_path()}.report_folder());
  withdrawal.namesakes = find_namesakes(database, code);
  if (!withdrawal.withdrawn_utc && withdrawal.sessions.empty() && withdrawal.copies.empty())
    throw InputError(log.string(), "participant/code", "the code of a participant of this log",
                     withdrawal.namesakes.empty() ? format_unknown(database, code)
                                                  : format_namesakes(code, withdrawal.namesakes));
  return withdrawal;
}

std::string format_withdrawal(const Withdrawal& withdrawal) {
  std::string text = withdrawal.withdrawn_utc
                         ? fmt::format("{} withdrew on {}; what an interrupted withdrawal left is erased.\n",
                                       withdrawal.code, *withdrawal.withdrawn_utc)
                         : fmt::format("All of {} is erased, for good: sessions {}, answers {}.\n",
                                       withdrawal.code, withdrawal.sessions.size(), withdrawal.answers);
  for (const SessionRow& session : withdrawal.sessions) text += format_session(session);
  for (const fs::path& copy : withdrawal.copies) text += fmt::format("  also in {}\n", copy.string());
  for (const fs::path& report : withdrawal.reports)
    text += fmt::format("  also in {}, which is yours to delete or to make again\n", report.string());
  for (const fs::path& path : withdrawal.unread)
    text += fmt::format("  perhaps also in {}, which cannot be read: look into it\n", path.string());
  if (!withdrawal.namesakes.empty())
    text += fmt::format("  {}, another person, who stays: make sure who of them withdraws\n",
                        format_namesakes(withdrawal.code, withdrawal.namesakes));
  return text + format_exports(withdrawal.exports);
}

std::string format_exports(const std::vector<ExportRow>& exports) {
  std::string text;
  if (!exports.empty())
    text = "Earlier exports may hold these answers; they are yours to delete or to export again:\n";
  for (const ExportRow& row : exports) text += format_export(row);
  return text +
         "Of reports and exports that equilux-analyze made elsewhere, of copies and of backups the log knows "
         "nothing: look through them too.\n";
}

void withdraw_participant(const fs::path& log, const std::string& code) {
  const Database database = open_log_alone(log);
  overwrite_what_is_deleted(database);
  bury(database, code);
  rewrite_database(database);
  erase_from_copies(log, load_tombstones(database));
}

void overwrite_what_is_deleted(const Database& database) {
  require_setting(database, "secure_delete", "ON", "1");
}

void erase_participant(const Database& database, const std::string& code) {
  for (const std::string table : {"event", "trial", "field"}) {
    if (!has_table(database, table)) continue;
    Statement(database,
              fmt::format("DELETE FROM {} WHERE session IN (SELECT session.id FROM session JOIN participant"
                          " ON participant.id = participant WHERE code = ?)",
                          table),
              code)
        .run();
  }
  Statement(database, "DELETE FROM session WHERE participant IN (SELECT id FROM participant WHERE code = ?)",
            code)
      .run();
  Statement(database, "DELETE FROM participant WHERE code = ?", code).run();
}

void erase_from_copies(const fs::path& log, const std::vector<Tombstone>& tombstones) {
  for (const fs::path& copy : find_kept_copies(log)) erase_from_copy(copy, tombstones);
  for (const fs::path& part : find_unfinished_copies(log)) fs::remove(part);
}

}  // namespace equilux
