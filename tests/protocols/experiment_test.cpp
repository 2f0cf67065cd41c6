// Names of experiments and subjects, and the questions word for word.
#include "protocols/experiment.h"

#include <gtest/gtest.h>

#include "base/error.h"

namespace equilux {
namespace {

TEST(Prompts, AreWordForWordThoseOfThePaper) {
  EXPECT_EQ(prompt_of(Experiment::kArtifact), "Select the image that has the artifacts.");
  EXPECT_EQ(prompt_of(Experiment::kMaterial), "Which object's material is different from the reference?");
}

TEST(ExperimentNames, RoundTripAndOthersAreRefused) {
  for (const auto experiment : {Experiment::kArtifact, Experiment::kMaterial})
    EXPECT_EQ(parse_experiment(format_experiment(experiment), "test"), experiment);
  for (const char* text : {"", "Artifact", "artifact ", "artefact"})
    EXPECT_THROW(parse_experiment(text, "test"), InputError) << text;
}

TEST(SubjectKinds, RoundTripAndOthersAreRefused) {
  for (const auto kind : {SubjectKind::kPerson, SubjectKind::kPlanted, SubjectKind::kLooking})
    EXPECT_EQ(parse_kind(format_kind(kind), "test"), kind);
  for (const char* text : {"", "Person", "simulated", "person\n"})
    EXPECT_THROW(parse_kind(text, "test"), InputError) << text;
}

}  // namespace
}  // namespace equilux
