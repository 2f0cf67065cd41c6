// A made-up study of two columns whose pictures are coloured noise: a match on the screen proves which one is
// shown.
#pragma once

#include <filesystem>

#include "stimuli/image.h"
#include "stimuli/study_folder.h"

namespace equilux {

inline constexpr int kSmallArtifactTrials = 8;  ///< two columns, four levels
inline constexpr int kSmallMaterialTrials = 4;  ///< two columns, two levels

/// Writes study, windows, pictures, manifest, and a selection for persons (of no answers) into a new folder.
StudyFolder make_small_study(const std::filesystem::path& root, int width, int height);

/// The picture of a key as the folder has it.
LdrImage load_small_picture(const StudyFolder& folder, const std::string& key);

}  // namespace equilux
