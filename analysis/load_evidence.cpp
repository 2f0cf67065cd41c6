// The one file of analysis that opens the log.
#include <set>

#include "analysis/evidence.h"
#include "base/error.h"

namespace equilux {
namespace {

ExperimentEvidence load_experiment(const TrialLog& log, const std::vector<SessionRow>& sessions,
                                   SubjectKind kind, Experiment experiment, const Study& study,
                                   const std::string& source) {
  ExperimentEvidence evidence = gather_sessions(sessions, kind, experiment, study, source);
  evidence.answers = log.load_answers(kind, experiment);
  evidence.digest = digest_answers(evidence.answers);
  for (const SessionRow& session : sessions) {
    if (session.kind == kind && session.experiment == experiment)
      evidence.summaries.push_back(summarise_session(session, log.load_trials(session.id)));
  }
  return evidence;
}

}  // namespace

Evidence load_evidence(const StudyFolder& folder, const Study& study, std::optional<SubjectKind> wanted) {
  const std::string source = folder.responses().string();
  if (!std::filesystem::exists(folder.responses())) {
    throw InputError(source, "", "the answers of `equilux-session`", "no file");
  }
  const TrialLog log = TrialLog::load_snapshot(folder.responses());
  const auto sessions = log.load_sessions();
  Evidence evidence;
  evidence.kind = choose_kind(sessions, wanted, source);
  evidence.artifact = load_experiment(log, sessions, evidence.kind, Experiment::kArtifact, study, source);
  evidence.material = load_experiment(log, sessions, evidence.kind, Experiment::kMaterial, study, source);
  return evidence;
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
