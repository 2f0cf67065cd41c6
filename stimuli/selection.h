// selection-<kind>.json: what pruning leaves of the clamp levels for the material experiment.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/json.h"
#include "protocols/experiment.h"
#include "protocols/study.h"

namespace equilux {

struct SelectedColumn {
  Column column;
  std::string status;               ///< cut, censored_low, censored_high, none, untested
  std::optional<int> artifact_cut;  ///< least clamped level from which on the column is artifact-free
  std::vector<int> levels;  ///< levels that the material experiment tests; empty: the column is dropped
};

struct Selection {
  SubjectKind kind = SubjectKind::kPerson;
  std::string rule;  ///< paper or isotonic
  std::string study_digest;
  std::string answers_digest;  ///< of that kind's finished artifact answers, canonical
  std::vector<SelectedColumn> columns;
};

/// What a session records of a selection: everything but the producer's version.
std::string digest_selection(const Selection& selection);

/// errors: InputError, also for a column or level that the study does not have.
Selection load_selection(const std::filesystem::path& path, const Study& study);

/// errors: StoreError
void save_selection(const Selection& selection, const std::filesystem::path& path);

/// The cells that are left, in the order of the selection.
std::vector<Cell> enumerate_selected_cells(const Selection& selection, const Study& study);

}  // namespace equilux
