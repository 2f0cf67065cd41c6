// Sessions of other stations' logs come into one: what is to be done is found first, then done in one
// transaction.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiment/log_rows.h"
#include "experiment/trial_log.h"

namespace equilux {

struct LogSession {
  SessionRow row;
  std::vector<TrialRow> trials;
  std::vector<EventRow> events;
};

/// All of a log that a merge looks at.
struct LogContent {
  std::string source;  ///< for messages
  std::vector<LogSession> sessions;
  std::vector<Tombstone> tombstones;
  std::string station = {};  ///< empty: of a log that is not there yet
  std::vector<ExportRow> exports = {};
};

/// A participant of one of the logs that come in gets another code, since somebody else has this one.
struct Rename {
  std::string old_code;
  std::string new_code;
};

/// "OLD=NEW". errors: InputError
Rename parse_rename(const std::string& text);

struct MergePlan {
  std::vector<LogSession> added;       ///< of no session of ours
  std::vector<LogSession> replaced;    ///< further along than ours of the same UUID
  int kept = 0;                        ///< that ours has, as far along or further
  std::vector<Tombstone> tombstones;   ///< that ours has not
  std::vector<std::string> erased;     ///< codes of ours that withdrew at another station
  std::vector<ExportRow> exports;      ///< of which ours does not know
  std::vector<std::string> remarks;    ///< on balance; no hindrance
  std::vector<std::string> conflicts;  ///< with any of them nothing may be written
};

LogContent load_content(const Database& database, const std::string& source);

/// `study_digest` is of the folder that the sessions come into; sessions of other studies conflict. Who has
/// been renamed before keeps that code without being renamed again.
MergePlan plan_merge(const LogContent& ours, const std::vector<LogContent>& theirs,
                     const std::string& study_digest, const std::vector<Rename>& renames = {});
/// The same for files. Where `log` is not there, it holds nothing. errors: InputError for files that are no
/// logs; StoreError
MergePlan plan_merge(const std::filesystem::path& log, const std::vector<std::filesystem::path>& others,
                     const std::string& study_digest, const std::vector<Rename>& renames = {});

/// errors: InputError that names every conflict
void check_no_conflict(const MergePlan& plan, const std::filesystem::path& log);

/// Plans again while no other program has the log open, and writes all of it or nothing; a log that is not
/// there is made. Gives what was done. errors: as plan_merge and check_no_conflict; StoreError
MergePlan merge_logs(const std::filesystem::path& log, const std::vector<std::filesystem::path>& others,
                     const std::string& study_digest, const std::vector<Rename>& renames = {});

/// In words, a line each.
std::string format_merge(const MergePlan& plan);

}  // namespace equilux
