// The report's first steps, without its draws.
#include "analysis/interim.h"

#include <optional>

#include "analysis/evidence.h"
#include "base/files.h"
#include "stimuli/selection.h"

namespace equilux {
namespace {

// One experiment's sessions, counted, and its answers.
Tally read_experiment(const TrialLog& log, const std::vector<SessionRow>& sessions, SubjectKind kind,
                      Experiment experiment, const Study& study, const std::string& source,
                      SessionCounts& counts) {
  const ExperimentEvidence evidence = gather_sessions(sessions, kind, experiment, study, source);
  counts = {std::ssize(evidence.finished), evidence.unfinished};
  return tally_answers(log.load_answers(kind, experiment), study);
}

}  // namespace

InterimFindings load_interim(const StudyFolder& folder, const Study& study, SubjectKind kind) {
  InterimFindings interim;
  std::optional<Selection> selection;
  if (path_exists(folder.selection(kind))) selection = load_selection(folder.selection(kind), study);
  Tally artifact = tally_answers({}, study), material = artifact;
  if (TrialLog::is_at(folder.responses())) {
    const TrialLog log = TrialLog::load_snapshot(folder.responses());
    const auto sessions = log.load_sessions();
    const std::string source = folder.responses().string();
    artifact = read_experiment(log, sessions, kind, Experiment::kArtifact, study, source, interim.artifact);
    material = read_experiment(log, sessions, kind, Experiment::kMaterial, study, source, interim.material);
  }
  interim.columns = find_equivalence(study, artifact, material, selection ? &*selection : nullptr);
  return interim;
}

}  // namespace equilux
