// Planted subjects through whole sessions: the same door, state machine and log as for a person.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>

#include "experiment/trial_log.h"
#include "stimuli/study_folder.h"

namespace equilux {

struct SimulateParams {
  Experiment experiment = Experiment::kArtifact;
  int subjects = 0;
  std::uint64_t seed = 0;
  std::optional<std::filesystem::path> truth;  ///< empty: the folder's own
  /// Called after each answer's commit.
  std::function<void(std::int64_t session, int trial)> acknowledge = [](std::int64_t, int) {};
};

struct SimulateCounts {
  int kept = 0;     ///< were finished
  int resumed = 0;  ///< were interrupted, are now finished
  int added = 0;
};

/// Makes sure that `subjects` finished sessions of planted subjects of this experiment and seed exist:
/// finished ones are kept, interrupted ones resumed, missing ones added, each at the lowest free index.
/// errors: as open_session
SimulateCounts simulate_subjects(const StudyFolder& folder, const SimulateParams& params);

}  // namespace equilux
