// The study's only loop, unrolled in time: which clamp levels go on to the material experiment.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/thresholds.h"
#include "stimuli/selection.h"

namespace equilux {

/// Levels on the clamped side of the artifact cut, thinned: the first, every second, and always the last.
/// Empty where there is no cut: the column is dropped.
std::vector<int> keep_levels(const Threshold& artifact, const std::vector<int>& clamp_levels);

/// What pruning leaves of the study. `answers_digest` names the artifact answers behind the tally.
Selection make_selection(const Study& study, const Tally& artifact, SubjectKind kind, Rule rule,
                         const std::string& answers_digest);

/// What pruning did to selection-<kind>.json.
enum class PruneOutcome {
  kWritten,      ///< made, or made anew
  kUnchanged,    ///< it stands there already, equal
  kFrozenEqual,  ///< a session has used it, and pruning again would give the same
  kFrozenOther,  ///< a session has used it, and pruning again would give another: nothing is written
  kMissingOther  ///< the same of one that is not there
};

/// `used`: digests of the selections that material sessions of the kind were made from.
PruneOutcome decide_pruning(const Selection& fresh, const std::optional<Selection>& standing,
                            const std::vector<std::string>& used);

/// A line for each column (cut, status, levels kept) and the number of conditions that go on.
std::string format_selection(const Selection& selection, const Study& study);

}  // namespace equilux
