// What the stages of a room hold, as their files do.
#pragma once

#include <algorithm>
#include <cmath>

#include "renderer/allot.h"
#include "renderer/reference.h"
#include "renderer/room_sets.h"
#include "renderer/stage_bytes.h"

namespace equilux {

template <Is<TracedLayer> T>
auto members(T& layer) {
  return std::tie(layer.mean, layer.standard_error);
}

template <Is<RegionLight> T>
auto members(T& light) {
  return std::tie(light.mean, light.standard_error, light.pixels);
}

template <Is<RoomSets> T>
auto members(T& sets) {
  return std::tie(sets.layer, sets.sets, sets.mean_vpls, sets.mean_clusters, sets.regions);
}

template <Is<SetPlan> T>
auto members(T& plan) {
  return std::tie(plan.clamp_level, plan.vpls, plan.sets, plan.error_ratio, plan.sets_cost, plan.light,
                  plan.compensation_errors, plan.set_errors);
}

template <Is<RoomPlan> T>
auto members(T& plan) {
  return std::tie(plan.sets, plan.step, plan.direct, plan.compensation);
}

template <Is<BackgroundPlan> T>
auto members(T& plan) {
  return std::tie(plan.map, plan.by_sets, plan.pilot_map, plan.pilot);
}

inline bool is_sound(const TracedLayer& layer, PixelSize size) {
  const auto is_whole = [&](const HdrImage& image) {
    return PixelSize{image.width, image.height} == size && image.channels == 3;
  };
  return is_whole(layer.mean) && is_whole(layer.standard_error);
}

inline bool is_sound(const RoomSets& sets, PixelSize size) {
  const auto is_real = [](const RegionLight& light) {
    return std::isfinite(light.mean) && std::isfinite(light.standard_error);
  };
  return is_sound(sets.layer, size) && sets.sets >= 1 && std::isfinite(sets.mean_vpls) &&
         std::isfinite(sets.mean_clusters) && std::all_of(sets.regions.begin(), sets.regions.end(), is_real);
}

// Numbers that would never come to an end are no plan's either.
inline bool is_sound(const PathMap& map, PixelSize size) {
  const auto pixels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  const auto is_few = [](std::uint32_t paths) { return paths <= kMostPathsAPixel; };
  return map.size() == pixels && std::all_of(map.begin(), map.end(), is_few);
}

inline bool is_sound(const RoomPlan& plan, PixelSize size) {
  constexpr std::int64_t kMostVpls = 1'000'000'000;
  constexpr int kMostSets = 1'000'000;
  const SetPlan& sets = plan.sets;
  return sets.clamp_level >= 1 && sets.clamp_level <= 10 && sets.vpls >= 1 && sets.vpls <= kMostVpls &&
         sets.sets >= 1 && sets.sets <= kMostSets && sets.error_ratio > 0 && std::isfinite(sets.sets_cost) &&
         PixelSize{sets.light.width, sets.light.height} == size && sets.light.channels == 3 &&
         std::isfinite(plan.step) && is_sound(plan.direct, size) && is_sound(plan.compensation, size);
}

inline bool is_sound(const BackgroundPlan& plan, PixelSize size) {
  const bool is_fixed = plan.pilot_map.empty();
  return is_sound(plan.map, size) && (!plan.by_sets || is_sound(*plan.by_sets, size)) &&
         (is_fixed || (is_sound(plan.pilot_map, size) && is_sound(plan.pilot, size)));
}

}  // namespace equilux
