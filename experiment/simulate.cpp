// A loop in place of the window: it shows nothing, and its clock is the sum of what the subjects took.
#include "experiment/simulate.h"

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "base/progress.h"
#include "experiment/open_session.h"
#include "experiment/planted.h"

namespace equilux {
namespace {

constexpr std::int64_t kFrameNs = 16'666'667;  // from an effect to its onset on a screen of 60 Hz

// Existing sessions of this seed in order of index: finished ones to keep, interrupted ones to resume.
std::vector<SessionRow> find_earlier_sessions(const TrialLog& log, const SimulateParams& params) {
  std::vector<SessionRow> earlier;
  for (SessionRow& row : log.load_sessions()) {
    if (row.kind == SubjectKind::kPlanted && row.experiment == params.experiment && row.seed == params.seed) {
      earlier.push_back(std::move(row));
    }
  }
  std::sort(earlier.begin(), earlier.end(),
            [](const auto& a, const auto& b) { return a.subject_index < b.subject_index; });
  earlier.resize(std::min(earlier.size(), static_cast<std::size_t>(params.subjects)));
  return earlier;
}

// One planted subject in front of a session.
class Sitting {
 public:
  Sitting(TrialLog& log, OpenSession open, const Truth& truth, const SimulateParams& params)
      : log_(log), open_(std::move(open)), truth_(truth), params_(params) {
    subject_ = {open_.row.seed, open_.row.experiment, open_.row.subject_index};
  }

  void run() {
    while (!is_over(open_.session)) {
      if (open_.session.screen == Screen::kTrial) {
        answer_trial();
      } else {
        carry_out(advance(open_.session, ContinueEvent{clock_ns_}));  // no time passes on a page
      }
    }
    EQ_CHECK(open_.session.screen == Screen::kThanks);
  }

 private:
  void answer_trial() {
    const TrialRow& trial = open_.session.trials[static_cast<std::size_t>(open_.session.current)];
    const Side side = choose_planted_side(truth_, subject_, trial);
    const int number = trial.number;
    clock_ns_ += kFrameNs;
    carry_out(advance(open_.session, ShownEvent{number, clock_ns_}));
    clock_ns_ += draw_planted_response_time_ns(subject_, number);
    carry_out(advance(open_.session, AnswerEvent{side, clock_ns_}));
  }

  void carry_out(const std::vector<SessionEffect>& effects) {
    for (const SessionEffect& effect : effects) {
      record_effect(log_, open_.row.id, effect);
      if (const auto* recorded = std::get_if<RecordAnswer>(&effect)) {
        params_.acknowledge(open_.row.id, recorded->answer.trial);
      }
    }
  }

  TrialLog& log_;
  OpenSession open_;
  const Truth& truth_;
  const SimulateParams& params_;
  PlantedSubject subject_;
  std::int64_t clock_ns_ = 0;
};

}  // namespace

SimulateCounts simulate_subjects(const StudyFolder& folder, const SimulateParams& params) {
  const Study study = load_folder_study(folder);
  const Truth truth = load_truth(params.truth.value_or(folder.truth()), study);
  std::optional<TrialLog> found = find_log(folder);
  SessionRequest request{params.experiment, SubjectKind::kPlanted, "", params.seed, params.truth, {}};
  const SessionInputs inputs = load_session_inputs(folder, found ? &*found : nullptr, request);
  TrialLog log = found ? std::move(*found) : make_log(inputs);
  Progress progress(fmt::format("simulate {}", format_experiment(params.experiment)), params.subjects);
  SimulateCounts counts;
  const auto seat = [&](const std::string& participant) {
    request.participant = participant;
    Sitting(log, open_session(inputs, log, request), truth, params).run();
  };
  for (const SessionRow& row : find_earlier_sessions(log, params)) {
    if (!row.complete) seat(row.participant);
    ++(row.complete ? counts.kept : counts.resumed);
    progress.advance(1);
  }
  while (counts.kept + counts.resumed + counts.added < params.subjects) {
    const std::int64_t index = log.find_free_index(SubjectKind::kPlanted, params.experiment);
    seat(name_next_planted(log, params.seed, index));
    ++counts.added;
    progress.advance(1);
  }
  return counts;
}

}  // namespace equilux
