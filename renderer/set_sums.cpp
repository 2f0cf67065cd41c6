// Means and spreads.
#include "renderer/set_sums.h"

#include <algorithm>
#include <cmath>

namespace equilux {

void LayerSums::add(const HdrImage& layer) {
  for (std::size_t i = 0; i < sum_.size(); ++i) {
    const double value = layer.values[i];
    sum_[i] += value;
    squares_[i] += value * value;
  }
  ++count_;
}

double LayerSums::variance(std::size_t i) const {
  return std::max(0.0, squares_[i] / count_ - mean(i) * mean(i)) / (count_ - 1);
}

void PositionSums::add(const LayerSums& position) {
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    mean_[i] += position.mean(i);
    variance_[i] += position.variance(i);
  }
  ++count_;
}

TracedLayer PositionSums::finish(int width, int height) const {
  TracedLayer layer{HdrImage(width, height), HdrImage(width, height)};
  const double share = 1.0 / count_;
  for (std::size_t i = 0; i < mean_.size(); ++i) {
    layer.mean.values[i] = static_cast<float>(mean_[i] * share);
    layer.standard_error.values[i] = static_cast<float>(std::sqrt(variance_[i]) * share);
  }
  return layer;
}

RegionSums::RegionSums(const std::vector<int>& regions, int positions)
    : regions_(regions), means_(static_cast<std::size_t>(positions)) {
  for (const int region : regions) {
    if (region < 0) continue;
    pixels_.resize(std::max(pixels_.size(), static_cast<std::size_t>(region) + 1));
    ++pixels_[static_cast<std::size_t>(region)];
  }
}

void RegionSums::add(int position, const std::vector<const HdrImage*>& layers) {
  std::vector<double> means(pixels_.size());
  for (const HdrImage* layer : layers) {
    for (std::size_t i = 0; i < regions_.size(); ++i) {
      if (regions_[i] < 0) continue;
      const float* p = layer->pixel(i);
      const auto region = static_cast<std::size_t>(regions_[i]);
      means[region] += luminance({p[0], p[1], p[2]}) / static_cast<double>(pixels_[region]);
    }
  }
  means_[static_cast<std::size_t>(position)].push_back(std::move(means));
}

std::vector<RegionLight> RegionSums::finish() const {
  std::vector<RegionLight> regions(pixels_.size());
  const auto positions = static_cast<double>(means_.size());
  for (std::size_t region = 0; region < regions.size(); ++region) {
    RegionLight& light = regions[region];
    light.pixels = pixels_[region];
    double variance = 0;
    for (const auto& position : means_) {
      const auto count = static_cast<double>(position.size());
      double mean = 0, squares = 0;
      for (const auto& set : position) mean += set[region] / count;
      for (const auto& set : position) squares += (set[region] - mean) * (set[region] - mean);
      light.mean += mean / positions;
      variance += squares / (count - 1) / count;
    }
    light.standard_error = std::sqrt(variance) / positions;
  }
  return regions;
}

}  // namespace equilux
