// Sums over VPL sets, each seen through one subpixel position, and what they come to.
#pragma once

#include <vector>

#include "renderer/batches.h"

namespace equilux {

/// A mean over pixels, premultiplied. units: W/(m^2 sr), luminance
struct RegionLight {
  double mean = 0, standard_error = 0;
  std::size_t pixels = 0;
};

/// One layer's over the sets of a position, and of their squares.
class LayerSums {
 public:
  /// shape: height x width x 3
  explicit LayerSums(std::size_t values) : sum_(values), squares_(values) {}

  void add(const HdrImage& layer);
  double mean(std::size_t i) const { return sum_[i] / count_; }
  /// Of the mean; of two sets or more.
  double variance(std::size_t i) const;

 private:
  std::vector<double> sum_, squares_;
  int count_ = 0;
};

/// A layer from its positions, one after another.
class PositionSums {
 public:
  explicit PositionSums(std::size_t values) : mean_(values), variance_(values) {}

  void add(const LayerSums& position);
  TracedLayer finish(int width, int height) const;

 private:
  std::vector<double> mean_, variance_;
  int count_ = 0;
};

/// Regions' means of whole sets, whose pixels err alike.
class RegionSums {
 public:
  /// Region of each pixel, or -1; empty: none. `regions` must outlive it.
  RegionSums(const std::vector<int>& regions, int positions);

  /// A set's layers, which add up.
  void add(int position, const std::vector<const HdrImage*>& layers);
  std::vector<RegionLight> finish() const;

 private:
  const std::vector<int>& regions_;
  std::vector<std::size_t> pixels_;
  std::vector<std::vector<std::vector<double>>> means_;  // shape: position x set x region
};

}  // namespace equilux
