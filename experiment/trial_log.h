// responses.sqlite: who answered what, and when. The only thing of this folder that analysis reads.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "protocols/condition.h"
#include "protocols/experiment.h"

namespace equilux {

inline constexpr int kLogSchemaVersion = 2;  ///< PRAGMA user_version of the file

enum class Side { kLeft, kRight };

/// Why a pair is shown. Only answers of the main phase are counted; catch trials, of a known answer, tell
/// whether a subject attends.
enum class Phase { kPractice, kMain, kCatch };

std::string format_phase(Phase phase);

/// What a session was made from: resuming or repeating it with others is an error.
struct SessionDigests {
  std::string study;
  std::string manifest;   ///< digest_pictures of the pictures that its experiment may show
  std::string windows;    ///< empty in material sessions
  std::string selection;  ///< empty in artifact sessions
  std::string truth;      ///< empty unless planted
  std::string protocol;   ///< of session.json; empty before schema 2
  bool operator==(const SessionDigests&) const = default;
};

/// What is known of the screen; all empty for simulated subjects.
struct ScreenRecord {
  std::string monitor;
  std::optional<int> framebuffer_width;   ///< pixels
  std::optional<int> framebuffer_height;  ///< pixels
  std::optional<double> viewing_distance_m;
  std::optional<double> degrees_wide;  ///< of one picture, as achieved
  std::optional<double> degrees_high;
};

struct SessionRow {
  std::int64_t id = 0;
  std::string participant;  ///< code
  SubjectKind kind = SubjectKind::kPerson;
  Experiment experiment = Experiment::kArtifact;
  std::int64_t subject_index = 0;  ///< unique among the sessions of its kind and experiment
  std::uint64_t seed = 0;
  std::string program_version;
  SessionDigests digests;
  ScreenRecord screen;
  std::string started_utc;
  bool complete = false;                      ///< set only at the very end
  std::string uuid;                           ///< the same session in any log; drawn where empty
  std::string station;                        ///< of the log in which it was begun; by the log
  std::map<std::string, std::string> fields;  ///< what was asked and measured at its start, by name
};

/// One scheduled trial; the last three are empty until it is answered.
struct TrialRow {
  int number = 0;  ///< 0 .. n-1, order of showing
  Phase phase = Phase::kMain;
  Cell cell;              ///< what is counted
  std::string test_key;   ///< the VPL picture
  std::string pair_key;   ///< the reference beside it
  std::string upper_key;  ///< the reference above; empty in artifact trials
  Side test_side = Side::kLeft;
  std::optional<Side> answer;
  std::optional<std::int64_t>
      response_time_ns;  ///< monotonic clock, from the onset of this showing to the press
  std::optional<std::string> answered_utc;
  bool too_fast = false;  ///< answered in less than the protocol's least time
  bool operator==(const TrialRow&) const = default;
};

/// What answers are counted by of a TrialRow: no names of pictures, no time of day.
struct BriefTrial {
  int number = 0;
  Phase phase = Phase::kMain;
  std::uint32_t cell = 0;   ///< index into BriefTrials::cells
  std::optional<int> view;  ///< of the test picture; empty where its name ends in none
  Side test_side = Side::kLeft;
  std::optional<Side> answer;
  std::int64_t response_time_ns = 0;  ///< as in TrialRow; 0 where there is no answer
  bool too_fast = false;
  bool operator==(const BriefTrial&) const = default;
};

/// The trials of all sessions of a log.
struct BriefTrials {
  std::vector<Cell> cells;                                     ///< each once, in no order
  std::map<std::int64_t, std::vector<BriefTrial>> by_session;  ///< in order of showing
};

/// Something that happened; docs/responses.md names the kinds.
struct EventRow {
  std::optional<int> trial;  ///< empty for events of the whole session
  std::string kind;
  std::int64_t time_ns = 0;  ///< monotonic clock
  std::string recorded_utc;
  std::string detail;
  bool operator==(const EventRow&) const = default;
};

/// Where answers were exported to, and when last.
struct ExportRow {
  std::string path;  ///< absolute
  std::string made_utc;
  std::string station = {};  ///< at which it was made; empty: at that of this log
};

/// An answer as the session reports it.
struct Answer {
  int trial = 0;
  Side side = Side::kLeft;
  std::int64_t response_time_ns = 0;
  bool too_fast = false;
};

/// One answer of a finished session.
struct AnswerRow {
  std::int64_t session = 0;
  std::int64_t subject_index = 0;
  Cell cell;
  bool correct = false;
};

/// Indices that a station gives out where several run a study side by side: first, first + step, ... So their
/// logs, merged, are balanced.
struct Lane {
  std::int64_t first = 0;
  std::int64_t step = 1;
  bool operator==(const Lane&) const = default;
};

/// How well a snapshot is looked at before anything is read.
enum class LogCheck {
  kWhole,   ///< tables and indexes
  kTables,  ///< in a third of the time, for who asks for sessions, events and load_brief_trials, which go by
            ///< no index: tables, but for the values of trials, which load_brief_trials looks at itself
};

/// The log. One committed transaction for each change; a database that cannot be written throws StoreError.
class TrialLog {
 public:
  /// Opens, or makes where `create`; brings one of an older schema up to this one, keeping a copy. errors:
  /// InputError for a file that is no log, has a newer schema, or is missing and not to be made; StoreError
  /// where WAL cannot work.
  explicit TrialLog(const std::filesystem::path& path, bool create = false);
  /// Whether there is one, see has_log.
  static bool is_at(const std::filesystem::path& path);
  /// The log as its last commit left it, in memory: the file and what stands beside it are not touched.
  /// errors: as above
  static TrialLog load_snapshot(const std::filesystem::path& path, LogCheck check = LogCheck::kWhole);
  ~TrialLog();
  TrialLog(TrialLog&&) noexcept;
  TrialLog& operator=(TrialLog&&) noexcept;

  /// Writes session, participant and all trials in one transaction; gives the session's id. `row.id`,
  /// `station` and `complete` are the log's own. errors: InputError if the index is taken or the participant
  /// withdrew.
  std::int64_t append_session(const SessionRow& row, const std::vector<TrialRow>& trials);

  std::vector<SessionRow> load_sessions() const;
  std::vector<TrialRow> load_trials(std::int64_t session) const;
  /// As load_trials, of all sessions at once, in a small part of the time. errors: InputError for a value
  /// that the schema does not allow, since LogCheck::kTables leaves these to this
  BriefTrials load_brief_trials() const;
  std::vector<EventRow> load_events(std::int64_t session) const;  ///< in order of recording
  std::string load_station() const;                               ///< this log's own
  std::int64_t count_withdrawn() const;                           ///< tombstones
  bool has_withdrawn(const std::string& code) const;
  /// errors: InputError if somebody of this code has withdrawn
  void check_not_withdrawn(const std::string& code) const;
  /// Lowest index of this lane that no session of this kind and experiment holds.
  std::int64_t find_free_index(SubjectKind kind, Experiment experiment, const Lane& lane = {}) const;
  bool has_session_using_selection(const std::string& selection_digest) const;

  /// A showing without an answer: the first of a session, or again after a resume.
  void append_showing(std::int64_t session, int trial, std::int64_t time_ns);
  /// The answer to one pair and the showing of the next (none after the last), in one transaction. errors:
  /// StoreError if that trial is answered already.
  void append_answer(std::int64_t session, const Answer& answer, std::optional<int> next_trial,
                     std::int64_t time_ns);
  /// Any other thing that happened. `detail` is free text.
  void append_event(std::int64_t session, const std::string& kind, std::int64_t time_ns,
                    const std::string& detail = "");
  /// What became known after the session's start; each name once. errors: StoreError
  void append_field(std::int64_t session, const std::string& name, const std::string& value);
  /// That answers were exported to `path`, for a later withdrawal to name.
  void append_export(const std::string& path);
  std::vector<ExportRow> load_exports() const;  ///< each path once, sorted; after a merge other stations' too
  /// Marks the session complete. errors: StoreError if a trial is unanswered.
  void finish_session(std::int64_t session, std::int64_t time_ns);
  /// After the last of a sitting: the file alone, copied from now on, is whole, unless somebody reads it just
  /// now. append_session does the same, so that no copy lacks the session.
  void empty_wal() const;

  /// Answers of the main phase, of the complete sessions of a kind and experiment, in order of session and
  /// trial.
  std::vector<AnswerRow> load_answers(SubjectKind kind, Experiment experiment) const;

  /// A PRAGMA as this connection has it, by its name: journal_mode, synchronous, foreign_keys.
  std::string load_setting(const std::string& name) const;

 private:
  struct Impl;
  explicit TrialLog(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Why a session was ended early, from its events; empty if it was not, or has gone on since.
std::optional<std::string> find_abort_reason(const std::vector<EventRow>& events);

/// What broke off the last sitting of a session that nobody ended, where the program could tell; empty if
/// nothing did, or it has gone on since.
std::optional<std::string> find_interruption(const std::vector<EventRow>& events);

/// Digest of answers, sorted and canonical: independent of the order of sessions and of the database file.
std::string digest_answers(const std::vector<AnswerRow>& answers);

/// The same of answers that are told one by one, their cells by number.
class AnswersDigest {
 public:
  void add(std::uint32_t cell, std::int64_t subject_index, bool correct);
  /// `cells` by their numbers, each once.
  std::string finish(const std::vector<Cell>& cells);

 private:
  std::vector<std::int64_t> subjects_;                     ///< in order of their first answers
  std::unordered_map<std::int64_t, std::uint32_t> ranks_;  ///< in that order
  std::uint32_t last_ = 0;                                 ///< rank of who answered last
  std::vector<std::vector<std::uint32_t>> by_cell_;  ///< of each answer twice the rank, 1 more if correct
};

}  // namespace equilux
