// From windows.json to a window for each column.
#include "protocols/windows.h"

#include "base/error.h"
#include "protocols/by_column.h"

namespace equilux {

extern const char kWindowsSchema[];

namespace {

WindowOrigin parse_origin(const std::string& text) {
  for (const auto origin : {WindowOrigin::kPilot, WindowOrigin::kPredicted, WindowOrigin::kByEye}) {
    if (format_origin(origin) == text) return origin;
  }
  return WindowOrigin::kPlaceholder;
}

}  // namespace

std::string format_origin(WindowOrigin origin) {
  switch (origin) {
    case WindowOrigin::kPilot:
      return "pilot";
    case WindowOrigin::kPredicted:
      return "predicted";
    case WindowOrigin::kByEye:
      return "by_eye";
    case WindowOrigin::kPlaceholder:
      break;
  }
  return "placeholder";
}

Windows load_windows(const std::filesystem::path& path, const Study& study) {
  Windows windows;
  windows.source = load_json(path, kWindowsSchema);
  windows.digest = digest_json(windows.source);
  windows.by_column = read_by_column<Window>(
      windows.source.at("windows"), study, path.string(), "/windows",
      [&](const Json& row, const std::string& place) {
        const Window window{parse_clamp_level(row.at("first").as_string(), path.string(), place + "/first"),
                            parse_origin(row.at("origin").as_string())};
        for (int level = window.first_level; level < window.first_level + kWindowLevels; ++level) {
          if (std::find(study.clamp_levels.begin(), study.clamp_levels.end(), level) ==
              study.clamp_levels.end()) {
            throw InputError(path.string(), place + "/first",
                             fmt::format("{} adjacent clamp levels of the study", kWindowLevels),
                             fmt::format("{}, which the study does not have", format_clamp(level)));
          }
        }
        return window;
      });
  return windows;
}

}  // namespace equilux
