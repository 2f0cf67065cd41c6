// From a study folder to a session that may begin or go on: all checks that protect earlier answers.
#include "experiment/open_session.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <iterator>
#include <random>
#include <type_traits>
#include <unistd.h>

#include "base/error.h"
#include "base/files.h"
#include "base/json.h"
#include "base/program.h"
#include "base/version.h"
#include "experiment/clock_lag.h"
#include "experiment/intake.h"
#include "experiment/schedule.h"
#include "protocols/truth.h"
#include "protocols/windows.h"
#include "stimuli/change_mark.h"
#include "stimuli/manifest.h"
#include "stimuli/selection.h"
#include "stimuli/verdict.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

constexpr const char* kLaneField = "lane";
constexpr const char* kClockField = "clock_behind_hours";  // where times are not to be trusted

std::string format_clock_field(const ClockLag& lag) { return fmt::format("{:.2f}", lag.hours); }

// A manifest may be of an older study.json, whose pictures show something else.
Manifest load_checked_manifest(const StudyFolder& folder, const Study& study) {
  Manifest manifest = load_manifest(folder.manifest());
  if (manifest.study_digest != study.digest) {
    throw InputError(folder.manifest().string(), "/study_digest",
                     fmt::format("{}, of {}", study.digest, folder.study().string()), manifest.study_digest);
  }
  return manifest;
}

std::string prune_command(const StudyFolder& folder, SubjectKind kind) {
  return fmt::format("equilux-analyze prune {} --kind {}", folder.root.string(), format_kind(kind));
}

// A selection must be of today's artifact answers, unless a session has used it: then it is frozen.
void check_is_current(const Selection& selection, const StudyFolder& folder, const TrialLog* log,
                      SubjectKind kind) {
  const std::string source = folder.selection(kind).string();
  if (selection.kind != kind) {
    throw InputError(source, "/kind", format_kind(kind), format_kind(selection.kind));
  }
  if (log && log->has_session_using_selection(digest_selection(selection))) return;
  const std::string answers =
      digest_answers(log ? log->load_answers(kind, Experiment::kArtifact) : std::vector<AnswerRow>{});
  if (selection.answers_digest != answers) {
    throw InputError(
        source, "/answers_digest", fmt::format("{}, of the artifact answers in the log", answers),
        fmt::format("{}; `{}` prunes again", selection.answers_digest, prune_command(folder, kind)));
  }
}

Selection load_current_selection(const StudyFolder& folder, const TrialLog* log, const Study& study,
                                 SubjectKind kind) {
  if (!fs::exists(folder.selection(kind))) {
    throw InputError(folder.selection(kind).string(), "", "the selection for the material experiment",
                     fmt::format("nothing of that name; `{}` makes it", prune_command(folder, kind)));
  }
  Selection selection = load_selection(folder.selection(kind), study);
  check_is_current(selection, folder, log, kind);
  return selection;
}

// Without the file there would be no consent, no questions, no practice and no catch trials, and nobody told.
void check_has_protocol(const StudyFolder& folder, const Study& study) {
  if (!study.source.find("session") || path_exists(folder.session())) return;
  throw InputError(folder.session().string(), "",
                   "the session protocol that the study names, with its consent and practice",
                   "nothing of that name; `equilux-render set` copies it");
}

struct NamedDigest {
  const char* name;
  std::string SessionDigests::*member;
};

void check_same_digests(const SessionRow& earlier, const SessionDigests& now, const StudyFolder& folder) {
  // What was edited before what follows from it: other windows show other pictures.
  for (const auto& [name, member] :
       {NamedDigest{"study", &SessionDigests::study}, NamedDigest{"windows", &SessionDigests::windows},
        NamedDigest{"selection", &SessionDigests::selection}, NamedDigest{"truth", &SessionDigests::truth},
        NamedDigest{"session protocol", &SessionDigests::protocol},
        NamedDigest{"pictures", &SessionDigests::manifest}}) {
    if (earlier.digests.*member != now.*member) {
      throw InputError(folder.root.string(), name,
                       fmt::format("what session {} of {} was made from (digest {})", earlier.id,
                                   earlier.participant, earlier.digests.*member),
                       fmt::format("{}; put it back, or begin in a new folder", now.*member));
    }
  }
}

// With what was measured anew: another sitting may be at another screen.
std::string describe_resume(const SessionRequest& request, const std::optional<ClockLag>& lag) {
  const ScreenRecord& screen = request.screen;
  const auto number = [](const auto& value) { return value ? Json(*value) : Json(); };
  Json detail;
  for (const auto& [name, value] : request.fields) detail.set(name, value);
  if (lag) detail.set(kClockField, format_clock_field(*lag));
  detail.set("program_version", kVersion).set("monitor", screen.monitor);
  detail.set("framebuffer_width", number(screen.framebuffer_width));
  detail.set("framebuffer_height", number(screen.framebuffer_height));
  detail.set("viewing_distance_m", number(screen.viewing_distance_m));
  detail.set("degrees_wide", number(screen.degrees_wide));
  detail.set("degrees_high", number(screen.degrees_high));
  return format_canonical_json(detail);
}

SessionRules make_rules(const SessionInputs& inputs) {
  SessionRules rules;
  rules.familiar_pages = static_cast<int>(inputs.familiar_pages.size());
  rules.break_every_trials = inputs.protocol.break_every_trials;
  if (inputs.protocol.break_every_minutes)
    rules.break_every_ns = static_cast<std::int64_t>(*inputs.protocol.break_every_minutes * 60e9);
  rules.least_response_ns = std::int64_t{inputs.protocol.least_response_ms} * 1'000'000;
  return rules;
}

// The last thing that is known of a session.
std::string find_last_utc(const SessionRow& row, const std::vector<TrialRow>& trials) {
  std::string last = row.started_utc;
  for (const TrialRow& trial : trials) {
    if (trial.answered_utc) last = std::max(last, *trial.answered_utc);
  }
  return last;
}

void check_may_resume(const SessionInputs& inputs, const TrialLog& log, const SessionRow& row,
                      const SessionRequest& request) {
  const auto refuse = [&](const std::string& expected, const std::string& got) {
    throw InputError(inputs.folder.session().string(), "/resume", expected,
                     fmt::format("session {} of {}, {}", row.id, row.participant, got));
  };
  if (!inputs.protocol.may_resume) refuse("sessions that run in one go", "which was interrupted");
  if (!inputs.protocol.resume_within_hours) return;
  const std::string asked = fmt::format("a session that was interrupted at most {} hours ago",
                                        *inputs.protocol.resume_within_hours);
  const std::string last = find_last_utc(row, log.load_trials(row.id));
  const double hours = count_hours(last, request.now_utc.empty() ? format_utc_now() : request.now_utc);
  if (hours > *inputs.protocol.resume_within_hours)
    refuse(asked, fmt::format("whose last answer or start was at {}, {:.1f} hours ago", last, hours));
  const auto lag = find_clock_lag(log, request.now_utc);
  if (lag && !request.accepts_clock) refuse(asked, "of unknown age. " + describe_clock_lag(*lag));
}

// Of a participant of whom the log has no session: a slip of the keyboard must not begin another person.
void check_new_code(const SessionInputs& inputs, const std::vector<SessionRow>& sessions,
                    const std::string& code) {
  const auto is_same = [&](const SessionRow& row) { return row.participant == code; };
  if (std::any_of(sessions.begin(), sessions.end(), is_same)) return;
  const std::string source = inputs.folder.responses().string();
  check_code(code, source);
  for (const SessionRow& row : sessions) {
    if (!is_same_but_for_case(row.participant, code)) continue;
    throw InputError(source, "participant",
                     "a code that differs from others in more than the case of letters",
                     fmt::format("{}, where session {} is of {}", code, row.id, row.participant));
  }
}

// The same words in every program that would run it.
std::string name_lock(SubjectKind kind, Experiment experiment, const std::string& code) {
  return fmt::format("{}/{}/{}", format_kind(kind), format_experiment(experiment), code);
}

std::string name_lock(const SessionInputs& inputs, const std::string& code) {
  return name_lock(inputs.kind, inputs.experiment, code);
}

[[noreturn]] void refuse_running(const SessionInputs& inputs, const TrialLog& log, const std::string& code) {
  std::string session = "a session";
  for (const SessionRow& row : log.load_sessions()) {
    if (row.kind == inputs.kind && row.experiment == inputs.experiment && row.participant == code)
      session = fmt::format("session {}", row.id);
  }
  throw InputError(
      inputs.folder.responses().string(), "session", "a session that no other window runs",
      fmt::format("{} of {}, {} experiment, which runs in another window now; go on there, or close "
                  "that window first",
                  session, code, format_experiment(inputs.experiment)));
}

// The age of planted subjects is nothing to anybody.
std::optional<ClockLag> find_persons_lag(const TrialLog& log, const SessionRequest& request) {
  return request.kind == SubjectKind::kPerson ? find_clock_lag(log, request.now_utc) : std::nullopt;
}

OpenSession resume_session(const SessionInputs& inputs, TrialLog& log, const SessionRow& row,
                           const SessionRequest& request, SessionLock lock) {
  std::vector<TrialRow> trials = log.load_trials(row.id);
  log.append_event(row.id, "resume", 0, describe_resume(request, find_persons_lag(log, request)));
  return {row, make_session(row.experiment, std::move(trials), make_rules(inputs)), true, std::move(lock)};
}

OpenSession begin_session(const SessionInputs& inputs, TrialLog& log, const SessionRequest& request,
                          SessionLock lock) {
  SessionRow row;
  row.participant = request.participant;
  row.kind = inputs.kind;
  row.experiment = inputs.experiment;
  const Lane lane = find_lane(&log, request.lane);
  row.subject_index = log.find_free_index(inputs.kind, inputs.experiment, lane);
  row.seed = request.seed;
  row.program_version = kVersion;
  row.digests = inputs.digests;
  row.screen = request.screen;
  row.fields = request.fields;
  if (request.lane || lane != Lane{}) row.fields[kLaneField] = format_lane(lane);
  if (const auto lag = find_persons_lag(log, request)) row.fields[kClockField] = format_clock_field(*lag);
  row.started_utc = format_utc_now();
  auto trials = add_extra_trials(
      make_schedule(inputs.study, inputs.experiment, inputs.cells, inputs.kind, row.seed, row.subject_index),
      inputs.study, inputs.protocol, inputs.experiment, inputs.kind, row.seed, row.subject_index);
  row.id = log.append_session(row, trials);
  return {row, make_session(inputs.experiment, std::move(trials), make_rules(inputs)), false,
          std::move(lock)};
}

}  // namespace

std::optional<TrialLog> find_log(const StudyFolder& folder) {
  if (!TrialLog::is_at(folder.responses())) return std::nullopt;
  return TrialLog(folder.responses(), true);
}

std::vector<std::string> enumerate_session_keys(const SessionInputs& inputs) {
  std::vector<std::string> keys = enumerate_showable(inputs.study, inputs.experiment, inputs.cells);
  const auto extra = enumerate_extra_keys(inputs.study, inputs.protocol, inputs.experiment, inputs.cells);
  std::vector<std::string> all;
  std::set_union(keys.begin(), keys.end(), extra.begin(), extra.end(), std::back_inserter(all));
  return all;
}

SessionInputs load_session_inputs(const StudyFolder& folder, const TrialLog* log,
                                  const SessionRequest& request) {
  SessionInputs inputs{folder, request.experiment, request.kind, load_folder_study(folder), {}, {}, {}, {}};
  const Manifest manifest = load_checked_manifest(folder, inputs.study);
  inputs.digests.study = inputs.study.digest;
  if (request.experiment == Experiment::kArtifact) {
    const Windows windows = load_windows(inputs.study.windows_path, inputs.study);
    inputs.cells = enumerate_artifact_cells(inputs.study, windows);
    inputs.digests.windows = windows.digest;
  } else {
    const Selection selection = load_current_selection(folder, log, inputs.study, request.kind);
    inputs.cells = enumerate_selected_cells(selection, inputs.study);
    inputs.digests.selection = digest_selection(selection);
    if (inputs.cells.empty()) {
      throw InputError(folder.selection(request.kind).string(), "/columns", "a level that is left to test",
                       "none: every column was dropped");
    }
  }
  if (request.kind == SubjectKind::kPlanted) {
    inputs.digests.truth = load_truth(request.truth.value_or(folder.truth()), inputs.study).digest;
  }
  check_has_protocol(folder, inputs.study);
  inputs.protocol = load_session_protocol(folder.session());
  inputs.digests.protocol = inputs.protocol.digest;
  inputs.familiar_pages =
      enumerate_familiar_pages(inputs.study, inputs.protocol, inputs.experiment, inputs.cells);
  const auto keys = enumerate_session_keys(inputs);
  inputs.digests.manifest = digest_pictures(manifest, keys, folder.manifest().string());
  refuse_findings(find_change_mark(folder), folder);
  refuse_findings(find_verdict(folder), folder);
  refuse_findings(verify_pictures(folder, inputs.study, manifest, keys), folder);
  return inputs;
}

std::optional<SessionRow> find_unfinished_session(const SessionInputs& inputs, const TrialLog& log,
                                                  const SessionRequest& request) {
  EQ_CHECK(request.kind == inputs.kind && request.experiment == inputs.experiment);
  std::optional<SessionRow> unfinished;
  const std::vector<SessionRow> sessions = log.load_sessions();
  for (const SessionRow& row : sessions) {
    if (row.kind != inputs.kind || row.experiment != inputs.experiment) continue;
    check_same_digests(row, inputs.digests, inputs.folder);
    if (row.participant != request.participant) continue;
    if (row.complete) {
      throw InputError(
          inputs.folder.responses().string(), "participant",
          fmt::format("a code that has not finished the {} experiment", format_experiment(inputs.experiment)),
          fmt::format("{}, of finished session {}", row.participant, row.id));
    }
    unfinished = row;
  }
  log.check_not_withdrawn(request.participant);
  if (!unfinished && inputs.kind == SubjectKind::kPerson)
    check_new_code(inputs, sessions, request.participant);
  if (unfinished && inputs.kind == SubjectKind::kPerson) check_may_resume(inputs, log, *unfinished, request);
  return unfinished;
}

std::optional<SessionRow> find_interrupted(const StudyFolder& folder) {
  if (!TrialLog::is_at(folder.responses())) return std::nullopt;
  const TrialLog log = TrialLog::load_snapshot(folder.responses());
  std::optional<SessionRow> last;
  std::string last_seen_utc;
  for (const SessionRow& row : log.load_sessions()) {
    if (row.kind != SubjectKind::kPerson || row.complete) continue;
    const auto events = log.load_events(row.id);
    const std::string seen_utc = events.empty() ? row.started_utc : events.back().recorded_utc;
    if (find_abort_reason(events) || (last && seen_utc < last_seen_utc)) continue;
    if (SessionLock::is_held(folder.responses(), name_lock(row.kind, row.experiment, row.participant)))
      continue;
    last = row;
    last_seen_utc = seen_utc;
  }
  return last;
}

void check_not_running(const SessionInputs& inputs, const TrialLog& log, const SessionRequest& request) {
  if (SessionLock::is_held(inputs.folder.responses(), name_lock(inputs, request.participant)))
    refuse_running(inputs, log, request.participant);
}

void check_can_record(const StudyFolder& folder, std::uintmax_t least_free) {
  const std::string log = folder.responses().string();
  for (const std::string& path : {folder.root.string(), log, log + ".lock"}) {
    if (::faccessat(AT_FDCWD, path.c_str(), W_OK, AT_EACCESS) == 0 || errno == ENOENT) continue;
    throw StoreError(fmt::format("{}: cannot be written: {}; a session's answers are kept there", path,
                                 std::strerror(errno)));
  }
  std::error_code not_told;
  const fs::space_info space = fs::space(folder.root, not_told);
  // Of some file systems the size is not known: none of it, then.
  if (not_told || space.capacity == 0 || space.available >= least_free) return;
  throw StoreError(
      fmt::format("{}: of its disk {:.1f} MiB are free, and a session wants {:.0f}; make room first",
                  folder.root.string(), std::ldexp(space.available, -20), std::ldexp(least_free, -20)));
}

namespace {

// The pictures may have been replaced since they were looked at. Asked when the log is there: whoever
// replaces pictures marks the folder, then looks for a log.
void check_still_shown(const SessionInputs& inputs) {
  refuse_findings(find_change_mark(inputs.folder), inputs.folder);
  const std::string source = inputs.folder.manifest().string();
  const Manifest manifest = load_checked_manifest(inputs.folder, inputs.study);
  if (digest_pictures(manifest, enumerate_session_keys(inputs), source) != inputs.digests.manifest)
    throw InputError(source, "/pictures", "the pictures that the session was prepared with",
                     "others, made since; begin again");
}

void check_unchanged(const std::filesystem::path& file, const std::string& before, const std::string& now) {
  if (now == before) return;
  throw InputError(file.string(), "", "the file that the session was prepared with",
                   "another, changed since; begin again");
}

// Nor a file that people edit: no later session could be made from what is gone. A log may be null.
void check_still_same(const SessionInputs& inputs, const TrialLog* log) {
  const StudyFolder& folder = inputs.folder;
  const SessionDigests& digests = inputs.digests;
  check_unchanged(folder.study(), digests.study, load_folder_study(folder).digest);
  check_unchanged(folder.session(), digests.protocol, load_session_protocol(folder.session()).digest);
  if (inputs.experiment == Experiment::kArtifact) {
    check_unchanged(inputs.study.windows_path, digests.windows,
                    load_windows(inputs.study.windows_path, inputs.study).digest);
  } else {
    check_unchanged(folder.selection(inputs.kind), digests.selection,
                    digest_selection(load_current_selection(folder, log, inputs.study, inputs.kind)));
  }
  check_still_shown(inputs);
}

}  // namespace

TrialLog make_log(const SessionInputs& inputs) {
  check_still_same(inputs, nullptr);
  return TrialLog(inputs.folder.responses(), true);
}

// Locked before it is looked for, so that of two who begin at once one waits for nobody and one is refused.
OpenSession open_session(const SessionInputs& inputs, TrialLog& log, const SessionRequest& request) {
  check_still_same(inputs, &log);
  SessionLock lock(inputs.folder.responses(), name_lock(inputs, request.participant));
  if (lock.is_busy()) refuse_running(inputs, log, request.participant);
  const auto unfinished = find_unfinished_session(inputs, log, request);
  return unfinished ? resume_session(inputs, log, *unfinished, request, std::move(lock))
                    : begin_session(inputs, log, request, std::move(lock));
}

OpenSession open_session(const StudyFolder& folder, TrialLog& log, const SessionRequest& request) {
  return open_session(load_session_inputs(folder, &log, request), log, request);
}

void record_effect(TrialLog& log, std::int64_t session, const SessionEffect& effect) {
  const auto record = [&](const auto& what) {
    using Effect = std::decay_t<decltype(what)>;
    if constexpr (std::is_same_v<Effect, RecordShowing>) {
      log.append_showing(session, what.trial, what.time_ns);
    } else if constexpr (std::is_same_v<Effect, RecordAnswer>) {
      log.append_answer(session, what.answer, what.next, what.time_ns);
    } else if constexpr (std::is_same_v<Effect, RecordFinish>) {
      log.finish_session(session, what.time_ns);
    } else if constexpr (std::is_same_v<Effect, RecordAbort>) {
      log.append_event(session, "abort", what.time_ns, what.reason);
    } else if constexpr (std::is_same_v<Effect, RecordNote>) {
      log.append_event(session, what.kind, what.time_ns, what.detail);
    }
  };
  std::visit(record, effect);
}

void check_spelling(const std::string& code, const std::string& source) {
  constexpr std::size_t kLongest = 64;
  const auto may_be = [](unsigned char c) { return std::isalnum(c) || c == '-' || c == '_' || c == '.'; };
  if (!code.empty() && code.size() <= kLongest && std::all_of(code.begin(), code.end(), may_be)) return;
  throw InputError(source, "participant",
                   fmt::format("a code and no name: a digit or more beside letters from a to z, -, _ and ., "
                               "at most {} of them",
                               kLongest),
                   "\"" + code + "\"");
}

void check_code(const std::string& code, const std::string& source) {
  check_spelling(code, source);
  if (has_digit(code)) return;
  throw InputError(source, "participant", "a code and no name: a digit or more beside letters",
                   "\"" + code + "\"");
}

std::string format_lane(const Lane& lane) { return fmt::format("{}/{}", lane.first + 1, lane.step); }

Lane find_lane(const TrialLog* log, const std::optional<Lane>& given) {
  if (given || !log) return given.value_or(Lane{});
  const std::string station = log->load_station();
  Lane lane;
  for (const SessionRow& row : log->load_sessions()) {
    const auto field = row.fields.find(kLaneField);
    if (row.station == station && field != row.fields.end())
      lane = parse_lane(field->second, "field " + std::string(kLaneField));
  }
  return lane;
}

Lane parse_lane(const std::string& text, const std::string& source) {
  constexpr int kMostStations = 1000;
  int number = 0, count = 0, length = 0;
  const bool is_read = std::sscanf(text.c_str(), "%4d/%4d%n", &number, &count, &length) == 2 &&
                       static_cast<std::size_t>(length) == text.size();
  if (!is_read || number < 1 || number > count || count > kMostStations)
    throw InputError(source, "", "K/N, the K-th of N stations, such as 2/3", text);
  return {number - 1, count};
}

std::uint64_t draw_seed() {
  std::random_device entropy;
  return ((std::uint64_t{entropy()} << 32) | entropy()) >> 1;
}

}  // namespace equilux
