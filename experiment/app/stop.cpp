// Whom to call, why, and what to do then.
#include "experiment/app/stop.h"

#include <algorithm>
#include <fmt/format.h>

#include "base/error.h"
#include "experiment/app/intake_window.h"

namespace equilux {
namespace {

std::string describe_time_limit(const SessionInputs& inputs) {
  const SessionProtocol& protocol = inputs.protocol;
  if (inputs.kind != SubjectKind::kPerson || !protocol.resume_within_hours) return {};
  return fmt::format(" within {} hours of its last answer", *protocol.resume_within_hours);
}

}  // namespace

std::string describe_cause(const std::string& message, const Manifest& manifest) {
  const bool names_picture =
      std::any_of(manifest.pictures.begin(), manifest.pictures.end(),
                  [&](const auto& picture) { return message.find(picture.first) != std::string::npos; });
  return names_picture ? "A picture cannot be shown. Which one, and why, the terminal says." : message;
}

std::string describe_stop(const SessionInputs& inputs, StopState state) {
  if (state == StopState::kNotBegun)
    return "No session was begun now, and nothing was recorded. Remove the cause, then start again.";
  if (state == StopState::kComplete) return "The session is complete, and all of it is recorded.";
  const std::string safe = "What was recorded until now is safe. ";
  if (inputs.kind == SubjectKind::kPerson && !inputs.protocol.may_resume)
    return safe +
           "The protocol lets nobody go on with a session that was interrupted: this one stays as it is.";
  return safe + fmt::format(
                    "Remove the cause, then start the same experiment with the same participant code{}: it "
                    "goes on at the first question without a recorded answer.",
                    describe_time_limit(inputs));
}

StopState find_stop_state(const Seat& seat) {
  try {
    for (const SessionRow& row : seat.log.load_sessions()) {
      if (row.id == seat.open.row.id && row.complete) return StopState::kComplete;
    }
  } catch (const std::exception&) {
  }
  return StopState::kUnfinished;
}

// Where the log is what failed, the session is known as interrupted by having no end.
void record_stop(Seat& seat, const std::string& message) {
  if (find_stop_state(seat) == StopState::kComplete) return;
  try {
    if (find_abort_reason(seat.log.load_events(seat.open.row.id))) return;
    record_effect(seat.log, seat.open.row.id, RecordNote{"interrupt", message, read_clock_ns()});
    seat.log.empty_wal();
  } catch (const std::exception&) {
  }
}

void show_stop(AppWindow& window, Gui& gui, const Workplace& work, StopState state,
               const std::string& message) {
  const Texts& texts = work.texts;
  show_message(
      window, gui,
      {texts.at("stopped_title"),
       {texts.at("stopped_call"), describe_cause(message, work.manifest), describe_stop(work.inputs, state)},
       texts.at("close"),
       texts.at("more_below")});
}

}  // namespace equilux
