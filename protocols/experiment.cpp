// Names and prompts of the experiments.
#include "protocols/experiment.h"

#include "base/error.h"

namespace equilux {

std::string format_experiment(Experiment experiment) {
  return experiment == Experiment::kArtifact ? "artifact" : "material";
}

std::string format_kind(SubjectKind kind) {
  switch (kind) {
    case SubjectKind::kPerson:
      return "person";
    case SubjectKind::kPlanted:
      return "planted";
    case SubjectKind::kLooking:
      break;
  }
  return "looking";
}

Experiment parse_experiment(std::string_view text, std::string_view source, std::string_view place) {
  if (text == "artifact") return Experiment::kArtifact;
  if (text == "material") return Experiment::kMaterial;
  throw InputError(source, place, "artifact or material", fmt::format("\"{}\"", text.substr(0, 80)));
}

SubjectKind parse_kind(std::string_view text, std::string_view source, std::string_view place) {
  for (const auto kind : {SubjectKind::kPerson, SubjectKind::kPlanted, SubjectKind::kLooking}) {
    if (text == format_kind(kind)) return kind;
  }
  throw InputError(source, place, "person, planted or looking", fmt::format("\"{}\"", text.substr(0, 80)));
}

std::string prompt_of(Experiment experiment) {
  return experiment == Experiment::kArtifact ? "Select the image that has the artifacts."
                                             : "Which object's material is different from the reference?";
}

}  // namespace equilux
