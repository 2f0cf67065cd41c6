// All that a session needs before its first screen, opened and checked.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiment/app/app.h"
#include "experiment/app/layout.h"
#include "experiment/app/setup.h"
#include "experiment/app/window.h"
#include "experiment/clock_lag.h"
#include "experiment/open_session.h"
#include "experiment/texts.h"
#include "stimuli/manifest.h"

namespace equilux {

struct Workplace {
  SessionInputs inputs;
  Manifest manifest;
  Texts texts;
  SessionRequest request;
  Layout layout;
  ScreenFacts facts;
  SetupInput setup_input;
  ViewingSetup setup;
  std::optional<TrialLog> log;             ///< empty where no session has begun
  bool is_set_up = false;                  ///< the experimenter has seen the set-up screen and its remarks
  bool goes_on = false;                    ///< the participant has a session that was interrupted
  std::string goes_on_with = {};           ///< which one, in words for the experimenter; empty where none
  std::optional<ClockLag> clock_lag = {};  ///< of the log

  const StudyFolder& folder() const { return inputs.folder; }
};

/// A session that has begun.
struct Seat {
  TrialLog log;
  OpenSession open;
  std::map<std::string, int> notes = {};  ///< events of all its sittings but showings and answers, by kind
  std::vector<std::int64_t> latencies_ns =
      {};  ///< from an answer to the onset of the next pair, in this sitting
};

/// True if nothing is left to ask for.
bool is_complete(const AppParams& params);

/// The window in which the pictures of this folder have room. errors: InputError, before a window opens, for
/// a screen that is too small.
Size choose_window_size(const AppParams& params, const Display& display);

/// Checks that this session can begin or go on, and makes a plain window the size of the study's layout;
/// writes nothing. errors: InputError, StoreError
Workplace prepare_workplace(const AppParams& params, const Display& display, AppWindow& window);

/// Everything goes on on that monitor, whose facts are read; what was set up for the other one holds no
/// longer, but the distance. errors: InputError for one that is not there or too small; then all stays as it
/// was.
void change_monitor(Workplace& work, Display& display, AppWindow& window, const std::string& name);

/// What the experimenter must know of this computer's clock; empty where it is not behind the log.
std::string describe_clock(const Workplace& work);

/// What the experimenter set up, with what follows from it.
void set_up(Workplace& work, const SetupInput& input);

/// Begins the session, with what was asked before it, or goes on with it. errors: InputError, StoreError
Seat take_seat(Workplace& work, const std::map<std::string, std::string>& fields);

}  // namespace equilux
