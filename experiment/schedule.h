// The order, sides and views in which a subject sees the cells, balanced by the rules of the study.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "experiment/trial_log.h"
#include "protocols/windows.h"
#include "stimuli/selection.h"

namespace equilux {

/// The cells of the artifact experiment: kWindowLevels in each column.
std::vector<Cell> enumerate_artifact_cells(const Study& study, const Windows& windows);

/// Trials of subject `index`, a function of (study seed, experiment, kind, session seed, index) alone.
/// Balance: view x side jointly, counts differing by at most one within a session, and for each cell over
/// subjects 0, 1, ... Reference materials of artifact trials: evenly over subjects for each cell.
std::vector<TrialRow> make_schedule(const Study& study, Experiment experiment, const std::vector<Cell>& cells,
                                    SubjectKind kind, std::uint64_t session_seed, std::int64_t index);

/// One trial of a cell. `combo`: side of the test picture (low bit: right) and its view (high bit).
/// `material`: of the reference beside it, in artifact trials.
TrialRow make_trial(const Study& study, Experiment experiment, const Cell& cell, unsigned combo,
                    const std::string& material);

/// Every picture that the trials show, each once, sorted.
std::vector<std::string> enumerate_shown(const std::vector<TrialRow>& trials);

/// Every picture that these cells may show to any subject, each once, sorted: what a session depends on.
std::vector<std::string> enumerate_showable(const Study& study, Experiment experiment,
                                            const std::vector<Cell>& cells);

}  // namespace equilux
