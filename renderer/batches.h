// Sums of one layer at one pixel, randomisation by randomisation, and what they come to.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "renderer/path_tracer.h"
#include "stimuli/image.h"

namespace equilux {

/// Independent randomisations from which the standard error is taken.
inline constexpr int kBatches = 16;

/// A layer, premultiplied by coverage, and its standard error.
struct TracedLayer {
  HdrImage mean, standard_error;
};

/// Paths of one layer at each pixel, in each batch and at each subpixel position; none leave it black.
/// shape: height x width
using PathMap = std::vector<std::uint32_t>;

/// Of it only every so many-th line and column.
inline PathMap thin_out(PathMap map, int width, std::size_t stride) {
  for (std::size_t i = 0; i < map.size(); ++i) {
    const auto wide = static_cast<std::size_t>(width);
    if (i % wide % stride != 0 || i / wide % stride != 0) map[i] = 0;
  }
  return map;
}

using LightSum = std::array<double, 3>;

inline void add_light(Vec3 light, LightSum& sum) {
  sum[0] += light.x;
  sum[1] += light.y;
  sum[2] += light.z;
}

/// Of one layer at one pixel.
using BatchSums = std::array<LightSum, kBatches>;

/// Where random numbers come from, and how many paths are asked for.
struct BatchJob {
  StreamKey key;
  const PathMap& map;
  const PathMeasures& measures;
};

/// Means of one position's paths into one layer or several, all from the same paths. estimate(sampler, sums)
/// adds one path's light to the sum of each layer. `place`: of pixel and position.
template <typename Estimate>
void add_batches(std::span<BatchSums> layers, const BatchJob& job, std::size_t pixel, std::uint64_t place,
                 const Estimate& estimate) {
  const std::uint32_t paths = job.map[pixel];
  if (paths == 0) return;
  std::vector<LightSum> sums(layers.size());
  for (std::size_t batch = 0; batch < kBatches; ++batch) {
    PathSampler sampler(RandomStream(job.key, place * kBatches + batch), job.measures.low_discrepancy);
    for (LightSum& sum : sums) sum = {};
    for (std::uint32_t path = 0; path < paths; ++path) {
      sampler.next_path();
      estimate(sampler, sums);
    }
    const double share = 1.0 / paths;
    for (std::size_t i = 0; i < sums.size(); ++i)
      add_light({static_cast<float>(sums[i][0] * share), static_cast<float>(sums[i][1] * share),
                 static_cast<float>(sums[i][2] * share)},
                layers[i][batch]);
  }
}

/// Into a pixel, whose sums are over so many subpixel positions.
inline void store(const BatchSums& batches, int positions, TracedLayer& layer, std::size_t pixel) {
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0, squares = 0;
    for (const LightSum& batch : batches) sum += batch[c];
    const double mean = sum / kBatches;
    for (const LightSum& batch : batches) squares += (batch[c] - mean) * (batch[c] - mean);
    layer.mean.pixel(pixel)[c] = static_cast<float>(mean / positions);
    layer.standard_error.pixel(pixel)[c] =
        static_cast<float>(std::sqrt(squares / (kBatches - 1) / kBatches) / positions);
  }
}

}  // namespace equilux
