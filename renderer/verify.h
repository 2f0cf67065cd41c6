// Is a set whole, consistent and good enough? Nothing is believed that can be computed again.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "stimuli/verify_pictures.h"

namespace equilux {

struct Verification {
  std::size_t pictures = 0, layers = 0;  ///< that the study has
  std::vector<Finding> findings;         ///< in the order of references
  std::vector<std::string> notes;        ///< what was not held against it
};

/// Every picture by verify_pictures, and against its layers: that these are there, finite, of the study's
/// size and of their digests, dark outside their place, no brighter under a harder clamp; that the tone curve
/// is the reference's, the standard error what the layers say, coverage that of the object's other
/// materials, each picture what its layers give, and its
/// background that of its reference; that cuts are certified where the study asks for it, and that no
/// reference by VPL sets lacks its path-traced check or fails it. With a study file also that each layer was
/// made from today's study and scene. As many families at once as there is memory for. errors: InputError
/// where `folder` is no study folder, the study file is another's, or there is no memory for one family
Verification verify_set(const std::filesystem::path& folder,
                        const std::optional<std::filesystem::path>& study_path);

}  // namespace equilux
