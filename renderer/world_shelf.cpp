// One world, and digests of all that there were.
#include "renderer/world_shelf.h"

#include <fmt/format.h>

#include "base/error.h"
#include "renderer/stopwatch.h"

namespace equilux {

const World& WorldShelf::take(const WorldKey& key) {
  if (world_ && key_ == key) return *world_;
  const Stopwatch watch(seconds_);
  world_.reset();
  World world = make_world(scene_, key.geometry, key.illumination);
  const std::string digest = world.digest_triangles();
  if (digests_.try_emplace(key, digest).first->second != digest) {
    throw InputError(scene_.path.string(), "/meshes",
                     "files that stay as they are while a set is rendered; running it again goes on",
                     fmt::format("other triangles in {} than at the start", world.name()));
  }
  key_ = key;
  return world_.emplace(std::move(world));
}

}  // namespace equilux
