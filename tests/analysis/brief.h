// Scheduled trials as a log gives them to the analysis.
#pragma once

#include <vector>

#include "experiment/trial_log.h"

namespace equilux::tests {

/// All but their cells, which no summary looks at.
inline std::vector<BriefTrial> make_brief(const std::vector<TrialRow>& trials) {
  std::vector<BriefTrial> brief;
  for (const TrialRow& trial : trials) {
    BriefTrial& row = brief.emplace_back();
    row.number = trial.number;
    row.phase = trial.phase;
    if (trial.test_key.ends_with("-v0")) row.view = 0;
    if (trial.test_key.ends_with("-v1")) row.view = 1;
    row.test_side = trial.test_side;
    row.answer = trial.answer;
    row.response_time_ns = trial.response_time_ns.value_or(1);
    row.too_fast = trial.too_fast;
  }
  return brief;
}

}  // namespace equilux::tests
