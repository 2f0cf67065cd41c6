// What rendering a condition leaves out, why that is safe, and what it saves: told by the same questions that
// the renderer asks.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "protocols/study.h"
#include "stimuli/scene.h"

namespace equilux {

/// Something that rendering can do without, for some scenes.
struct Omission {
  std::string what;
  bool left_out = false;
  std::string because;  ///< proof that nothing changes, or why it is needed
  std::string saves;    ///< counted in this scene; empty where it is kept
  bool operator==(const Omission&) const = default;
};

struct Plan {
  std::string source;     ///< name of the scene or study
  std::string condition;  ///< key
  std::vector<Omission> omissions;
};

/// What the condition is rendered with.
struct PlanRequest {
  std::string source;
  Condition condition;
  int width = 0, height = 0, positions = 1;
  Emission emission = Emission::kLambertian;
  std::vector<int> clamp_levels;  ///< of one traversal
  /// How the object's reference is made; empty without a study.
  std::optional<ReferenceMethod> reference;
  std::vector<std::string> materials;  ///< of the object's geometry and illumination in the study
  /// Layers of the study that are on disk as they would be made again, and all; empty without a folder.
  std::optional<std::pair<std::size_t, std::size_t>> layers_on_disk;
};

/// errors: InputError for what the scene lacks
Plan make_plan(const Scene& scene, const PlanRequest& request);

/// Plain text.
std::string format_plan(const Plan& plan);

}  // namespace equilux
