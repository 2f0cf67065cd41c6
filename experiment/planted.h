// A planted subject: sees what a truth says is visible, and takes the seat of a person.
#pragma once

#include <cstdint>

#include "experiment/trial_log.h"
#include "protocols/truth.h"

namespace equilux {

/// Whose draws they are: the answers of a planted subject depend on these and the trial's number alone.
struct PlantedSubject {
  std::uint64_t seed = 0;
  Experiment experiment = Experiment::kArtifact;
  std::int64_t index = 0;
};

/// An artifact is visible iff the level is less clamped than `artifact_free_from`, a change of material iff
/// it is more clamped than `material_same_to`.
bool is_visible(const Truth& truth, Experiment experiment, const Cell& cell);

/// Visible and no lapse: the side of the test picture. Else left with probability `side_bias`.
Side choose_planted_side(const Truth& truth, const PlantedSubject& subject, const TrialRow& trial);

/// Log-normal with median 1.5 s and a spread of a factor 1.5 either way, between 0.2 s and 30 s: invented,
/// and nothing is concluded from it. units: ns
std::int64_t draw_planted_response_time_ns(const PlantedSubject& subject, int trial);

/// The participant code of a planted subject: planted-SEED-INDEX.
std::string name_planted(std::uint64_t seed, std::int64_t index);

/// The same for a new session in this log. The code of one that withdrew is refused for ever, though its
/// index is free again: the next subject there is planted-SEED-INDEX-2, then -3, and so on; it answers as the
/// first did.
std::string name_next_planted(const TrialLog& log, std::uint64_t seed, std::int64_t index);

}  // namespace equilux
