// A participant withdraws: the answers and the code go, out of the log and out of every copy kept beside it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiment/database.h"
#include "experiment/log_rows.h"
#include "experiment/trial_log.h"

namespace equilux {

/// What a withdrawal will erase, and what it cannot reach.
struct Withdrawal {
  std::string code;
  std::optional<std::string> withdrawn_utc;    ///< of an earlier one, which this one only finishes
  std::vector<SessionRow> sessions;            ///< in the log
  int answers = 0;                             ///< in the log
  std::vector<std::filesystem::path> copies;   ///< kept copies that hold the code
  std::vector<ExportRow> exports;              ///< earlier ones: files that may hold these answers
  std::vector<std::filesystem::path> reports;  ///< files of the study folder's report that hold the code
  std::vector<std::filesystem::path> unread;   ///< likewise, or the report's folder, that cannot be read
  std::vector<std::string> namesakes;          ///< codes here of others whom a station gave this code
};

/// Looks without touching anything. errors: InputError where neither log nor copies know the code and nobody
/// of it withdrew, or a kept copy is no log; StoreError
Withdrawal plan_withdrawal(const std::filesystem::path& log, const std::string& code);

/// In words for the experimenter, a line each.
std::string format_withdrawal(const Withdrawal& withdrawal);

/// Which earlier exports may hold the answers of somebody who withdrew, and that there may be more.
std::string format_exports(const std::vector<ExportRow>& exports);

/// Erases the participant with all sessions, fields, trials and events, leaves a tombstone, and writes log
/// and kept copies anew, so that no byte of them is left. Killed at any moment it has erased all from the log
/// or nothing; once more finishes it. errors: StoreError, also while another program has the log open
void withdraw_participant(const std::filesystem::path& log, const std::string& code);

/// The steps of it, for logs of any schema. First, before anything is deleted: what is deleted is
/// overwritten.
void overwrite_what_is_deleted(const Database& database);
/// Within the caller's transaction.
void erase_participant(const Database& database, const std::string& code);
/// Everybody of whom there is a tombstone, from the copies that are kept beside a log; unfinished copies are
/// removed. errors: StoreError
void erase_from_copies(const std::filesystem::path& log, const std::vector<Tombstone>& tombstones);

}  // namespace equilux
