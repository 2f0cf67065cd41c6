// A session that an error ends: what is said of it, and kept.
#pragma once

#include <map>
#include <string>

#include "experiment/app/gui.h"
#include "experiment/app/workplace.h"

namespace equilux {

/// What went wrong, for a screen that a subject sees: a message that names a picture says which one it is on
/// standard error alone.
std::string describe_cause(const std::string& message, const Manifest& manifest);

/// How far a session came that an error ends.
enum class StopState { kNotBegun, kUnfinished, kComplete };

/// What is recorded, and how it goes on: by the protocol, which binds persons alone.
std::string describe_stop(const SessionInputs& inputs, StopState state);

/// By the log, since what was last done may not have been written; a log that cannot be read tells of no end.
StopState find_stop_state(const Seat& seat);

/// Keeps the event `interrupt` with its reason, where the session has no end and the log can still be
/// written.
void record_stop(Seat& seat, const std::string& message);

/// A page that says so; until it is left.
void show_stop(AppWindow& window, Gui& gui, const Workplace& work, StopState state,
               const std::string& message);

}  // namespace equilux
