// The log's sessions as a table of text.
#include "experiment/status.h"

#include <algorithm>
#include <fmt/format.h>

#include "experiment/trial_log.h"

namespace equilux {

std::string format_status(const StudyFolder& folder) {
  load_folder_study(folder);
  if (!std::filesystem::exists(folder.responses())) return "No sessions yet.\n";
  const TrialLog log(folder.responses());
  const auto sessions = log.load_sessions();
  if (sessions.empty()) return "No sessions yet.\n";
  std::string text = fmt::format("{:>7}  {:8}{:11}{:>5}  {:20}{:10}{:>9}  {}\n", "session", "kind",
                                 "experiment", "index", "participant", "complete", "answered", "started");
  for (const SessionRow& row : sessions) {
    const auto trials = log.load_trials(row.id);
    const auto answered = std::count_if(trials.begin(), trials.end(),
                                        [](const auto& trial) { return trial.answer.has_value(); });
    text += fmt::format("{:7}  {:8}{:11}{:5}  {:20}{:10}{:>9}  {}\n", row.id, format_kind(row.kind),
                        format_experiment(row.experiment), row.subject_index, row.participant,
                        row.complete ? "yes" : "no", fmt::format("{}/{}", answered, trials.size()),
                        row.started_utc);
  }
  return text;
}

}  // namespace equilux
