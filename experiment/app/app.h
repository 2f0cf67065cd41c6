// The window: the same sessions as simulated subjects take, shown to a person.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "experiment/trial_log.h"
#include "protocols/experiment.h"

namespace equilux {

/// What is left empty is asked for on the start screen.
struct AppParams {
  std::filesystem::path study_folder;
  std::optional<Experiment> experiment;
  std::string participant;                    ///< code; "new" draws one
  std::string monitor;                        ///< name; empty: the primary one
  bool windowed = false;                      ///< a window of the layout's size in place of the full screen
  double diagonal_m = 0;                      ///< of the visible screen; 0: as the system reports it
  double viewing_distance_m = 0;              ///< from the eyes to the screen; 0: the study's
  bool asks_setup = false;                    ///< the set-up screen is shown also where nothing else is asked
  std::optional<Lane> lane = {};              ///< of new sessions, where several stations run a study
  double text_scale = 1;                      ///< of all text
  std::optional<std::uint64_t> planted_seed;  ///< a planted subject answers in a person's place
  double pace = 1;                            ///< of its response times; 0: at once
};

struct BrowserParams {
  std::filesystem::path study_folder;
  std::filesystem::path study_file;  ///< from which missing pictures are rendered; empty: none can be
  std::string monitor;               ///< name; empty: the primary one
  double text_scale = 1;             ///< of all text
};

/// The study workspace: the set as a grid of clamp levels by VPL counts, pictures flipped against their
/// references, windows moved by hand, answers so far, and what is missing rendered beside it. Runs until the
/// window is closed. Gives the exit code. errors: InputError, StoreError
int run_browser(const BrowserParams& params);

/// Runs until the session is over or the window is closed. Gives the exit code. errors: InputError,
/// StoreError
int run_app(const AppParams& params);

}  // namespace equilux
