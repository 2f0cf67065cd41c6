// Two thresholds to one verdict.
#include "analysis/equivalence.h"

#include <algorithm>

#include "analysis/probability.h"
#include "analysis/prune.h"

namespace equilux {
namespace {

Region region_of(LevelState artifact, LevelState material) {
  const bool changed = material == LevelState::kDifferent;
  if (artifact == LevelState::kDifferent) return changed ? Region::kBoth : Region::kArtifact;
  if (changed) return Region::kChanged;
  const bool same = artifact == LevelState::kSame && material == LevelState::kSame;
  return same ? Region::kEquivalent : Region::kUntested;
}

// A column without an artifact-free level has nothing to show in the material experiment. One that was
// dropped by another rule or another cut has, and nobody was asked: that is not known to be none.
Verdict verdict_of(const RuleFinding& finding) {
  if (!finding.green.empty()) return Verdict::kExists;
  if (finding.artifact.status == CutStatus::kUntested) return Verdict::kUntested;
  const bool has_candidates = finding.artifact.status != CutStatus::kNone;
  return has_candidates && finding.material.status == CutStatus::kUntested ? Verdict::kUntested
                                                                           : Verdict::kNone;
}

RuleFinding judge(const ColumnFinding& column, const Study& study, Rule rule, bool has_material,
                  int percent) {
  RuleFinding finding;
  finding.artifact = find_threshold(column.artifact, Experiment::kArtifact, rule, percent);
  finding.material = find_threshold(column.material, Experiment::kMaterial, rule, percent);
  const auto kept = keep_levels(finding.artifact, study.clamp_levels);
  for (std::size_t i = 0; i < study.clamp_levels.size(); ++i) {
    const int level = study.clamp_levels[i];
    const Count& material = column.material[i].count;
    finding.regions.push_back(region_of(finding.artifact.states[i], finding.material.states[i]));
    const bool is_kept = std::find(kept.begin(), kept.end(), level) != kept.end();
    if (has_material && is_kept && material.n == 0) finding.untested.push_back(level);
    if (finding.regions.back() != Region::kEquivalent) continue;
    finding.green.push_back(level);
    if (is_supported(column.artifact[i].count, percent) && is_supported(material, percent))
      finding.supported.push_back(level);
  }
  finding.verdict = verdict_of(finding);
  return finding;
}

bool is_dropped(const Selection* selection, const Column& column) {
  if (!selection) return false;
  const auto found = std::find_if(selection->columns.begin(), selection->columns.end(),
                                  [&](const SelectedColumn& row) { return row.column == column; });
  return found != selection->columns.end() && found->levels.empty();
}

}  // namespace

std::vector<ColumnFinding> find_equivalence(const Study& study, const Tally& artifact, const Tally& material,
                                            const Selection* selection, int percent) {
  const bool has_material = count_answers(material) > 0;
  std::vector<ColumnFinding> findings;
  for (const Column& column : enumerate_columns(study)) {
    ColumnFinding finding;
    finding.column = column;
    finding.artifact = counts_of(artifact, column, study);
    finding.material = counts_of(material, column, study);
    finding.dropped = is_dropped(selection, column);
    for (const Rule rule : kRules) {
      finding.by_rule[static_cast<std::size_t>(rule)] = judge(finding, study, rule, has_material, percent);
    }
    findings.push_back(std::move(finding));
  }
  return findings;
}

bool is_observed(const ColumnFinding& column, Region region, std::size_t i) {
  if (region == Region::kUntested) return true;
  return column.artifact[i].count.n > 0 && (region == Region::kArtifact || column.material[i].count.n > 0);
}

std::string format_region(Region region) {
  switch (region) {
    case Region::kArtifact:
      return "artifacts";
    case Region::kChanged:
      return "material changed";
    case Region::kBoth:
      return "artifacts, material changed";
    case Region::kEquivalent:
      return "equivalent";
    case Region::kUntested:
      break;
  }
  return "not tested";
}

}  // namespace equilux
