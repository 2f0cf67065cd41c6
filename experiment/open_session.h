// How a session begins, or goes on: the one door for persons and simulated subjects.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "experiment/session.h"
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
};

struct OpenSession {
  SessionRow row;
  Session session;
  bool resumed = false;
};

/// Checks study, manifest, windows or selection of the folder, then goes on with the participant's unfinished
/// session of this experiment and kind, or begins one at the lowest free index. errors: InputError if a
/// picture is missing, if the participant has finished this experiment, or if an unfinished session was made
/// from other digests; StoreError from the log.
OpenSession open_session(const StudyFolder& folder, TrialLog& log, const SessionRequest& request);

/// Writes what a Record* effect says to the log; a ShowTrial is the caller's. errors: StoreError
void record_effect(TrialLog& log, std::int64_t session, const SessionEffect& effect);

}  // namespace equilux
