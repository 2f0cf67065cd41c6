// A rename is checked against all that comes together, then carried out on what comes in.
#include "experiment/rename_codes.h"

#include <algorithm>
#include <fmt/format.h>

#include "base/digest.h"
#include "base/error.h"
#include "experiment/intake.h"
#include "experiment/open_session.h"

namespace equilux {
namespace {

constexpr const char* kFirstCodeField = "renamed_from";

bool has_code(const LogContent& log, const std::string& code) {
  return std::any_of(log.sessions.begin(), log.sessions.end(),
                     [&](const LogSession& session) { return session.row.participant == code; });
}

// One rename, with the log that it is about.
class Renaming {
 public:
  Renaming(const Rename& rename, const LogContent& ours, std::vector<LogContent>& theirs,
           std::vector<std::string>& conflicts)
      : rename_(rename), ours_(ours), theirs_(theirs), conflicts_(conflicts) {}

  void run() {
    find_log();
    if (!log_) return;
    check_kind();
    check_digit();
    check_free(ours_);
    for (const LogContent& log : theirs_) check_free(log);
    check_not_withdrawn();
    carry_out();
  }

 private:
  void conflict(const std::string& what) {
    conflicts_.push_back(fmt::format("--rename {}={}: {}", rename_.old_code, rename_.new_code, what));
  }

  void find_log() {
    std::vector<LogContent*> found;
    for (LogContent& log : theirs_) {
      if (has_code(log, rename_.old_code) || find_tombstone(log.tombstones, rename_.old_code))
        found.push_back(&log);
    }
    if (found.empty()) conflict(fmt::format("no log that comes in has {}", rename_.old_code));
    if (found.size() > 1)
      conflict(fmt::format("{} and {} have it; take them in one after the other", found[0]->source,
                           found[1]->source));
    if (found.size() == 1) log_ = found[0];
  }

  // Who is renamed, also as an earlier merge brought that person here.
  bool is_renamed(const SessionRow& row) const {
    const bool is_of_station = row.station == log_->station && find_home_code(row) == rename_.old_code;
    return is_of_station ||
           std::any_of(log_->sessions.begin(), log_->sessions.end(), [&](const LogSession& session) {
             return session.row.participant == rename_.old_code && is_same_person(session.row, row);
           });
  }

  void check_kind() {
    for (const LogSession& session : log_->sessions) {
      if (session.row.participant != rename_.old_code || session.row.kind == SubjectKind::kPerson) continue;
      conflict(fmt::format("{} is no person's code: a {} subject is known by it", rename_.old_code,
                           format_kind(session.row.kind)));
      return;
    }
  }

  // Of a code that an earlier merge gave too, before codes had one.
  void check_digit() {
    if (!has_digit(rename_.new_code) && !has_code(ours_, rename_.new_code))
      conflict("a new code has a digit or more, so that it is no name");
  }

  void check_free(const LogContent& log) {
    for (const LogSession& session : log.sessions) {
      if (!is_same_but_for_case(session.row.participant, rename_.new_code) || is_renamed(session.row))
        continue;
      conflict(fmt::format("{} has {}, who is somebody else", log.source, session.row.participant));
      return;
    }
  }

  void check_not_withdrawn() {
    if (!has_code(*log_, rename_.old_code)) return;  // who withdrew there, perhaps here too by now
    for (const std::string& spelling : list_spellings(rename_.new_code)) {
      if (find_tombstone(ours_.tombstones, spelling)) conflict(fmt::format("{} withdrew", spelling));
      for (const LogContent& log : theirs_) {
        if (find_tombstone(log.tombstones, spelling)) conflict(fmt::format("{} withdrew", spelling));
      }
    }
  }

  void carry_out() const {
    for (LogSession& session : log_->sessions) {
      if (session.row.participant == rename_.old_code) give_code(session.row, rename_.new_code);
    }
    for (Tombstone& tombstone : log_->tombstones) {
      if (is_of(tombstone, rename_.old_code)) tombstone = make_tombstone_beside(tombstone, rename_.new_code);
    }
  }

  const Rename& rename_;
  const LogContent& ours_;
  std::vector<LogContent>& theirs_;
  std::vector<std::string>& conflicts_;
  LogContent* log_ = nullptr;
};

void check_apart(const std::vector<Rename>& renames, std::vector<std::string>& conflicts) {
  for (std::size_t i = 0; i < renames.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Rename &a = renames[j], &b = renames[i];
      if (a.old_code == b.old_code || is_same_but_for_case(a.new_code, b.new_code))
        conflicts.push_back(fmt::format("--rename {}={} and {}={}: each code once", a.old_code, a.new_code,
                                        b.old_code, b.new_code));
    }
  }
}

}  // namespace

Rename parse_rename(const std::string& text) {
  const std::size_t at = text.find('=');
  if (at == std::string::npos || at == 0 || text.substr(0, at) == text.substr(at + 1))
    throw InputError("--rename", "", "OLD=NEW, two codes", "\"" + text + "\"");
  const Rename rename{text.substr(0, at), text.substr(at + 1)};
  check_spelling(rename.new_code, "--rename");
  return rename;
}

std::string find_home_code(const SessionRow& row) {
  const auto field = row.fields.find(kFirstCodeField);
  return field == row.fields.end() ? row.participant : field->second;
}

bool is_same_person(const SessionRow& a, const SessionRow& b) {
  return a.station == b.station && find_home_code(a) == find_home_code(b);
}

void give_code(SessionRow& row, const std::string& code) {
  const std::string home = find_home_code(row);
  row.participant = code;
  row.fields.erase(kFirstCodeField);
  if (code != home) row.fields[kFirstCodeField] = home;
}

// No code has a colon.
std::string name_at_home(const SessionRow& row) { return row.station + ":" + find_home_code(row); }

std::vector<std::string> list_names(const SessionRow& row) {
  if (find_home_code(row) == row.participant) return {row.participant};
  return {row.participant, name_at_home(row)};
}

Tombstone make_tombstone_beside(const Tombstone& tombstone, const std::string& name) {
  return {tombstone.salt, digest_text(tombstone.salt + name), tombstone.withdrawn_utc};
}

bool is_of_same_withdrawal(const Tombstone& a, const Tombstone& b) { return a.salt == b.salt; }

void rename_codes(std::vector<LogContent>& theirs, const LogContent& ours, const std::vector<Rename>& renames,
                  std::vector<std::string>& conflicts) {
  check_apart(renames, conflicts);
  for (const Rename& rename : renames) Renaming(rename, ours, theirs, conflicts).run();
}

}  // namespace equilux
