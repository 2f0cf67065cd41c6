// Weighted means and their errors.
#include "renderer/turns.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace equilux {
namespace {

// Of the sum's error without its room's.
double find_error_of_object(double all, double room) {
  return std::sqrt(std::max(0.0, all * all - room * room));
}

float mix(float first, float second, double share) {
  return static_cast<float>((1 - share) * first + share * second);
}

void mix_images(HdrImage& image, const HdrImage& other, double share) {
  for (std::size_t i = 0; i < image.values.size(); ++i)
    image.values[i] = mix(image.values[i], other.values[i], share);
}

double find_mixed_error(double first, double second, double share) {
  return std::hypot((1 - share) * first, share * second);
}

void mix_light(RegionLight& light, const RegionLight& other, double share) {
  light.mean += share * (other.mean - light.mean);
  light.standard_error = find_mixed_error(light.standard_error, other.standard_error, share);
}

// Their regions are the same, since the pilots see the same pixels.
void mix_regions(std::vector<RegionCheck>& regions, const std::vector<RegionCheck>& others, double share) {
  EQ_CHECK(regions.size() == others.size(), regions.size(), others.size());
  for (std::size_t i = 0; i < regions.size(); ++i) {
    mix_light(regions[i].light, others[i].light, share);
    mix_light(regions[i].traced, others[i].traced, share);
  }
}

// Each errs by itself, but for the room, which both have.
void mix_standard_errors(HdrImage& image, const HdrImage& other, const HdrImage& room, double share) {
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    const double beside = room.values[i];
    const double object = find_mixed_error(find_error_of_object(image.values[i], beside),
                                           find_error_of_object(other.values[i], beside), share);
    image.values[i] = static_cast<float>(std::hypot(object, beside));
  }
}

}  // namespace

Addition find_addition(double miss) {
  const double wanted = kTurnMargin * kTurnMargin, more = wanted - 1 / (miss * miss);
  return {1 / std::sqrt(more), more / wanted};
}

void add_turn(FamilyLayers& layers, FamilyLayers other, const TracedLayer& room, double share) {
  mix_images(layers.direct, other.direct, share);
  mix_images(layers.indirect, other.indirect, share);
  mix_standard_errors(layers.standard_error, other.standard_error, room.standard_error, share);
  if (layers.sets && other.sets) mix_regions(layers.sets->regions, other.sets->regions, share);
  layers.paths += other.paths;
  layers.added.push_back({share, other.paths, std::move(other.sets)});
}

void exchange_room(FamilyLayers& layers, const TracedLayer& before, const TracedLayer& after) {
  layers.background = after.mean;
  for (std::size_t i = 0; i < layers.standard_error.values.size(); ++i) {
    const double object =
        find_error_of_object(layers.standard_error.values[i], before.standard_error.values[i]);
    layers.standard_error.values[i] = static_cast<float>(std::hypot(object, after.standard_error.values[i]));
  }
}

}  // namespace equilux
