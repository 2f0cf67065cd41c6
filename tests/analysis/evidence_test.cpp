// Whose answers count, and how many sessions are left out.
#include "analysis/evidence.h"

#include <gtest/gtest.h>

#include "base/error.h"
#include "tests/analysis/columns.h"

namespace equilux::tests {
namespace {

SessionRow make_session_row(SubjectKind kind, Experiment experiment, bool complete, const Study& study) {
  SessionRow row;
  row.kind = kind;
  row.experiment = experiment;
  row.complete = complete;
  row.digests.study = study.digest;
  return row;
}

class EvidenceTest : public testing::Test {
 protected:
  void add(SubjectKind kind, Experiment experiment, bool complete) {
    sessions.push_back(make_session_row(kind, experiment, complete, study));
    sessions.back().id = static_cast<std::int64_t>(sessions.size());
    sessions.back().subject_index = 100 - sessions.back().id;
  }
  std::string message(std::optional<SubjectKind> wanted) const {
    try {
      choose_kind(sessions, wanted, "responses.sqlite");
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  const Study study = load_protocol("pocket");
  std::vector<SessionRow> sessions;
};

TEST_F(EvidenceTest, the_only_kind_with_finished_artifact_sessions_is_chosen) {
  add(SubjectKind::kPerson, Experiment::kArtifact, false);
  add(SubjectKind::kPlanted, Experiment::kArtifact, true);
  add(SubjectKind::kPerson, Experiment::kMaterial, true);
  EXPECT_EQ(choose_kind(sessions, std::nullopt, "log"), SubjectKind::kPlanted);
}

TEST_F(EvidenceTest, several_kinds_need_a_choice) {
  add(SubjectKind::kPerson, Experiment::kArtifact, true);
  add(SubjectKind::kPlanted, Experiment::kArtifact, true);
  EXPECT_EQ(
      message(std::nullopt),
      "responses.sqlite: expected finished artifact sessions of one kind, or --kind to choose, got those of "
      "person and planted");
  EXPECT_EQ(choose_kind(sessions, SubjectKind::kPerson, "log"), SubjectKind::kPerson);
}

TEST_F(EvidenceTest, without_finished_sessions_the_error_says_how_many_are_unfinished) {
  add(SubjectKind::kPerson, Experiment::kArtifact, false);
  EXPECT_EQ(message(std::nullopt),
            "responses.sqlite: expected finished artifact sessions, got none (1 unfinished)");
  EXPECT_EQ(
      message(SubjectKind::kPlanted),
      "responses.sqlite: expected finished artifact sessions of the kind planted, got none (0 unfinished)");
}

TEST_F(EvidenceTest, a_log_of_material_sessions_alone_is_refused_by_name) {
  for (int i = 0; i < 3; ++i) add(SubjectKind::kPerson, Experiment::kMaterial, true);
  add(SubjectKind::kPerson, Experiment::kMaterial, false);
  EXPECT_EQ(message(std::nullopt),
            "responses.sqlite: expected finished artifact sessions, got none (0 unfinished; finished are 3 "
            "material sessions of the kind person)");
}

TEST_F(EvidenceTest, finished_sessions_of_other_kinds_are_counted_apart) {
  add(SubjectKind::kPlanted, Experiment::kArtifact, true);
  add(SubjectKind::kPerson, Experiment::kMaterial, true);
  add(SubjectKind::kPerson, Experiment::kMaterial, true);
  add(SubjectKind::kLooking, Experiment::kArtifact, false);
  EXPECT_EQ(describe_totals(count_others(sessions, SubjectKind::kPlanted)),
            "2 material sessions of the kind person");
  EXPECT_TRUE(count_others({sessions.front()}, SubjectKind::kPlanted).empty());
}

TEST_F(EvidenceTest, only_finished_sessions_of_the_kind_and_experiment_count) {
  add(SubjectKind::kPlanted, Experiment::kArtifact, true);
  add(SubjectKind::kPlanted, Experiment::kArtifact, false);
  add(SubjectKind::kPlanted, Experiment::kArtifact, true);
  add(SubjectKind::kPerson, Experiment::kArtifact, true);
  add(SubjectKind::kPlanted, Experiment::kMaterial, false);
  const auto evidence = gather_sessions(sessions, SubjectKind::kPlanted, Experiment::kArtifact, study, "log");
  ASSERT_EQ(evidence.finished.size(), 2U);
  EXPECT_EQ(evidence.unfinished, 1);
  EXPECT_LT(evidence.finished[0].subject_index, evidence.finished[1].subject_index);
}

TEST_F(EvidenceTest, a_session_of_another_study_is_refused) {
  add(SubjectKind::kPerson, Experiment::kArtifact, true);
  sessions.back().digests.study = std::string(64, '0');
  EXPECT_THROW(gather_sessions(sessions, SubjectKind::kPerson, Experiment::kArtifact, study, "log"),
               InputError);
}

}  // namespace
}  // namespace equilux::tests
