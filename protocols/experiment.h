// The two experiments, and the kinds of subjects whose answers never mix.
#pragma once

#include <string>
#include <string_view>

namespace equilux {

enum class Experiment { kArtifact, kMaterial };

/// person; planted: simulated with thresholds put in; looking: simulated from the pixels.
enum class SubjectKind { kPerson, kPlanted, kLooking };

std::string format_experiment(Experiment experiment);
std::string format_kind(SubjectKind kind);

/// errors: InputError naming source and place.
Experiment parse_experiment(std::string_view text, std::string_view source, std::string_view place = "");
SubjectKind parse_kind(std::string_view text, std::string_view source, std::string_view place = "");

/// The question, word for word as subjects read it.
std::string prompt_of(Experiment experiment);

}  // namespace equilux
