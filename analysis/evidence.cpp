// Sessions sorted into those that count and those left out.
#include "analysis/evidence.h"

#include <algorithm>
#include <future>
#include <iterator>
#include <map>
#include <set>

#include "analysis/words.h"
#include "base/digest.h"
#include "base/error.h"

namespace equilux {
namespace {

template <typename T>
void append(std::vector<T>& all, std::vector<T>& more) {
  all.insert(all.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
  more = {};
}

// By far the most of what there is.
void append_answers(std::vector<Evidence>& parts, ExperimentEvidence Evidence::*experiment, Answers& all) {
  std::size_t count = 0;
  for (const Evidence& part : parts) count += (part.*experiment).answers.size();
  all.reserve(count);
  for (Evidence& part : parts) {
    all.append((part.*experiment).answers);
    (part.*experiment).answers = {};
  }
}

// Numbers of sessions in one log to numbers in the pool.
void renumber(ExperimentEvidence& part, std::map<std::int64_t, std::int64_t>& numbers, std::int64_t& next,
              const std::string& folder) {
  const auto number_of = [&](std::int64_t session) {
    const auto [entry, is_new] = numbers.try_emplace(session, next);
    next += is_new ? 1 : 0;
    return entry->second;
  };
  for (SessionRow& row : part.finished) row.id = number_of(row.id);
  for (SessionSummary& summary : part.summaries) {
    summary.session = number_of(summary.session);
    summary.folder = folder;
  }
  part.answers.renumber_sessions(number_of);
}

// Which log holds each session, by its uuid.
class Holders {
 public:
  // One that is copied, or merged into another, is in two: unfinished perhaps in a copy from before its end.
  void check_are_new(const ExperimentEvidence& part, const std::string& folder) {
    for (const SessionRow& row : part.finished) check_is_new(row.uuid, row.id, row.participant, folder);
    for (const SessionSummary& summary : part.summaries) {
      if (!summary.complete && !summary.uuid.empty())
        check_is_new(summary.uuid, summary.session, summary.participant, folder);
    }
  }

 private:
  void check_is_new(const std::string& uuid, std::int64_t session, const std::string& participant,
                    const std::string& folder) {
    const auto [entry, is_new] = folders_.try_emplace(uuid, folder);
    if (is_new) return;
    throw InputError(folder, fmt::format("session {} of {}", session, participant),
                     "each session in one log: leave a copy out, or a log that was merged",
                     "one that " + entry->second + " has too");
  }

  std::map<std::string, std::string> folders_;
};

// All but the answers.
void add_part(ExperimentEvidence& all, ExperimentEvidence& part) {
  append(all.finished, part.finished);
  append(all.summaries, part.summaries);
  all.unfinished += part.unfinished;
  all.unanswered += part.unanswered;
}

}  // namespace

std::optional<SubjectKind> find_kind(const std::vector<SessionRow>& sessions,
                                     std::optional<SubjectKind> wanted, const std::string& source) {
  std::set<SubjectKind> kinds;
  for (const SessionRow& session : sessions) {
    if (session.experiment != Experiment::kArtifact || (wanted && session.kind != *wanted)) continue;
    if (session.complete) kinds.insert(session.kind);
  }
  if (kinds.size() > 1) {
    std::vector<std::string> names;
    for (const SubjectKind kind : kinds) names.push_back(format_kind(kind));
    throw InputError(source, "", "finished artifact sessions of one kind, or --kind to choose",
                     fmt::format("those of {}", fmt::join(names, " and ")));
  }
  return kinds.empty() ? std::nullopt : std::optional(*kinds.begin());
}

SubjectKind choose_kind(const std::vector<SessionRow>& sessions, std::optional<SubjectKind> wanted,
                        const std::string& source) {
  if (const auto found = find_kind(sessions, wanted, source)) return *found;
  const auto unfinished = std::count_if(sessions.begin(), sessions.end(), [&](const SessionRow& session) {
    return session.experiment == Experiment::kArtifact && (!wanted || session.kind == *wanted);
  });
  const SessionTotals others = count_others(sessions, std::nullopt);
  throw InputError(source, "",
                   wanted ? fmt::format("finished artifact sessions of the kind {}", format_kind(*wanted))
                          : "finished artifact sessions",
                   fmt::format("none ({} unfinished{})", unfinished,
                               others.empty() ? "" : "; finished are " + describe_totals(others)));
}

SessionTotals count_others(const std::vector<SessionRow>& sessions, std::optional<SubjectKind> kind) {
  SessionTotals totals;
  for (const SessionRow& session : sessions) {
    if (session.complete && session.kind != kind) ++totals[{session.kind, session.experiment}];
  }
  return totals;
}

std::string describe_totals(const SessionTotals& totals) {
  std::vector<std::string> parts;
  for (const auto& [of, count] : totals)
    parts.push_back(fmt::format("{} of the kind {}",
                                format_count(count, format_experiment(of.second) + " session"),
                                format_kind(of.first)));
  return fmt::format("{}", fmt::join(parts, ", "));
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

Evidence pool_evidence(std::vector<Evidence> parts, const std::vector<std::string>& folders) {
  EQ_CHECK(!parts.empty() && parts.size() == folders.size(), parts.size(), folders.size());
  if (parts.size() == 1) return std::move(parts.front());
  Evidence all;
  all.kind = parts.front().kind;
  std::int64_t next = 1;
  std::multiset<std::string> artifact_digests, material_digests;
  Holders holders;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].kind != all.kind) {
      throw InputError(folders[i], "",
                       fmt::format("answers of the kind {}, as in {}", format_kind(all.kind), folders[0]),
                       format_kind(parts[i].kind));
    }
    holders.check_are_new(parts[i].artifact, folders[i]);
    holders.check_are_new(parts[i].material, folders[i]);
    std::map<std::int64_t, std::int64_t> numbers;
    renumber(parts[i].artifact, numbers, next, folders[i]);
    renumber(parts[i].material, numbers, next, folders[i]);
    artifact_digests.insert(parts[i].artifact.digest);
    material_digests.insert(parts[i].material.digest);
    add_part(all.artifact, parts[i].artifact);
    add_part(all.material, parts[i].material);
    all.withdrawn += parts[i].withdrawn;
    for (const auto& [of, count] : parts[i].others) all.others[of] += count;
  }
  auto beside = std::async(std::launch::async,
                           [&] { append_answers(parts, &Evidence::material, all.material.answers); });
  append_answers(parts, &Evidence::artifact, all.artifact.answers);
  beside.get();
  all.artifact.digest = digest_text(fmt::format("{}", fmt::join(artifact_digests, "\n")));
  all.material.digest = digest_text(fmt::format("{}", fmt::join(material_digests, "\n")));
  return all;
}

std::int64_t count_ended_early(const ExperimentEvidence& evidence) {
  return std::count_if(
      evidence.summaries.begin(), evidence.summaries.end(),
      [](const SessionSummary& summary) { return !summary.complete && summary.abort_reason.has_value(); });
}

Answers select_answers(const ExperimentEvidence& evidence, const std::vector<std::int64_t>& sessions) {
  Answers selected;
  for (const Cell& cell : evidence.answers.cells()) selected.number_of(cell);
  std::optional<std::int64_t> session;
  bool is_selected = false;
  for (const CountedAnswer& answer : evidence.answers.rows()) {
    if (session != answer.session) {
      session = answer.session;
      is_selected = std::binary_search(sessions.begin(), sessions.end(), *session);
    }
    if (is_selected) selected.push_back(answer);
  }
  return selected;
}

}  // namespace equilux
