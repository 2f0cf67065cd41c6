// One transaction for all that is new.
#include "experiment/merge_logs.h"

#include <fmt/format.h>
#include <set>

#include "base/error.h"
#include "experiment/log_schema.h"
#include "experiment/rename_codes.h"
#include "experiment/withdraw.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

std::vector<LogContent> load_others(const std::vector<fs::path>& others) {
  std::vector<LogContent> contents;
  for (const fs::path& other : others)
    contents.push_back(load_content(open_log_snapshot(other), other.string()));
  return contents;
}

void delete_session(const Database& database, const std::string& uuid) {
  for (const char* table : {"event", "trial", "field"}) {
    Statement(database,
              fmt::format("DELETE FROM {} WHERE session = (SELECT id FROM session WHERE uuid = ?)", table),
              uuid)
        .run();
  }
  Statement(database, "DELETE FROM session WHERE uuid = ?", uuid).run();
}

void insert_whole_session(const Database& database, const LogSession& session) {
  const std::int64_t id = insert_session(database, session.row);
  for (const TrialRow& trial : session.trials) insert_trial(database, id, trial);
  for (const EventRow& event : session.events) insert_event(database, id, event);
}

void carry_out(const Database& database, const MergePlan& plan) {
  Transaction transaction(database);
  for (const Tombstone& tombstone : plan.tombstones) insert_tombstone(database, tombstone);
  for (const std::string& code : plan.erased) erase_participant(database, code);
  for (const ExportRow& row : plan.exports) insert_export(database, row);
  for (const LogSession& session : plan.replaced) {
    delete_session(database, session.row.uuid);
    insert_whole_session(database, session);
  }
  for (const LogSession& session : plan.added) insert_whole_session(database, session);
  transaction.commit();
}

// Also those of an earlier merge that was interrupted.
void finish_withdrawals(const fs::path& log, const Database& database) {
  const auto tombstones = load_tombstones(database);
  if (tombstones.empty()) return;
  rewrite_database(database);
  erase_from_copies(log, tombstones);
}

std::string format_rename(const SessionRow& row) {
  const std::string home = find_home_code(row);
  if (home == row.participant) return {};
  return fmt::format("renamed: {} of station {} is {} here, {} experiment\n", home, row.station.substr(0, 8),
                     row.participant, format_experiment(row.experiment));
}

// One has a tombstone for each of its names.
std::size_t count_withdrawals(const MergePlan& plan) {
  std::set<std::string> salts;
  for (const Tombstone& tombstone : plan.tombstones) salts.insert(tombstone.salt);
  return salts.size();
}

bool is_empty(const MergePlan& plan) {
  return plan.added.empty() && plan.replaced.empty() && plan.tombstones.empty() && plan.erased.empty() &&
         plan.exports.empty();
}

}  // namespace

LogContent load_content(const Database& database, const std::string& source) {
  LogContent content{source, {}, load_tombstones(database), load_station(database), load_exports(database)};
  for (const SessionRow& row : load_sessions(database))
    content.sessions.push_back({row, load_trials(database, row.id), load_events(database, row.id)});
  return content;
}

MergePlan plan_merge(const fs::path& log, const std::vector<fs::path>& others,
                     const std::string& study_digest, const std::vector<Rename>& renames) {
  const LogContent ours =
      has_log(log) ? load_content(open_log_snapshot(log), log.string()) : LogContent{log.string(), {}, {}};
  return plan_merge(ours, load_others(others), study_digest, renames);
}

void check_no_conflict(const MergePlan& plan, const fs::path& log) {
  if (plan.conflicts.empty()) return;
  throw InputError(log.string(), "merge", "logs that agree",
                   fmt::format("conflicts, {}; nothing was written:\n  {}", plan.conflicts.size(),
                               fmt::join(plan.conflicts, "\n  ")));
}

MergePlan merge_logs(const fs::path& log, const std::vector<fs::path>& others,
                     const std::string& study_digest, const std::vector<Rename>& renames) {
  const std::vector<LogContent> theirs = load_others(others);
  if (!has_log(log)) {
    const MergePlan plan = plan_merge(LogContent{log.string(), {}, {}}, theirs, study_digest, renames);
    check_no_conflict(plan, log);
    if (is_empty(plan)) return plan;
    open_log(log, true);
  }
  const Database database = open_log_alone(log);
  const MergePlan plan = plan_merge(load_content(database, log.string()), theirs, study_digest, renames);
  check_no_conflict(plan, log);
  overwrite_what_is_deleted(database);
  carry_out(database, plan);
  finish_withdrawals(log, database);
  return plan;
}

std::string format_merge(const MergePlan& plan) {
  std::string text = fmt::format(
      "sessions: {} added, {} further along than here, {} known already; withdrawals: {} taken over, {} "
      "erased here; exports: {} taken over\n",
      plan.added.size(), plan.replaced.size(), plan.kept, count_withdrawals(plan), plan.erased.size(),
      plan.exports.size());
  for (const std::vector<LogSession>* sessions : {&plan.added, &plan.replaced}) {
    for (const LogSession& session : *sessions) text += format_rename(session.row);
  }
  for (const std::string& remark : plan.remarks) text += fmt::format("remark: {}\n", remark);
  return text;
}

}  // namespace equilux
