// The study workspace: the set as a grid of clamp levels by VPL counts, pictures flipped against their
// references, windows moved by hand, answers so far, and what is missing rendered beside it.
#pragma once

#include <filesystem>
#include <string>

namespace equilux {

struct BrowserParams {
  std::filesystem::path study_folder;
  std::filesystem::path study_file;  ///< from which missing pictures are rendered; empty: none can be
  std::string monitor;               ///< name; empty: the primary one
};

/// Runs until the window is closed. Gives the exit code. errors: InputError, StoreError
int run_browser(const BrowserParams& params);

}  // namespace equilux
