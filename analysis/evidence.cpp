// Sessions sorted into those that count and those left out.
#include "analysis/evidence.h"

#include <algorithm>
#include <set>

#include "base/error.h"

namespace equilux {
SubjectKind choose_kind(const std::vector<SessionRow>& sessions, std::optional<SubjectKind> wanted,
                        const std::string& source) {
  std::set<SubjectKind> kinds;
  std::int64_t unfinished = 0;
  for (const SessionRow& session : sessions) {
    if (session.experiment != Experiment::kArtifact || (wanted && session.kind != *wanted)) continue;
    if (session.complete) kinds.insert(session.kind);
    unfinished += session.complete ? 0 : 1;
  }
  if (kinds.empty()) {
    throw InputError(source, "",
                     wanted ? fmt::format("finished artifact sessions of the kind {}", format_kind(*wanted))
                            : "finished artifact sessions",
                     fmt::format("none ({} unfinished)", unfinished));
  }
  if (kinds.size() > 1) {
    std::vector<std::string> names;
    for (const SubjectKind kind : kinds) names.push_back(format_kind(kind));
    throw InputError(source, "", "finished artifact sessions of one kind, or --kind to choose",
                     fmt::format("those of {}", fmt::join(names, " and ")));
  }
  return *kinds.begin();
}

ExperimentEvidence gather_sessions(const std::vector<SessionRow>& sessions, SubjectKind kind,
                                   Experiment experiment, const Study& study, const std::string& source) {
  ExperimentEvidence evidence;
  for (const SessionRow& session : sessions) {
    if (session.kind != kind || session.experiment != experiment) continue;
    if (!session.complete) {
      ++evidence.unfinished;
      continue;
    }
    if (session.digests.study != study.digest) {
      throw InputError(source, fmt::format("session {}", session.id),
                       fmt::format("the study {}", study.digest), session.digests.study);
    }
    evidence.finished.push_back(session);
  }
  std::sort(evidence.finished.begin(), evidence.finished.end(),
            [](const auto& a, const auto& b) { return a.subject_index < b.subject_index; });
  return evidence;
}

}  // namespace equilux
