// Worlds of a set, of which one is kept: memory goes with the largest, not with their number.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "renderer/work.h"
#include "renderer/world.h"

namespace equilux {

class WorldShelf {
 public:
  /// `seconds`: what making worlds adds to. units: s
  WorldShelf(const Scene& scene, double& seconds) : scene_(scene), seconds_(seconds) {}

  /// Makes it where the last one was another, which goes first. errors: InputError as make_world, and where a
  /// world that was made before has other triangles now: hours may lie between, and files can be edited.
  const World& take(const WorldKey& key);

 private:
  const Scene& scene_;
  double& seconds_;
  WorldKey key_;
  std::optional<World> world_;
  std::map<WorldKey, std::string> digests_;
};

}  // namespace equilux
