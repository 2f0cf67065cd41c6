// Rows for logs and sessions that need no study.
#pragma once

#include <string>
#include <vector>

#include "experiment/trial_log.h"

namespace equilux {

/// Trials of one column, levels in turn, test pictures left and right in turn.
inline std::vector<TrialRow> make_fake_trials(int count) {
  std::vector<TrialRow> trials;
  for (int i = 0; i < count; ++i) {
    TrialRow trial;
    trial.number = i;
    trial.cell = {{{"G1", "MR", Illumination::kIndirect}, 100000}, i % kClampLevelCount, false};
    trial.test_key = format_key(Condition{trial.cell, i % kViewCount});
    trial.pair_key = "G1-MS-ind-ref-v1";
    trial.test_side = i % 2 == 0 ? Side::kLeft : Side::kRight;
    trials.push_back(trial);
  }
  return trials;
}

inline SessionRow make_fake_session(std::int64_t index = 0, SubjectKind kind = SubjectKind::kPerson,
                                    Experiment experiment = Experiment::kArtifact) {
  SessionRow row;
  row.participant = "P" + std::to_string(index);
  row.kind = kind;
  row.experiment = experiment;
  row.subject_index = index;
  row.seed = 42 + static_cast<std::uint64_t>(index);
  row.program_version = "0.1.0";
  row.digests = {"study", "manifest", "windows", "", "", ""};
  row.started_utc = "2026-01-31T12:00:00.000Z";
  return row;
}

/// Answers all trials of a session, each with its test picture's side where `correct`, and finishes it.
inline void answer_all(TrialLog& log, std::int64_t session, int count, bool correct = true) {
  for (const TrialRow& trial : log.load_trials(session)) {
    const bool left = (trial.test_side == Side::kLeft) == correct;
    const auto next = trial.number + 1 < count ? std::optional(trial.number + 1) : std::nullopt;
    log.append_answer(session, {trial.number, left ? Side::kLeft : Side::kRight, 1000}, next, 5000);
  }
  log.finish_session(session, 9000);
}

}  // namespace equilux
