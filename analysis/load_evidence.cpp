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

// The answers of one experiment and their digest. Held to the study here, where log and session have the
// names by which they can be found.
class Counted {
 public:
  Counted(ExperimentEvidence& evidence, const LogReading& reading, const Study& study)
      : evidence_(evidence), reading_(reading), study_(study) {
    const auto cells = enumerate_cells(study);
    const std::set<Cell> own(cells.begin(), cells.end());
    for (const Cell& cell : reading.trials.cells) {
      numbers_.push_back(evidence.answers.number_of(cell));
      is_own_.push_back(own.contains(cell));
    }
    answered_in_.resize(numbers_.size());
  }

  // A finished session has an answer to every trial, unless somebody changed its log.
  void add(const SessionRow& session, const std::vector<BriefTrial>& trials) {
    for (const BriefTrial& trial : trials) {
      if (trial.phase != Phase::kMain) continue;
      if (!trial.answer) {
        ++evidence_.unanswered;
        continue;
      }
      check(session, trial);
      const bool correct = *trial.answer == trial.test_side;
      evidence_.answers.push_back(CountedAnswer{session.id, numbers_[trial.cell], correct});
      digest_.add(trial.cell, session.subject_index, correct);
    }
  }

  std::string finish_digest() { return digest_.finish(reading_.trials.cells); }

 private:
  void check(const SessionRow& session, const BriefTrial& trial) {
    if (!is_own_[trial.cell]) refuse(session, trial, fmt::format("a cell of the study {}", study_.name), "");
    if (answered_in_[trial.cell] == session.id) refuse(session, trial, "one answer to each cell", " again");
    answered_in_[trial.cell] = session.id;
  }
  [[noreturn]] void refuse(const SessionRow& session, const BriefTrial& trial, const std::string& expected,
                           const char* again) const {
    throw InputError(reading_.source,
                     fmt::format("session {} of {}, trial {}", session.id, session.participant, trial.number),
                     expected, format_key(reading_.trials.cells[trial.cell]) + again);
  }

  ExperimentEvidence& evidence_;
  const LogReading& reading_;
  const Study& study_;
  std::vector<std::uint32_t> numbers_;                    // of the log's cells among those of the answers
  std::vector<bool> is_own_;                              // whether the study has them
  std::vector<std::optional<std::int64_t>> answered_in_;  // the last session that answered each
  AnswersDigest digest_;
};

// Each trial is read once.
ExperimentEvidence load_experiment(LogReading& reading, SubjectKind kind, Experiment experiment,
                                   const Study& study) {
  ExperimentEvidence evidence = gather_sessions(reading.sessions, kind, experiment, study, reading.source);
  Counted counted(evidence, reading, study);
  for (const SessionRow& session : reading.sessions) {
    if (session.kind != kind || session.experiment != experiment) continue;
    const auto trials = std::exchange(reading.trials.by_session[session.id], {});
    if (evidence.answers.empty()) evidence.answers.reserve(trials.size() * evidence.finished.size());
    if (session.complete) counted.add(session, trials);
    evidence.summaries.push_back(summarise(reading, session, trials));
  }
  evidence.digest = counted.finish_digest();
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
