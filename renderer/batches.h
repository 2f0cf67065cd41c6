// Sums of one layer at one pixel, randomisation by randomisation, and what they come to.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "stimuli/image.h"
#include "stimuli/vec.h"

namespace equilux {

/// Independent randomisations from which the standard error is taken.
inline constexpr int kBatches = 16;

/// A layer, premultiplied by coverage, and its standard error from kBatches randomisations.
struct TracedLayer {
  HdrImage mean, standard_error;
};

struct BatchSums {
  std::array<std::array<double, 3>, kBatches> sums{};
  void add(int batch, Vec3 value) {
    auto& sum = sums[static_cast<std::size_t>(batch)];
    sum[0] += value.x;
    sum[1] += value.y;
    sum[2] += value.z;
  }
};

/// Into a pixel, whose sums are over so many subpixel positions.
inline void store(const BatchSums& batches, int positions, TracedLayer& layer, std::size_t pixel) {
  for (std::size_t c = 0; c < 3; ++c) {
    double sum = 0, squares = 0;
    for (const auto& batch : batches.sums) sum += batch[c];
    const double mean = sum / kBatches;
    for (const auto& batch : batches.sums) squares += (batch[c] - mean) * (batch[c] - mean);
    layer.mean.pixel(pixel)[c] = static_cast<float>(mean / positions);
    layer.standard_error.pixel(pixel)[c] =
        static_cast<float>(std::sqrt(squares / (kBatches - 1) / kBatches) / positions);
  }
}

}  // namespace equilux
