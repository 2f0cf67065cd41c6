// Boxes, sums, differences.
#include "renderer/region_check.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace equilux {
namespace {

constexpr int kGrid = 3;
constexpr int kSilhouettes = kGrid * kGrid, kRegions = kSilhouettes + 1;

std::string name_region(int region) {
  if (region == kSilhouettes) return "silhouettes";
  return fmt::format("r{}c{}", region / kGrid + 1, region % kGrid + 1);
}

// Of pixels that err independently, channels at worst alike.
std::vector<RegionLight> sum_regions(const TracedLayer& layer, const std::vector<int>& regions) {
  std::vector<RegionLight> sums(kRegions);
  for (std::size_t i = 0; i < regions.size(); ++i) {
    if (regions[i] < 0) continue;
    RegionLight& sum = sums[static_cast<std::size_t>(regions[i])];
    const auto luminance_of = [&](const HdrImage& image) {
      const float* p = image.pixel(i);
      return double{luminance({p[0], p[1], p[2]})};
    };
    ++sum.pixels;
    sum.mean += luminance_of(layer.mean);
    sum.standard_error += std::pow(luminance_of(layer.standard_error), 2);
  }
  for (RegionLight& sum : sums) {
    const auto count = static_cast<double>(std::max<std::size_t>(1, sum.pixels));
    sum.mean /= count;
    sum.standard_error = std::sqrt(sum.standard_error) / count;
  }
  return sums;
}

}  // namespace

double RegionCheck::z() const {
  const double met = traced.standard_error > 0 ? std::pow(traced.mean / traced.standard_error, 2)
                     : traced.mean > 0         ? std::numeric_limits<double>::infinity()
                                               : 0;
  const double error = std::max({least_error, std::hypot(light.standard_error, traced.standard_error),
                                 std::abs(light.mean) / std::sqrt(1 + met)});
  return error > 0 ? (light.mean - traced.mean) / error : 0;
}

std::vector<int> find_regions(const HdrImage& share, const PathMap& seen) {
  int left = share.width, right = -1, top = share.height, bottom = -1;
  const auto at = [&](int x, int y) {
    return share.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(share.width) +
                        static_cast<std::size_t>(x)];
  };
  for (int y = 0; y < share.height; ++y) {
    for (int x = 0; x < share.width; ++x) {
      if (!(at(x, y) > 0)) continue;
      left = std::min(left, x), right = std::max(right, x);
      top = std::min(top, y), bottom = std::max(bottom, y);
    }
  }
  std::vector<int> regions;
  for (int y = 0; y < share.height; ++y) {
    for (int x = 0; x < share.width; ++x) {
      const float covered = seen[regions.size()] > 0 ? at(x, y) : 0;
      const int column = kGrid * (x - left) / std::max(1, right - left + 1),
                row = kGrid * (y - top) / std::max(1, bottom - top + 1);
      regions.push_back(covered == 0 ? -1 : covered < 1 ? kSilhouettes : kGrid * row + column);
    }
  }
  return regions;
}

std::vector<RegionCheck> check_regions(std::vector<RegionLight> sets, const TracedLayer& beside,
                                       const TracedLayer& traced, const std::vector<int>& regions,
                                       double step) {
  const auto more = sum_regions(beside, regions), paths = sum_regions(traced, regions);
  sets.resize(kRegions);
  std::vector<RegionCheck> checks;
  for (std::size_t region = 0; region < kRegions; ++region) {
    if (paths[region].pixels == 0) continue;
    RegionLight light = sets[region];
    light.mean += more[region].mean;
    light.standard_error = std::hypot(light.standard_error, more[region].standard_error);
    checks.push_back({name_region(static_cast<int>(region)), light, paths[region], kLeastSteps * step});
  }
  return checks;
}

}  // namespace equilux
