// The path-traced layers of one family: background, direct and indirect light of the object, and how sure
// they are.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "protocols/study.h"
#include "renderer/batches.h"
#include "renderer/path_tracer.h"
#include "renderer/primary.h"

namespace equilux {

struct PathMaps {
  PathMap background, direct, indirect;
};

/// Paths a pixel that a count of a study comes to: rounded up to a multiple of kBatches x positions.
int round_paths(int paths, int positions);

/// The same number of paths at every pixel.
PathMaps make_fixed_maps(const Primary& primary, const PathCounts& paths);

/// Paths that maps come to where the object and the room are seen. units: paths
double count_paths(const Primary& primary, const PathMaps& maps);

/// Of the room alone. units: paths
double count_room_paths(const Primary& primary, const PathMap& map);

struct TracedLayers {
  TracedLayer background, direct, indirect;
};

/// What rays need beside the counts.
struct FamilyScene {
  const World& world;
  const Materials& materials;
  const Primary& primary;
};

/// The same beside an object of several materials.
struct RoomScene {
  const World& world;
  std::span<const Materials> materials;
  const Primary& primary;
};

/// Some of a room's materials, by their places.
std::vector<Materials> take_materials(std::span<const Materials> materials,
                                      const std::vector<std::size_t>& which);

/// The layers add up, and their errors are independent. Random numbers are a function of seed, stream name,
/// layer, position and path. `progress` is told the paths done, from any thread.
/// errors: InputError naming the stream if any radiance is not finite, with their number.
TracedLayers trace_layers(const FamilyScene& scene, const PathMaps& maps, std::uint64_t seed,
                          const std::string& stream_name, const PathMeasures& measures,
                          const std::function<void(double)>& progress);

/// What is seen of the room beside an object of several materials, a layer for each: the room's light depends
/// on the object alone where a path meets it, so that paths are shared up to there. Each layer is the one
/// that its material has by itself. errors and `progress` as trace_layers
std::vector<TracedLayer> trace_backgrounds(const World& world, std::span<const Materials> materials,
                                           const Primary& primary, const BatchJob& job,
                                           const std::string& stream_name,
                                           const std::function<void(double)>& progress);

/// Of that layer what comes by way of no other surface: the same beside every material. errors and `progress`
/// as trace_layers
TracedLayer trace_room_direct(const World& world, const Primary& primary, const BatchJob& job,
                              const std::string& stream_name, const std::function<void(double)>& progress);

/// Where the random numbers of that layer come from.
StreamKey make_background_key(std::uint64_t seed, const std::string& stream_name);

/// A picture with a value that is not finite fails as a whole: none is ever set to zero. errors: InputError
/// naming what was made, with their number.
void check_finite(const std::vector<const TracedLayer*>& layers, const std::string& name);

/// Adds a layer whose errors are independent.
void add_independent(TracedLayer& sum, const TracedLayer& more);

/// Standard error of the sum of the layers.
HdrImage combine_standard_errors(const TracedLayers& layers);

}  // namespace equilux
