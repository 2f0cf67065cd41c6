// Which file may include which: the table of CONTRIBUTING.md, checked over a whole tree.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace equilux {

/// Reads every #include below base, protocols, stimuli, renderer, experiment and analysis of `root`. Gives
/// one line for each edge that the table does not allow, each cycle, each foreign library in a second file,
/// and each own header that is not there.
std::vector<std::string> find_include_faults(const std::filesystem::path& root);

}  // namespace equilux
