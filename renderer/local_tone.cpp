// Gaussians of many widths, and the choice among them.
#include "renderer/local_tone.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.h"
#include "renderer/parallel.h"

namespace equilux {
namespace {

// Beyond this many radii the Gaussian is under 2e-11.
constexpr double kReach = 5;

// Weights of the pixels 0, 1, 2 ... away: integrals over their squares.
std::vector<double> make_kernel(double scale) {
  const double radius = scale / (2 * std::numbers::sqrt2);
  std::vector<double> kernel(static_cast<std::size_t>(std::ceil(kReach * radius)) + 1);
  for (std::size_t i = 0; i < kernel.size(); ++i) {
    const double x = static_cast<double>(i);
    kernel[i] = (std::erf((x + 0.5) / radius) - std::erf((x - 0.5) / radius)) / 2;
  }
  return kernel;
}

// to[i] += weight from[i + shift], where both are in the row.
void add_shifted(const double* from, double* to, std::ptrdiff_t width, std::ptrdiff_t shift, double weight) {
  const std::ptrdiff_t first = std::max<std::ptrdiff_t>(0, -shift), last = std::min(width, width - shift);
  for (std::ptrdiff_t i = first; i < last; ++i) to[i] += weight * from[i + shift];
}

// Along rows, then across them; beyond the border is nothing.
void blur_plainly(std::vector<double>& values, std::ptrdiff_t width, const std::vector<double>& kernel) {
  const auto height = static_cast<std::ptrdiff_t>(values.size()) / width;
  const auto reach = static_cast<std::ptrdiff_t>(kernel.size()) - 1;
  const auto for_each_row = [&](const auto& body) {
    for_each_parallel(static_cast<std::size_t>(height),
                      [&](std::size_t y) { body(static_cast<std::ptrdiff_t>(y)); });
  };
  const auto weight = [&](std::ptrdiff_t shift) { return kernel[static_cast<std::size_t>(std::abs(shift))]; };
  std::vector<double> rows(values.size());
  for_each_row([&](std::ptrdiff_t y) {
    for (std::ptrdiff_t shift = -reach; shift <= reach; ++shift)
      add_shifted(values.data() + y * width, rows.data() + y * width, width, shift, weight(shift));
  });
  std::fill(values.begin(), values.end(), 0.0);
  for_each_row([&](std::ptrdiff_t y) {
    for (std::ptrdiff_t other = std::max<std::ptrdiff_t>(0, y - reach);
         other <= std::min(height - 1, y + reach); ++other)
      add_shifted(rows.data() + other * width, values.data() + y * width, width, 0, weight(other - y));
  });
}

}  // namespace

double find_scale(const LocalTone& tone, int index) {
  return tone.smallest * std::pow(tone.largest / tone.smallest, static_cast<double>(index) / tone.scales);
}

std::vector<double> choose_surrounds(const BlurToScale& blur, const LocalTone& tone) {
  EQ_CHECK(tone.scales >= 1 && tone.smallest > 0 && tone.largest >= tone.smallest);
  std::vector<double> centre = blur(0), chosen = centre;
  std::vector<char> settled(centre.size());
  for (int scale = 0; scale < tone.scales; ++scale) {
    std::vector<double> surround = blur(scale + 1);
    EQ_CHECK(surround.size() == centre.size(), surround.size(), centre.size());
    const double size = find_scale(tone, scale);
    const double floor = tone.key * std::exp2(tone.sharpening) / (size * size);
    for (std::size_t i = 0; i < centre.size(); ++i) {
      if (settled[i]) continue;
      chosen[i] = centre[i];
      settled[i] = std::abs(centre[i] - surround[i]) > tone.threshold * (floor + centre[i]);
    }
    centre = std::move(surround);
  }
  return chosen;
}

std::vector<double> blur_gaussian(const std::vector<double>& values, const std::vector<double>& weights,
                                  int width, double scale) {
  EQ_CHECK(width > 0 && values.size() == weights.size(), width, values.size(), weights.size());
  const std::vector<double> kernel = make_kernel(scale);
  std::vector<double> sums(values.size()), counted = weights;
  for (std::size_t i = 0; i < values.size(); ++i) sums[i] = values[i] * weights[i];
  blur_plainly(sums, width, kernel);
  blur_plainly(counted, width, kernel);
  for (std::size_t i = 0; i < sums.size(); ++i) sums[i] = counted[i] > 0 ? sums[i] / counted[i] : 0;
  return sums;
}

}  // namespace equilux
