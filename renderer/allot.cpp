// From the spread of a pilot to numbers of paths.
#include "renderer/allot.h"

#include <algorithm>
#include <cmath>

namespace equilux {
namespace {

// What is foreseen over what is asked. The lattice may make the mean a tenth smaller than the pilot shows, or
// not. The spread that 16 batches show errs by a sixth, which lifts the percentile of what is measured above
// that of what is meant.
constexpr double kMarginOfMean = 0.97;
constexpr double kMarginOfPercentile = 0.4;
// Smoothing: over near pixels of a kind, and never far below what a pixel itself shows, or its wider
// surroundings, where a rare bright path may yet come.
constexpr int kNear = 2, kWide = 8;
constexpr double kFloorOfOwn = 0.7, kFloorOfWide = 0.25;
// Worst pixels beyond this rank do not count for the percentile.
constexpr double kRankOfBound = 0.995;

// Pixels of a kind: their light and its spread are alike in size. At silhouettes Ward-Duer's weights grow
// without bound.
enum class PixelKind { kOutside, kSilhouette, kObject };
constexpr PixelKind kPixelKinds[] = {PixelKind::kOutside, PixelKind::kSilhouette, PixelKind::kObject};

PixelKind kind_of(float coverage) {
  if (coverage == 0) return PixelKind::kOutside;
  return coverage < 1 ? PixelKind::kSilhouette : PixelKind::kObject;
}

// Means of boxes of (2 radius + 1)^2 pixels, over those of one kind only. shape: height x width
class KindBlur {
 public:
  KindBlur(const HdrImage& coverage, PixelKind kind)
      : width_(coverage.width), height_(coverage.height), member_(coverage.pixel_count()) {
    for (std::size_t i = 0; i < member_.size(); ++i) member_[i] = kind_of(coverage.values[i]) == kind ? 1 : 0;
  }

  std::vector<double> apply(const std::vector<double>& values, int radius) const {
    std::vector<double> masked(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) masked[i] = values[i] * member_[i];
    const auto sums = sum_boxes(masked, radius), counts = sum_boxes(member_, radius);
    for (std::size_t i = 0; i < values.size(); ++i) masked[i] = counts[i] > 0 ? sums[i] / counts[i] : 0;
    return masked;
  }

 private:
  std::vector<double> sum_boxes(const std::vector<double>& values, int radius) const {
    return sum_lines(sum_lines(values, radius, width_, 1, height_, width_), radius, height_, width_, width_,
                     1);
  }

  // Sums along lines of `length` pixels that lie `stride` apart.
  static std::vector<double> sum_lines(const std::vector<double>& values, int radius, int length, int stride,
                                       int lines, int line_stride) {
    std::vector<double> sums(values.size());
    for (int line = 0; line < lines; ++line) {
      const auto at = [&](int i) {
        return static_cast<std::size_t>(line) * static_cast<std::size_t>(line_stride) +
               static_cast<std::size_t>(i) * static_cast<std::size_t>(stride);
      };
      for (int i = 0; i < length; ++i) {
        const int first = std::max(0, i - radius), last = std::min(length - 1, i + radius);
        for (int j = first; j <= last; ++j) sums[at(i)] += values[at(j)];
      }
    }
    return sums;
  }

  int width_, height_;
  std::vector<double> member_;
};

// Channel c of an image. shape: height x width
std::vector<double> take_channel(const HdrImage& image, std::size_t c) {
  std::vector<double> values(image.pixel_count());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = image.pixel(i)[c];
  return values;
}

std::vector<double> take_variance(const HdrImage& standard_error, std::size_t c) {
  std::vector<double> values = take_channel(standard_error, c);
  for (double& value : values) value *= value;
  return values;
}

std::vector<double> smooth_variance(const KindBlur& blur, const std::vector<double>& variance) {
  std::vector<double> smooth = blur.apply(variance, kNear);
  const std::vector<double> wide = blur.apply(variance, kWide);
  for (std::size_t i = 0; i < smooth.size(); ++i)
    smooth[i] = std::max({smooth[i], kFloorOfOwn * variance[i], kFloorOfWide * wide[i]});
  return smooth;
}

using Channels = std::array<std::vector<double>, 3>;

// Each kind by itself: the object's light differs from that of the room behind it.
Channels smooth_by_kind(const HdrImage& coverage, const HdrImage& image, const auto& smooth) {
  Channels channels;
  for (std::size_t c = 0; c < 3; ++c) {
    channels[c].resize(image.pixel_count());
    for (const PixelKind kind : kPixelKinds) {
      const std::vector<double> values = smooth(KindBlur(coverage, kind), image, c);
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (kind_of(coverage.values[i]) == kind) channels[c][i] = values[i];
      }
    }
  }
  return channels;
}

// Displayed size of a small change of radiance: largest channel. units: steps of 255
double display_size(const ToneRecord& tone, const std::array<double, 3>& mean,
                    const std::array<double, 3>& change) {
  // Small beside the mean, so that the curve is straight there.
  double scale = 1;
  for (std::size_t c = 0; c < 3; ++c) {
    if (change[c] > 0) scale = std::min(scale, 0.02 * mean[c] / change[c]);
  }
  if (!(scale > 0)) return 0;
  std::array<float, 3> low{}, high{};
  for (std::size_t c = 0; c < 3; ++c) {
    low[c] = static_cast<float>(mean[c] - scale * change[c]);
    high[c] = static_cast<float>(mean[c] + scale * change[c]);
  }
  const auto below = eval_display(tone, low.data()), above = eval_display(tone, high.data());
  double largest = 0;
  for (std::size_t c = 0; c < 3; ++c) largest = std::max(largest, (above[c] - below[c]) / (2 * scale));
  return largest;
}

// Displayed standard error of a layer for one path a batch and position. shape: height x width
std::vector<double> find_display_errors(const TracedLayer& layer, const PathMap& map,
                                        const HdrImage& coverage, const Channels& mean,
                                        const ToneRecord& tone) {
  const Channels variance = smooth_by_kind(coverage, layer.standard_error,
                                           [](const KindBlur& blur, const HdrImage& image, std::size_t c) {
                                             return smooth_variance(blur, take_variance(image, c));
                                           });
  std::vector<double> errors(coverage.pixel_count());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    errors[i] = display_size(tone, {mean[0][i], mean[1][i], mean[2][i]},
                             {std::sqrt(variance[0][i] * map[i]), std::sqrt(variance[1][i] * map[i]),
                              std::sqrt(variance[2][i] * map[i])});
  }
  return errors;
}

// Paths a batch and position for errors S of one class: max(1, lambda S^(2/3), (S / bound)^2), the least
// lambda whose mean of S / sqrt(N) meets the target.
std::vector<double> spend(const std::vector<double>& errors, double mean_target, double bound, double most) {
  if (errors.empty()) return {};
  const double cap = nearest_rank(errors, kRankOfBound);
  const auto paths_at = [&](double error, double lambda) {
    const double floor = bound > 0 ? std::pow(std::min(error, cap) / bound, 2) : 1;
    return std::min(most, std::max({1.0, floor, lambda * std::cbrt(error * error)}));
  };
  const auto mean_error = [&](double lambda) {
    double sum = 0;
    for (double error : errors) sum += error / std::sqrt(paths_at(error, lambda));
    return sum / static_cast<double>(errors.size());
  };
  double low = 0, high = 1;
  while (mean_error(high) > mean_target && high < 1e12) high *= 4;
  for (int i = 0; i < 50; ++i) {
    const double middle = (low + high) / 2;
    (mean_error(middle) > mean_target ? low : high) = middle;
  }
  std::vector<double> paths;
  for (double error : errors) paths.push_back(paths_at(error, high));
  return paths;
}

std::uint32_t share_of(double paths, double error, double sum) {
  return sum > 0 ? static_cast<std::uint32_t>(std::ceil(std::max(1.0, paths * error / sum))) : 1;
}

}  // namespace

PathMaps allot_paths(const TracedLayers& pilot, const PathMaps& pilot_maps, const HdrImage& coverage,
                     int positions, Exposure exposure, double tone_key, const NoiseTarget& target) {
  const HdrImage reference = composite({&pilot.background.mean, &pilot.direct.mean, &pilot.indirect.mean});
  const ToneRecord tone = make_tone_curve(reference, coverage, exposure, tone_key);
  const Channels mean =
      smooth_by_kind(coverage, reference, [](const KindBlur& blur, const HdrImage& image, std::size_t c) {
        return blur.apply(take_channel(image, c), kNear);
      });
  const auto background = find_display_errors(pilot.background, pilot_maps.background, coverage, mean, tone);
  const auto direct = find_display_errors(pilot.direct, pilot_maps.direct, coverage, mean, tone);
  const auto indirect = find_display_errors(pilot.indirect, pilot_maps.indirect, coverage, mean, tone);
  const auto most = static_cast<double>(kMostPathsAPixel) / (kBatches * positions);
  PathMaps maps{PathMap(background.size(), 1), PathMap(background.size(), 1), PathMap(background.size(), 1)};
  for (const bool object : {true, false}) {
    std::vector<std::size_t> members;
    std::vector<double> sums;
    for (std::size_t i = 0; i < background.size(); ++i) {
      if ((coverage.values[i] > 0) != object) continue;
      members.push_back(i);
      sums.push_back(background[i] + direct[i] + indirect[i]);
    }
    const auto paths = spend(sums, kMarginOfMean * (object ? target.object_mean : target.outside_mean),
                             object ? kMarginOfPercentile * target.object_p99 : 0, most);
    for (std::size_t j = 0; j < members.size(); ++j) {
      const std::size_t i = members[j];
      maps.background[i] = share_of(paths[j], background[i], sums[j]);
      maps.direct[i] = share_of(paths[j], direct[i], sums[j]);
      maps.indirect[i] = share_of(paths[j], indirect[i], sums[j]);
    }
  }
  return maps;
}

}  // namespace equilux
