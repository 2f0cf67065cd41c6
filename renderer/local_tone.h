// Reinhard's local operator: how bright the surroundings are that each pixel is adapted to.
#pragma once

#include <functional>
#include <vector>

namespace equilux {

/// Eight centres with surrounds 1.6 times as wide, which are the next centres: nine Gaussians of 1 to 43
/// pixels. source: Reinhard, Stark, Shirley, Ferwerda, "Photographic tone reproduction for digital images",
/// SIGGRAPH 2002, section 3.2
struct LocalTone {
  int scales = 8;
  double smallest = 1, largest = 43;  ///< of centres and of the last surround. units: pixels
  double sharpening = 8;              ///< phi of eq. 7
  double threshold = 0.05;            ///< of the activity, eq. 8
  double key = 0.18;
};

/// Width of the i-th Gaussian, i = 0 ... scales. units: pixels
double find_scale(const LocalTone& tone, int index);

/// The picture blurred to the scale of this index. shape: height x width
using BlurToScale = std::function<std::vector<double>(int index)>;

/// At each pixel the centre of the smallest scale whose surround differs from it by more than the threshold,
/// or of the largest: the widest even surroundings. `blur` is called once for each index, in order.
std::vector<double> choose_surrounds(const BlurToScale& blur, const LocalTone& tone);

/// Gaussian exp(-r^2 / (k scale)^2), k = 1 / (2 sqrt 2), averaged over each pixel's square, of values
/// weighted by weights of 0 or more, each sum over that of its weights: what lies beyond the border, or has
/// no weight, does not count. 0 where no weight is near. shape: height x width
std::vector<double> blur_gaussian(const std::vector<double>& values, const std::vector<double>& weights,
                                  int width, double scale);

}  // namespace equilux
