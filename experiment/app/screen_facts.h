// Asking the window system and the graphics card about a screen.
#pragma once

#include "experiment/app/setup.h"
#include "experiment/app/window.h"

namespace equilux {

/// Shows some forty frames of plain grey to measure the refresh rate.
ScreenFacts read_screen_facts(const Display& display, AppWindow& window);

}  // namespace equilux
