// Reports on planted answers, for the tests of this folder.
#pragma once

#include <map>
#include <string>

#include "analysis/report.h"
#include "tests/analysis/columns.h"

namespace equilux::tests {

inline ExperimentEvidence make_evidence(const PlantedStudy& planted, Experiment experiment, SubjectKind kind,
                                        int subjects) {
  ExperimentEvidence evidence;
  evidence.answers = experiment == Experiment::kArtifact ? planted.artifact : planted.material;
  evidence.unfinished = 1;
  evidence.digest = std::string(64, 'a');
  for (int i = 0; i < subjects; ++i) {
    SessionRow row;
    row.id = i + 1;
    row.kind = kind;
    row.experiment = experiment;
    row.subject_index = i;
    row.seed = 7;
    row.program_version = "0.1.0";
    row.digests.study = planted.study.digest;
    row.digests.manifest = std::string(64, 'b');
    if (experiment == Experiment::kMaterial) row.digests.selection = digest_selection(planted.selection);
    row.complete = true;
    evidence.finished.push_back(row);
  }
  return evidence;
}

inline Report make_planted_report(const PlantedStudy& planted, SubjectKind kind = SubjectKind::kPlanted,
                                  Rule rule = Rule::kPaper) {
  const Evidence evidence{kind, make_evidence(planted, Experiment::kArtifact, kind, 12),
                          make_evidence(planted, Experiment::kMaterial, kind, 14)};
  return make_report(planted.study, evidence, rule, {planted.selection, std::nullopt, std::nullopt});
}

inline bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

// The first column of the pocket study alone: 12 and 14 subjects, of whom the first k were right.
inline PlantedStudy answer_column(const std::map<int, int>& artifact, const std::map<int, int>& material) {
  PlantedStudy planted = make_planted_study("pocket", 12, 14, 1, 0.02);
  const Column column = enumerate_columns(planted.study).front();
  const auto answer = [&](std::vector<AnswerRow>& answers, const std::map<int, int>& cells, int subjects) {
    answers.clear();
    for (int subject = 0; subject < subjects; ++subject) {
      for (const auto& [level, k] : cells)
        answers.push_back({subject + 1, subject, Cell{column, level, false}, subject < k});
    }
  };
  answer(planted.artifact, artifact, 12);
  answer(planted.material, material, 14);
  return planted;
}

}  // namespace equilux::tests
