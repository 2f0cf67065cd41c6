// Pages before a session: the experimenter's set-up, consent, questions.
#pragma once

#include "experiment/app/gui.h"
#include "experiment/app/screens.h"
#include "experiment/app/workplace.h"
#include "experiment/intake.h"

namespace equilux {

/// Lets the experimenter choose the monitor, and tell the size of the screen and the distance. False if the
/// window was closed.
bool ask_setup(AppWindow& window, Gui& gui, Workplace& work, Display& display);

/// Consent and questions; the step it ends with is kDone or kDeclined, or an earlier one if the window was
/// closed.
Intake ask_intake(AppWindow& window, Gui& gui, const Workplace& work);

/// A page with one button; until it is left.
void show_message(AppWindow& window, Gui& gui, const MessageText& text);

/// What is queued from before a page presses nothing on it: `guard` alone is told of it, then opened.
void open_guard(AppWindow& window, Gui& gui, PageGuard& guard, std::int64_t guard_ns = kPageGuardNs,
                bool needs_quiet = false);

}  // namespace equilux
