// All that a session needs before its first screen, opened and checked.
#pragma once

#include <string>
#include <vector>

#include "experiment/app/app.h"
#include "experiment/app/layout.h"
#include "experiment/app/window.h"
#include "experiment/open_session.h"
#include "stimuli/manifest.h"

namespace equilux {

struct Workplace {
  StudyFolder folder;
  Study study;
  Manifest manifest;
  TrialLog log;
  OpenSession open;
  Layout layout;
  std::vector<std::string> remarks;  ///< for the experimenter
};

/// True if nothing is left to ask for.
bool is_complete(const AppParams& params);

/// The window in which the pictures of this folder have room. errors: InputError, before a window opens, for
/// a screen that is too small.
Size choose_window_size(const AppParams& params, const Display& display);

/// Opens study, log and session; makes a plain window the size of the study's layout. errors: InputError,
/// StoreError
Workplace open_workplace(const AppParams& params, const Display& display, AppWindow& window);

}  // namespace equilux
