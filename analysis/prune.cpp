// Artifact cuts to a selection.
#include "analysis/prune.h"

#include <algorithm>

#include "base/error.h"

namespace equilux {

std::vector<int> keep_levels(const Threshold& artifact, const std::vector<int>& clamp_levels) {
  if (!artifact.cut) return {};
  const auto first = std::find(clamp_levels.begin(), clamp_levels.end(), *artifact.cut);
  EQ_CHECK(first != clamp_levels.end(), *artifact.cut);
  const std::vector<int> surviving(first, clamp_levels.end());
  std::vector<int> kept;
  for (std::size_t i = 0; i < surviving.size(); i += 2) kept.push_back(surviving[i]);
  if (kept.back() != surviving.back()) kept.push_back(surviving.back());
  return kept;
}

Selection make_selection(const Study& study, const Tally& artifact, SubjectKind kind, Rule rule,
                         const std::string& answers_digest) {
  Selection selection{kind, format_rule(rule), study.digest, answers_digest, {}};
  for (const Column& column : enumerate_columns(study)) {
    const Threshold threshold =
        find_threshold(counts_of(artifact, column, study), Experiment::kArtifact, rule);
    selection.columns.push_back(
        {column, format_status(threshold.status), threshold.cut, keep_levels(threshold, study.clamp_levels)});
  }
  return selection;
}

PruneOutcome decide_pruning(const Selection& fresh, const std::optional<Selection>& standing,
                            const std::vector<std::string>& used) {
  const std::string digest = digest_selection(fresh);
  const bool stands = standing && digest_selection(*standing) == digest;
  if (used.empty()) return stands ? PruneOutcome::kUnchanged : PruneOutcome::kWritten;
  if (std::find(used.begin(), used.end(), digest) == used.end())
    return standing ? PruneOutcome::kFrozenOther : PruneOutcome::kMissingOther;
  if (!standing) return PruneOutcome::kWritten;
  return stands ? PruneOutcome::kFrozenEqual : PruneOutcome::kFrozenOther;
}

std::string format_selection(const Selection& selection, const Study& study) {
  std::size_t width = 6;
  for (const SelectedColumn& column : selection.columns) {
    width = std::max(width, format_key(column.column).size());
  }
  std::string text = fmt::format("{:<{}}  {:<4}  {:<13}  {}\n", "column", width, "cut", "status", "goes on");
  for (const SelectedColumn& column : selection.columns) {
    std::vector<std::string> levels;
    for (int level : column.levels) levels.push_back(format_clamp(level));
    text += fmt::format("{:<{}}  {:<4}  {:<13}  {}\n", format_key(column.column), width,
                        column.artifact_cut ? format_clamp(*column.artifact_cut) : "-", column.status,
                        levels.empty() ? "dropped" : fmt::format("{}", fmt::join(levels, " ")));
  }
  return text + fmt::format("{} of {} conditions go on (rule {}, {} answers)\n",
                            enumerate_selected_cells(selection, study).size(), enumerate_cells(study).size(),
                            selection.rule, format_kind(selection.kind));
}

}  // namespace equilux
