// For commands that take either: a study as it is, or a scene as a study of one picture.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "protocols/study.h"
#include "stimuli/scene.h"

namespace equilux {

struct SceneOrStudy {
  Study study;  ///< of a scene: no name and no blocks, 280 x 210 pixels, two subpixel positions, all levels
  Scene scene;
  bool is_study = false;

  const std::string& name() const { return is_study ? study.name : scene.name; }
};

/// errors: InputError, also for a file that is neither
SceneOrStudy load_scene_or_study(const std::filesystem::path& path);

/// Conditions by their keys. errors: InputError for what is no key, names what the scene lacks, or is
/// normalised where there is no study or none that normalises
std::vector<Condition> parse_scene_conditions(const SceneOrStudy& input,
                                              const std::vector<std::string>& keys);

}  // namespace equilux
