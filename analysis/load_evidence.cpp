// The one file of analysis that opens the log.
#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "analysis/evidence.h"
#include "base/error.h"
#include "protocols/session_protocol.h"

namespace equilux {
namespace {

struct LogReading {
  const TrialLog& log;
  std::vector<SessionRow> sessions;
  BriefTrials trials;
  SessionProtocol protocol;  ///< of the folder now
  std::string source;
};

SessionSummary summarise(const LogReading& reading, const SessionRow& session,
                         const std::vector<BriefTrial>& trials) {
  SessionSummary summary = summarise_session(session, trials);
  if (!session.complete) summary.abort_reason = find_abort_reason(reading.log.load_events(session.id));
  const auto& asked = reading.protocol.catch_trials;
  const bool has_catch_trials = std::any_of(
      trials.begin(), trials.end(), [](const BriefTrial& trial) { return trial.phase == Phase::kCatch; });
  if (asked && has_catch_trials && session.digests.protocol == reading.protocol.digest)
    summary.catch_pass = asked->pass;
  return summary;
}

// The answers of one experiment and their digest.
struct Counted {
  ExperimentEvidence& evidence;
  std::vector<std::uint32_t> numbers;  // of the log's cells among those of the answers
  AnswersDigest digest = {};

  Counted(ExperimentEvidence& counted, const std::vector<Cell>& cells) : evidence(counted) {
    for (const Cell& cell : cells) numbers.push_back(evidence.answers.number_of(cell));
  }

  // A finished session has an answer to every trial, unless somebody changed its log.
  void add(const SessionRow& session, const std::vector<BriefTrial>& trials) {
    for (const BriefTrial& trial : trials) {
      if (trial.phase != Phase::kMain) continue;
      if (!trial.answer) {
        ++evidence.unanswered;
        continue;
      }
      const bool correct = *trial.answer == trial.test_side;
      evidence.answers.push_back(CountedAnswer{session.id, numbers[trial.cell], correct});
      digest.add(trial.cell, session.subject_index, correct);
    }
  }
};

// Each trial is read once.
ExperimentEvidence load_experiment(LogReading& reading, SubjectKind kind, Experiment experiment,
                                   const Study& study) {
  ExperimentEvidence evidence = gather_sessions(reading.sessions, kind, experiment, study, reading.source);
  Counted counted(evidence, reading.trials.cells);
  for (const SessionRow& session : reading.sessions) {
    if (session.kind != kind || session.experiment != experiment) continue;
    const auto trials = std::exchange(reading.trials.by_session[session.id], {});
    if (evidence.answers.empty()) evidence.answers.reserve(trials.size() * evidence.finished.size());
    if (session.complete) counted.add(session, trials);
    evidence.summaries.push_back(summarise(reading, session, trials));
  }
  evidence.digest = counted.digest.finish(reading.trials.cells);
  return evidence;
}

// A log as it stands in a folder.
struct FolderLog {
  explicit FolderLog(const StudyFolder& folder)
      : log(TrialLog::load_snapshot(check_is_there(folder), LogCheck::kTables)),
        reading{log, log.load_sessions(), log.load_brief_trials(), load_session_protocol(folder.session()),
                folder.responses().string()} {}

  static std::filesystem::path check_is_there(const StudyFolder& folder) {
    if (!std::filesystem::exists(folder.responses()))
      throw InputError(folder.responses().string(), "", "the answers of `equilux-session`", "no file");
    return folder.responses();
  }

  /// Once: what is counted is taken out of the reading.
  Evidence load(const Study& study, SubjectKind kind) {
    Evidence evidence;
    evidence.kind = kind;
    evidence.artifact = load_experiment(reading, kind, Experiment::kArtifact, study);
    evidence.material = load_experiment(reading, kind, Experiment::kMaterial, study);
    evidence.withdrawn = log.count_withdrawn();
    evidence.others = count_others(reading.sessions, kind);
    return evidence;
  }

  TrialLog log;
  LogReading reading;
};

}  // namespace

Evidence load_evidence(const StudyFolder& folder, const Study& study, std::optional<SubjectKind> wanted) {
  FolderLog found(folder);
  return found.load(study, choose_kind(found.reading.sessions, wanted, found.reading.source));
}

std::optional<Evidence> find_evidence(const StudyFolder& folder, const Study& study,
                                      std::optional<SubjectKind> wanted) {
  FolderLog found(folder);
  const auto kind = find_kind(found.reading.sessions, wanted, found.reading.source);
  if (!kind) return std::nullopt;
  return found.load(study, *kind);
}

Evidence load_evidence_of(const StudyFolder& folder, const Study& study, SubjectKind kind) {
  return FolderLog(folder).load(study, kind);
}

std::vector<std::string> find_used_selections(const TrialLog& log, SubjectKind kind) {
  std::set<std::string> used;
  for (const SessionRow& session : log.load_sessions()) {
    if (session.kind == kind && session.experiment == Experiment::kMaterial) {
      used.insert(session.digests.selection);
    }
  }
  return {used.begin(), used.end()};
}

}  // namespace equilux
