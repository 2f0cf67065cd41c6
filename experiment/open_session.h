// How a session begins, or goes on: the one door for persons and simulated subjects.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiment/extra_trials.h"
#include "experiment/session.h"
#include "experiment/session_lock.h"
#include "experiment/trial_log.h"
#include "stimuli/study_folder.h"

namespace equilux {

struct SessionRequest {
  Experiment experiment = Experiment::kArtifact;
  SubjectKind kind = SubjectKind::kPerson;
  std::string participant;                     ///< code
  std::uint64_t seed = 0;                      ///< of a new session; a resumed one keeps its own
  std::optional<std::filesystem::path> truth;  ///< planted subjects only
  ScreenRecord screen;
  std::map<std::string, std::string> fields = {};  ///< of a new session
  std::optional<Lane> lane = {};                   ///< of a new session; empty: as find_lane gives it
  std::string now_utc = {};    ///< for the age limit of a resume; the system clock where empty
  bool accepts_clock = false;  ///< the experimenter was told that the clock is behind the log, and goes on
};

struct OpenSession {
  SessionRow row;
  Session session;
  bool resumed = false;
  SessionLock lock;  ///< while it is held no other program opens this session
};

/// "2/3": the second of three stations. errors: InputError
Lane parse_lane(const std::string& text, const std::string& source);
std::string format_lane(const Lane& lane);

/// Where none is given, that of the last session that was begun in this log with one; a log may be null.
Lane find_lane(const TrialLog* log, const std::optional<Lane>& given);

/// Of a new participant, that it is a code and no name, and one that file names and tables take.
/// errors: InputError
void check_code(const std::string& code, const std::string& source);
/// The latter alone, of a code that a log has already: older ones may have no digit. errors: InputError
void check_spelling(const std::string& code, const std::string& source);

/// What all sessions of an experiment and kind in a folder are made from, loaded and checked once.
struct SessionInputs {
  StudyFolder folder;
  Experiment experiment = Experiment::kArtifact;
  SubjectKind kind = SubjectKind::kPerson;
  Study study;
  std::vector<Cell> cells;
  SessionDigests digests;
  SessionProtocol protocol;
  std::vector<FamiliarPage> familiar_pages;
};

/// The folder's log; empty where no session has begun yet. errors: as TrialLog
std::optional<TrialLog> find_log(const StudyFolder& folder);

/// Every picture that a session of these inputs may show, each once, sorted.
std::vector<std::string> enumerate_session_keys(const SessionInputs& inputs);

/// Of the request only experiment, kind and truth count. `log` is null where no session has begun: a log is
/// made only for a session that can begin, since the pictures of a folder with a log may not change any more.
/// A selection must be of the artifact answers in the log, unless a session has used it: then it is frozen,
/// and stays in force. errors: InputError
SessionInputs load_session_inputs(const StudyFolder& folder, const TrialLog* log,
                                  const SessionRequest& request);

/// The folder's log, made for a session that is about to begin. errors: InputError as open_session, where
/// pictures or a file were replaced since `inputs`; as TrialLog
TrialLog make_log(const SessionInputs& inputs);

/// The participant's session that may go on, after the checks of open_session; empty where a new one would
/// begin. errors: as open_session
std::optional<SessionRow> find_unfinished_session(const SessionInputs& inputs, const TrialLog& log,
                                                  const SessionRequest& request);

/// A person's session that was neither finished nor ended on purpose, and runs in no window: the one of these
/// that was seen last. errors: as TrialLog
std::optional<SessionRow> find_interrupted(const StudyFolder& folder);

/// Before anybody is asked anything; open_session makes sure. errors: InputError that names log and session
/// where another window runs the participant's session
void check_not_running(const SessionInputs& inputs, const TrialLog& log, const SessionRequest& request);

/// What a session may write before a disk is too full for one. units: bytes
inline constexpr std::uintmax_t kLeastFree = std::uintmax_t{16} << 20;

/// Before anybody is asked anything. errors: StoreError where folder or log cannot be written, or fewer bytes
/// are free than `least_free`
void check_can_record(const StudyFolder& folder, std::uintmax_t least_free = kLeastFree);

/// Checks study, manifest, windows or selection of the folder, then goes on with the participant's unfinished
/// session of this experiment and kind, or begins one at the lowest free index. errors: InputError if a
/// picture is missing, while pictures are replaced (change_mark.h) or if they, study, windows, selection or
/// protocol were since `inputs`, if the participant has finished this experiment, if the protocol lets no
/// person go on with an interrupted session, or not after so long, or where that cannot be told by the clock,
/// if an earlier session of this experiment and kind was made from other digests, or as check_not_running;
/// StoreError from the log.
OpenSession open_session(const StudyFolder& folder, TrialLog& log, const SessionRequest& request);
OpenSession open_session(const SessionInputs& inputs, TrialLog& log, const SessionRequest& request);

/// Writes what a Record* effect says to the log; a ShowTrial is the caller's. errors: StoreError
void record_effect(TrialLog& log, std::int64_t session, const SessionEffect& effect);

/// Seed for a new session of a person, from the system's entropy; below 2^63, as the log keeps it.
std::uint64_t draw_seed();

}  // namespace equilux
