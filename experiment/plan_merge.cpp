// Logs are taken in one after the other; each session meets those that are there already.
#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <set>
#include <tuple>

#include "experiment/intake.h"
#include "experiment/merge_logs.h"
#include "experiment/rename_codes.h"

namespace equilux {
namespace {

std::string name_session(const LogSession& session) {
  return fmt::format("{}, {}, {}, index {}, of station {}", session.row.participant,
                     format_kind(session.row.kind), format_experiment(session.row.experiment),
                     session.row.subject_index, session.row.station.substr(0, 8));
}

bool is_schedule_same(const TrialRow& a, const TrialRow& b) {
  const auto scheduled = [](const TrialRow& row) {
    return std::tie(row.number, row.phase, row.cell, row.test_key, row.pair_key, row.upper_key,
                    row.test_side);
  };
  return scheduled(a) == scheduled(b);
}

bool is_trial_prefix(const TrialRow& a, const TrialRow& b) {
  return a.answer ? a == b : is_schedule_same(a, b);
}

bool has_same_start(const SessionRow& a, const SessionRow& b) {
  const auto start = [](const SessionRow& row) {
    return std::tie(row.participant, row.kind, row.experiment, row.subject_index, row.seed, row.started_utc);
  };
  return start(a) == start(b) && a.digests == b.digests;
}

// `b` has all of `a`, and perhaps more.
bool is_prefix(const LogSession& a, const LogSession& b) {
  return has_same_start(a.row, b.row) && a.row.complete <= b.row.complete &&
         std::includes(b.row.fields.begin(), b.row.fields.end(), a.row.fields.begin(), a.row.fields.end()) &&
         std::equal(a.trials.begin(), a.trials.end(), b.trials.begin(), b.trials.end(), is_trial_prefix) &&
         a.events.size() <= b.events.size() && std::equal(a.events.begin(), a.events.end(), b.events.begin());
}

// What the merged log will hold, session by session, with where each comes from.
struct Held {
  LogSession session;
  std::string source;
  enum { kOurs, kReplaced, kAdded } state = kOurs;
};

class Planner {
 public:
  Planner(const LogContent& ours, const std::string& study_digest, const std::vector<Rename>& renames)
      : study_digest_(study_digest), renames_(renames), station_(ours.station), exports_(ours.exports) {
    tombstones_ = ours.tombstones;
    for (const LogSession& session : ours.sessions) held_.push_back({session, ours.source});
  }

  void rename(std::vector<LogContent>& theirs, const LogContent& ours) {
    rename_codes(theirs, ours, renames_, plan_.conflicts);
  }

  // A withdrawal may be known by another code here.
  void take_tombstones(const LogContent& log) {
    const std::vector<Tombstone> before = tombstones_;
    for (const Tombstone& tombstone : log.tombstones) {
      const bool is_known = std::any_of(before.begin(), before.end(), [&](const Tombstone& known) {
        return is_of_same_withdrawal(known, tombstone);
      });
      if (is_known) continue;
      check_who_withdrew(tombstone, log.source);
      add_tombstone(tombstone);
    }
  }

  // What somebody withdraws from here may have been exported there.
  void take_exports(const LogContent& log) {
    for (ExportRow row : log.exports) {
      if (row.station.empty()) row.station = log.station;
      if (row.station == station_) row.station.clear();
      const bool is_known = std::any_of(exports_.begin(), exports_.end(), [&](const ExportRow& known) {
        return known.station == row.station && known.path == row.path && known.made_utc >= row.made_utc;
      });
      if (is_known) continue;
      exports_.push_back(row);
      plan_.exports.push_back(row);
    }
  }

  // All tombstones are known now.
  void erase_withdrawn() {
    std::erase_if(held_, [&](const Held& held) {
      const std::string& code = held.session.row.participant;
      const auto tombstone = find_tombstone(tombstones_, code);
      if (!tombstone) return false;
      for (const std::string& name : list_names(held.session.row))
        add_tombstone(make_tombstone_beside(*tombstone, name));
      if (std::find(plan_.erased.begin(), plan_.erased.end(), code) == plan_.erased.end())
        plan_.erased.push_back(code);
      return true;
    });
  }

  void take(LogSession session, const std::string& source) {
    take_known_code(session, source);
    if (has_withdrawn(session.row)) {
      conflict(session, source, "the participant withdrew; withdraw there too, then merge again");
      return;
    }
    check_study(session, source);
    Held* same = find_same(session);
    if (!same) {
      check_against_others(session, source);
      held_.push_back({session, source, Held::kAdded});
    } else if (is_prefix(session, same->session)) {
      ++plan_.kept;
    } else if (is_prefix(same->session, session)) {
      if (same->state == Held::kOurs) same->state = Held::kReplaced;
      same->session = session;
      same->source = source;
    } else {
      conflict(session, source,
               fmt::format("the same session has other answers or events in {}", same->source));
    }
  }

  MergePlan finish() {
    for (const Held& held : held_) {
      if (held.state == Held::kAdded) plan_.added.push_back(held.session);
      if (held.state == Held::kReplaced) plan_.replaced.push_back(held.session);
    }
    find_double_finishes();
    remark_codes_of_several_stations();
    remark_equal_indices();
    return std::move(plan_);
  }

 private:
  void conflict(const LogSession& session, const std::string& source, const std::string& what) {
    plan_.conflicts.push_back(fmt::format("{}: {}: {}", source, name_session(session), what));
  }

  void add_tombstone(const Tombstone& tombstone) {
    if (std::find(tombstones_.begin(), tombstones_.end(), tombstone) != tombstones_.end()) return;
    tombstones_.push_back(tombstone);
    plan_.tombstones.push_back(tombstone);
  }

  // Who was renamed here must not be taken for the other one of the code.
  void check_who_withdrew(const Tombstone& tombstone, const std::string& source) {
    for (const Held& held : held_) {
      const SessionRow& row = held.session.row;
      const std::string home = find_home_code(row);
      if (home == row.participant || !is_of(tombstone, home) || find_tombstone(tombstones_, home)) continue;
      plan_.conflicts.push_back(
          fmt::format("{}: {} withdrew there, which is the code of two persons: if it was {}, of station {}, "
                      "say --rename "
                      "{}={}; else withdraw {} here first",
                      source, home, row.participant, row.station.substr(0, 8), home, row.participant, home));
      return;
    }
  }

  // Under any of these names, in small and capital letters: also who was renamed here before, and comes in
  // under the first code.
  bool has_withdrawn(const SessionRow& row) const {
    for (const std::string& name : {row.participant, name_at_home(row)}) {
      for (const std::string& spelling : list_spellings(name)) {
        if (find_tombstone(tombstones_, spelling)) return true;
      }
    }
    return false;
  }

  // By which a person of that station is known here already.
  void take_known_code(LogSession& session, const std::string& source) {
    const auto known = std::find_if(held_.begin(), held_.end(), [&](const Held& held) {
      return is_same_person(held.session.row, session.row);
    });
    if (known == held_.end()) return;
    const std::string& code = known->session.row.participant;
    const bool is_asked_for = std::any_of(renames_.begin(), renames_.end(), [&](const Rename& rename) {
      return rename.new_code == session.row.participant;
    });
    if (is_asked_for && session.row.participant != code)
      conflict(
          session, source,
          fmt::format("is {} in {} already: codes are for good once they are taken in", code, known->source));
    give_code(session.row, code);
  }

  Held* find_same(const LogSession& session) {
    const auto same = std::find_if(held_.begin(), held_.end(), [&](const Held& held) {
      return held.session.row.uuid == session.row.uuid;
    });
    return same == held_.end() ? nullptr : &*same;
  }

  void check_study(const LogSession& session, const std::string& source) {
    if (session.row.digests.study != study_digest_)
      conflict(session, source,
               fmt::format("its study has the digest {}, the folder's {}", session.row.digests.study,
                           study_digest_));
  }

  void check_against_others(const LogSession& session, const std::string& source) {
    bool compared = false;
    for (const Held& held : held_) {
      const SessionRow& other = held.session.row;
      if (other.participant != session.row.participant &&
          is_same_but_for_case(other.participant, session.row.participant)) {
        conflict(session, source,
                 fmt::format("{} has {}: codes that differ in nothing but the case of letters are one "
                             "person's or a slip, which a merged log could not tell",
                             held.source, other.participant));
        return;
      }
      if (other.kind != session.row.kind || other.experiment != session.row.experiment) continue;
      if (!compared) check_digests(session, source, held);
      compared = true;
      if (other.station == session.row.station && other.subject_index == session.row.subject_index)
        conflict(session, source,
                 fmt::format("another session of this station has its index in {}: one log was"
                             " copied and both went on",
                             held.source));
    }
  }

  // The study is compared with the folder's. A protocol is unknown in sessions of schema 1.
  void check_digests(const LogSession& session, const std::string& source, const Held& held) {
    const SessionDigests &theirs = session.row.digests, &ours = held.session.row.digests;
    const auto compare = [&](const char* name, const std::string& a, const std::string& b) {
      if (a != b)
        conflict(session, source, fmt::format("its {} has the digest {}, in {} {}", name, a, held.source, b));
    };
    compare("set of pictures", theirs.manifest, ours.manifest);
    compare("windows.json", theirs.windows, ours.windows);
    compare("selection", theirs.selection, ours.selection);
    compare("truth", theirs.truth, ours.truth);
    if (!theirs.protocol.empty() && !ours.protocol.empty())
      compare("session.json", theirs.protocol, ours.protocol);
  }

  void find_double_finishes() {
    std::map<std::tuple<std::string, SubjectKind, Experiment>, const Held*> finished;
    for (const Held& held : held_) {
      const SessionRow& row = held.session.row;
      const auto [place, is_new] =
          finished.emplace(std::tuple(row.participant, row.kind, row.experiment), &held);
      if (is_new) continue;
      if (row.complete && place->second->session.row.complete) {
        conflict(
            held.session, held.source,
            fmt::format("this participant finished the same experiment in {} too; were they two persons, "
                        "--rename {}=NEW gives the one of the log that comes in another code",
                        place->second->source, row.participant));
      } else {
        plan_.remarks.push_back(
            fmt::format("{} has more than one session in the {} experiment; at most one is complete",
                        row.participant, format_experiment(row.experiment)));
        if (row.complete) place->second = &held;
      }
    }
  }

  // One person who went from one to the other, or two who were given the same code.
  void remark_codes_of_several_stations() {
    std::map<std::pair<std::string, SubjectKind>, const Held*> first;
    std::set<std::string> told;
    for (const Held& held : held_) {
      const SessionRow& row = held.session.row;
      const auto [place, is_new] = first.emplace(std::pair(row.participant, row.kind), &held);
      const Held& other = *place->second;
      if (is_new || other.session.row.station == row.station) continue;
      if (other.session.row.experiment == row.experiment) continue;  // told above
      if (other.state == Held::kOurs && held.state == Held::kOurs) continue;
      if (row.kind != SubjectKind::kPerson || !told.insert(row.participant).second) continue;
      plan_.remarks.push_back(
          fmt::format("{} has sessions of two stations, in {} and {}: one person; were they two, --rename "
                      "{}=NEW gives the one of the log that comes in another code",
                      row.participant, other.source, held.source, row.participant));
    }
  }

  void remark_equal_indices() {
    std::map<std::tuple<SubjectKind, Experiment, std::int64_t>, const Held*> holders;
    for (const Held& held : held_) {
      const SessionRow& row = held.session.row;
      const auto [place, is_new] =
          holders.emplace(std::tuple(row.kind, row.experiment, row.subject_index), &held);
      if (is_new || (place->second->state == Held::kOurs && held.state == Held::kOurs)) continue;
      plan_.remarks.push_back(fmt::format(
          "balance: {} and {} have the same index, so the same views, sides and reference materials",
          name_session(place->second->session), name_session(held.session)));
    }
  }

  std::string study_digest_;
  std::vector<Rename> renames_;
  std::string station_;  // ours
  std::vector<ExportRow> exports_;
  std::vector<Held> held_;
  std::vector<Tombstone> tombstones_;
  MergePlan plan_;
};

}  // namespace

MergePlan plan_merge(const LogContent& ours, const std::vector<LogContent>& theirs,
                     const std::string& study_digest, const std::vector<Rename>& renames) {
  Planner planner(ours, study_digest, renames);
  std::vector<LogContent> renamed = theirs;
  planner.rename(renamed, ours);
  for (const LogContent& log : renamed) {
    planner.take_tombstones(log);
    planner.take_exports(log);
  }
  planner.erase_withdrawn();
  for (const LogContent& log : renamed) {
    for (const LogSession& session : log.sessions) planner.take(session, log.source);
  }
  return planner.finish();
}

}  // namespace equilux
