// What a report or a pruning rests on: the finished sessions of one kind, and how many were left out.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/answers.h"
#include "analysis/subjects.h"
#include "experiment/trial_log.h"
#include "stimuli/study_folder.h"

namespace equilux {

/// One experiment, one kind of subjects.
struct ExperimentEvidence {
  std::vector<SessionRow> finished;  ///< in order of subject index
  Answers answers;                   ///< of the finished sessions
  std::int64_t unfinished = 0;       ///< sessions left out
  std::int64_t unanswered = 0;       ///< main trials of finished sessions without an answer, left out
  std::string digest;                ///< digest_answers; of a pool, of its logs' digests, sorted
  std::vector<SessionSummary> summaries = {};  ///< of finished and unfinished sessions
};

/// Finished sessions, counted.
using SessionTotals = std::map<std::pair<SubjectKind, Experiment>, std::int64_t>;

struct Evidence {
  SubjectKind kind = SubjectKind::kPerson;
  ExperimentEvidence artifact;
  ExperimentEvidence material;
  std::int64_t withdrawn = 0;  ///< tombstones: a participant of several logs has one in each
  SessionTotals others = {};   ///< finished sessions of other kinds, which are not counted

  const ExperimentEvidence& of(Experiment experiment) const {
    return experiment == Experiment::kArtifact ? artifact : material;
  }
};

/// `wanted`, or else the only kind with finished artifact sessions. errors: InputError naming `source` where
/// there is none, or where there are several to choose from.
SubjectKind choose_kind(const std::vector<SessionRow>& sessions, std::optional<SubjectKind> wanted,
                        const std::string& source);

/// Finished sessions of every kind but `kind`.
SessionTotals count_others(const std::vector<SessionRow>& sessions, std::optional<SubjectKind> kind);

/// "14 material sessions of the kind person"
std::string describe_totals(const SessionTotals& totals);

/// The same as choose_kind, empty where there is none.
std::optional<SubjectKind> find_kind(const std::vector<SessionRow>& sessions,
                                     std::optional<SubjectKind> wanted, const std::string& source);

/// The sessions of a kind and experiment, without their answers. errors: InputError for a finished session
/// that was made from another study.
ExperimentEvidence gather_sessions(const std::vector<SessionRow>& sessions, SubjectKind kind,
                                   Experiment experiment, const Study& study, const std::string& source);

/// Of the unfinished sessions those that the experimenter ended early; the others were left, and may go on.
std::int64_t count_ended_early(const ExperimentEvidence& evidence);

/// Reads the log of a study folder. errors: InputError without a log or without finished artifact sessions,
/// and for a session.json that cannot be read.
Evidence load_evidence(const StudyFolder& folder, const Study& study, std::optional<SubjectKind> wanted);

/// The same, empty without finished artifact sessions.
std::optional<Evidence> find_evidence(const StudyFolder& folder, const Study& study,
                                      std::optional<SubjectKind> wanted);

/// The same of one kind, whatever there is of it, as of a log in a pool that nobody has finished.
Evidence load_evidence_of(const StudyFolder& folder, const Study& study, SubjectKind kind);

/// Adds the evidence of several logs of one study up; sessions get new numbers 1, 2, ... in the order of
/// `parts`, and the folder of each beside it. errors: InputError for parts of different kinds, and for a
/// session that two of them have, finished or not, by its uuid.
Evidence pool_evidence(std::vector<Evidence> parts, const std::vector<std::string>& folders);

/// The answers of these sessions of an experiment. `sessions` is sorted.
Answers select_answers(const ExperimentEvidence& evidence, const std::vector<std::int64_t>& sessions);

/// Digests of the selections that the material sessions were made from, finished or not, each once.
std::vector<std::string> find_used_selections(const TrialLog& log, SubjectKind kind);

}  // namespace equilux
