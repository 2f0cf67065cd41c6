// The clamp window of each column: the four adjacent levels that the artifact experiment tests. A person may
// edit the file.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "protocols/study.h"

namespace equilux {

enum class WindowOrigin { kPilot, kPredicted, kByEye, kPlaceholder };

struct Window {
  int first_level = 0;  ///< least clamped of the kWindowLevels levels
  WindowOrigin origin = WindowOrigin::kPlaceholder;
};

struct Windows {
  std::map<Column, Window> by_column;
  Json source;
  std::string digest;
};

std::string format_origin(WindowOrigin origin);

/// errors: InputError if a column of the study has no window, or a window no column.
Windows load_windows(const std::filesystem::path& path, const Study& study);

}  // namespace equilux
