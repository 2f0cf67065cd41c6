// Scenes for stress rows, written as files so that they take the same way as a user's.
#pragma once

#include <filesystem>
#include <string>

#include "stimuli/scene.h"

namespace equilux {

/// A folder of its own, removed at the end.
class StressFolder {
 public:
  StressFolder();
  ~StressFolder();
  StressFolder(const StressFolder&) = delete;
  StressFolder& operator=(const StressFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// A scene in parts of JSON text.
struct StressText {
  std::string camera =
      R"({"position": [0, -3, 0.6], "target": [0, 0, 0.4], "up": [0, 0, 1], "vertical_fov_degrees": 30})";
  std::string materials = R"([{"name": "grey", "model": "lambertian", "rho_d": [0.5, 0.5, 0.5]}])";
  std::string meshes = R"([{"name": "object", "sphere": {"radius": 0.4, "subdivisions": 4}}])";
  std::string instances = "[]";
  std::string stand = "[0, 0, 0]";
  std::string lights;
};

/// A ball far below, and a light that reaches nothing.
inline const StressText kOpenSpace{
    .stand = "[0, 0, -1000]",
    .lights =
        R"([{"spot": {"position": [0, 0, 900], "target": [0, 0, 999], "inner_degrees": 1, "outer_degrees": 2,
                   "intensity": [1, 1, 1]}}])"};

/// The scene by way of a file in a temporary folder; mesh files of the text must lie in `folder`.
Scene make_stress_scene(const StressText& text, const StressFolder& folder);
Scene make_stress_scene(const StressText& text);

}  // namespace equilux
