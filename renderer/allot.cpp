// From the spread of a pilot to numbers of paths.
#include "renderer/allot.h"

#include <algorithm>
#include <cmath>

#include "renderer/parallel.h"

namespace equilux {
namespace {

// What the mean is foreseen to be over what is asked. The lattice may make it a tenth smaller than the pilot
// shows, or not.
constexpr double kMarginOfMean = 0.97;
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

// Means of boxes of (2 radius + 1)^2 pixels, over those of one kind only, where one of that kind lies. shape:
// height x width
class KindBlur {
 public:
  KindBlur(const HdrImage& coverage, PixelKind kind)
      : width_(coverage.width),
        member_(coverage.pixel_count()),
        left_(coverage.width),
        top_(coverage.height) {
    for (int y = 0; y < coverage.height; ++y) {
      for (int x = 0; x < width_; ++x) {
        const std::size_t i = index_of(x, y);
        if (kind_of(coverage.values[i]) != kind) continue;
        member_[i] = 1;
        left_ = std::min(left_, x), right_ = std::max(right_, x);
        top_ = std::min(top_, y), bottom_ = std::max(bottom_, y);
      }
    }
  }

  // Over those alone that a pilot has seen.
  KindBlur(const HdrImage& coverage, PixelKind kind, const PathMap& seen) : KindBlur(coverage, kind) {
    for (std::size_t i = 0; i < member_.size(); ++i) member_[i] *= seen[i] > 0 ? 1 : 0;
  }

  // How many such pixels are near.
  std::vector<double> count_near(int radius) const { return sum_boxes(member_, radius); }

  // 0 where no such pixel is near.
  std::vector<double> apply(const std::vector<double>& values, int radius,
                            const std::vector<double>& near) const {
    std::vector<double> masked(values.size());
    for (std::size_t i = 0; i < values.size(); ++i) masked[i] = values[i] * member_[i];
    const auto sums = sum_boxes(masked, radius);
    for (std::size_t i = 0; i < values.size(); ++i) masked[i] = near[i] > 0 ? sums[i] / near[i] : 0;
    return masked;
  }

 private:
  std::size_t index_of(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }

  // Within the box of the kind's pixels: outside there are none.
  std::vector<double> sum_boxes(const std::vector<double>& values, int radius) const {
    std::vector<double> rows(values.size()), sums(values.size());
    for (int y = top_; y <= bottom_; ++y) {
      // Term by term for a whole line, so that a line's sums are made side by side.
      for (int step = -radius; step <= radius; ++step) {
        const int last = std::min(right_, right_ - step);
        for (int x = std::max(left_, left_ - step); x <= last; ++x)
          rows[index_of(x, y)] += values[index_of(x + step, y)];
      }
    }
    for (int y = top_; y <= bottom_; ++y) {
      for (int j = std::max(top_, y - radius); j <= std::min(bottom_, y + radius); ++j) {
        for (int x = left_; x <= right_; ++x) sums[index_of(x, y)] += rows[index_of(x, j)];
      }
    }
    return sums;
  }

  int width_;
  std::vector<double> member_;
  int left_, right_ = -1, top_, bottom_ = -1;
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

double after(const PixelError& error, double paths) {
  return std::hypot(error.given, error.of_paths / std::sqrt(paths));
}

// In each batch and at each position.
double count_most_paths(int positions) {
  return static_cast<double>(kMostPathsAPixel) / (kBatches * positions);
}

// Where what is given alone is over the bound, paths are not to add much to it.
constexpr double kLeastRoom = 0.5;

// Paths for errors S of one class: max(1, lambda S^(2/3), (S / bound)^2), the least lambda whose mean error
// meets the target.
std::vector<double> spend(const std::vector<PixelError>& errors, double mean_target, double bound,
                          double most) {
  if (errors.empty()) return {};
  std::vector<double> sizes;
  for (const PixelError& error : errors) sizes.push_back(error.of_paths);
  const double cap = nearest_rank(sizes, kRankOfBound);
  const auto floor_of = [&](const PixelError& error) {
    if (!(bound > 0)) return 1.0;
    const double room = std::max(bound * bound - error.given * error.given, std::pow(kLeastRoom * bound, 2));
    return std::pow(std::min(error.of_paths, cap), 2) / room;
  };
  const auto paths_at = [&](const PixelError& error, double lambda) {
    return std::min(most,
                    std::max({1.0, floor_of(error), lambda * std::cbrt(error.of_paths * error.of_paths)}));
  };
  const auto mean_error = [&](double lambda) {
    double sum = 0;
    for (const PixelError& error : errors) sum += after(error, paths_at(error, lambda));
    return sum / static_cast<double>(errors.size());
  };
  double low = 0, high = 1;
  while (mean_error(high) > mean_target && high < 1e12) high *= 4;
  for (int i = 0; i < 50; ++i) {
    const double middle = (low + high) / 2;
    (mean_error(middle) > mean_target ? low : high) = middle;
  }
  std::vector<double> paths;
  for (const PixelError& error : errors) paths.push_back(paths_at(error, high));
  return paths;
}

std::uint32_t share_of(double paths, double error, double sum) {
  return sum > 0 ? static_cast<std::uint32_t>(std::ceil(std::max(1.0, paths * error / sum))) : 1;
}

// Beside sets few paths will do on an object, of which rounding up would make half as many again or twice as
// many: so neighbours are rounded up and down, as many as leave the mean error, in 1 / sqrt(paths), what it
// would be. 1 / the golden ratio spreads them evenly along a line.
std::uint32_t dither(double paths, double error, double sum, std::size_t place) {
  if (!(sum > 0)) return 1;
  const double wanted = std::max(1.0, paths * error / sum), least = std::floor(wanted);
  const auto err = [](double of) { return 1 / std::sqrt(of); };
  const double up = (err(least) - err(wanted)) / (err(least) - err(least + 1));
  constexpr double kSpread = 0.6180339887498949;
  const double turn = kSpread * static_cast<double>(place);
  return static_cast<std::uint32_t>(least) + (turn - std::floor(turn) < up ? 1u : 0u);
}

// Pixels of one kind that were not seen, from the nearest that were.
void fill_kind(TracedLayer& layer, const PathMap& seen, const HdrImage& coverage, PixelKind kind,
               int radius) {
  const KindBlur blur(coverage, kind, seen);
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i] == 0 && kind_of(coverage.values[i]) == kind) left.push_back(i);
  }
  const int widest = std::max(coverage.width, coverage.height);
  for (int reach = radius; !left.empty() && reach < 4 * widest; reach *= 4) {
    const std::vector<double> near = blur.count_near(reach);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto mean = blur.apply(take_channel(layer.mean, c), reach, near),
                 variance = blur.apply(take_variance(layer.standard_error, c), reach, near);
      for (const std::size_t i : left) {
        if (!(near[i] > 0)) continue;
        layer.mean.pixel(i)[c] = static_cast<float>(mean[i]);
        layer.standard_error.pixel(i)[c] = static_cast<float>(std::sqrt(variance[i]));
      }
    }
    std::erase_if(left, [&](std::size_t i) { return near[i] > 0; });
  }
}

}  // namespace

void fill_between(TracedLayer& layer, const PathMap& seen, const HdrImage& coverage, int radius) {
  for (const PixelKind kind : {PixelKind::kSilhouette, PixelKind::kObject})
    fill_kind(layer, seen, coverage, kind, radius);
}

void fill_room_between(TracedLayer& layer, const PathMap& seen, const HdrImage& coverage, int radius) {
  fill_kind(layer, seen, coverage, PixelKind::kOutside, radius);
}

std::vector<double> foresee_paths(const std::vector<PixelError>& errors, int positions,
                                  const NoiseTarget& target, double percentile) {
  return spend(errors, kMarginOfMean * target.object_mean, percentile * target.object_p99,
               count_most_paths(positions));
}

// Blurs of each kind, with what they need at both radii.
class PixelKinds {
 public:
  explicit PixelKinds(const HdrImage& coverage) : coverage_(coverage) {
    for (const PixelKind kind : kPixelKinds) {
      const KindBlur blur(coverage, kind);
      kinds_.push_back({kind, blur, blur.count_near(kNear), blur.count_near(kWide)});
    }
  }

  std::vector<double> smooth(const std::vector<double>& values) const {
    return join(values, [&](const Kind& kind) { return kind.blur.apply(values, kNear, kind.near); });
  }

  // Never far below a pixel's own, or its wider surroundings'.
  std::vector<double> smooth_variance(const std::vector<double>& variance) const {
    return join(variance, [&](const Kind& kind) {
      std::vector<double> smooth = kind.blur.apply(variance, kNear, kind.near);
      const std::vector<double> wide = kind.blur.apply(variance, kWide, kind.wide);
      for (std::size_t i = 0; i < smooth.size(); ++i)
        smooth[i] = std::max({smooth[i], kFloorOfOwn * variance[i], kFloorOfWide * wide[i]});
      return smooth;
    });
  }

 private:
  struct Kind {
    PixelKind kind;
    KindBlur blur;
    std::vector<double> near, wide;
  };

  // Each kind by itself: the object's light differs from that of the room behind it. What is 0 stays so.
  std::vector<double> join(const std::vector<double>& values, const auto& smooth) const {
    std::vector<double> joined(values.size());
    for (const Kind& kind : kinds_) {
      const auto is_of_kind = [&](std::size_t i) { return kind_of(coverage_.values[i]) == kind.kind; };
      bool any = false;
      for (std::size_t i = 0; i < values.size() && !any; ++i) any = values[i] != 0 && is_of_kind(i);
      if (!any) continue;
      const std::vector<double> of_kind = smooth(kind);
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (is_of_kind(i)) joined[i] = of_kind[i];
      }
    }
    return joined;
  }

  const HdrImage& coverage_;
  std::vector<Kind> kinds_;
};

DisplayPilot::DisplayPilot(const std::vector<const HdrImage*>& layers, const HdrImage& coverage,
                           const ToneMapping& tone)
    : coverage_(coverage), kinds_(std::make_shared<const PixelKinds>(coverage)) {
  const HdrImage reference = composite(layers);
  tone_ = make_tone_curve(reference, coverage, tone);
  mean_ = smooth(reference);
}

std::array<std::vector<double>, 3> DisplayPilot::smooth(const HdrImage& layer) const {
  std::array<std::vector<double>, 3> channels;
  for_each_parallel(3, [&](std::size_t c) { channels[c] = kinds_->smooth(take_channel(layer, c)); });
  return channels;
}

double DisplayPilot::find_size(std::size_t pixel, const std::array<double, 3>& change) const {
  const std::array<double, 3> mean{mean_[0][pixel], mean_[1][pixel], mean_[2][pixel]};
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
  const auto below = eval_display(tone_, pixel, low.data()), above = eval_display(tone_, pixel, high.data());
  double largest = 0;
  for (std::size_t c = 0; c < 3; ++c) largest = std::max(largest, (above[c] - below[c]) / (2 * scale));
  return largest;
}

std::vector<double> DisplayPilot::find_errors(const TracedLayer& layer, const PathMap& map) const {
  std::array<std::vector<double>, 3> variance;
  for_each_parallel(3, [&](std::size_t c) {
    variance[c] = kinds_->smooth_variance(take_variance(layer.standard_error, c));
  });
  std::vector<double> errors(coverage_.pixel_count());
  for (std::size_t i = 0; i < errors.size(); ++i) {
    errors[i] = find_size(i, {std::sqrt(variance[0][i] * map[i]), std::sqrt(variance[1][i] * map[i]),
                              std::sqrt(variance[2][i] * map[i])});
  }
  return errors;
}

PathMaps allot_paths(const LayerErrors& errors, const HdrImage& coverage, int positions,
                     const NoiseTarget& target) {
  const auto& [background, direct, indirect, given] = errors;
  PathMaps maps{PathMap(background.size(), 1), PathMap(background.size(), 1), PathMap(background.size(), 1)};
  for (const bool object : {true, false}) {
    std::vector<std::size_t> members;
    std::vector<PixelError> sums;
    for (std::size_t i = 0; i < background.size(); ++i) {
      if ((coverage.values[i] > 0) != object) continue;
      members.push_back(i);
      sums.push_back({background[i] + direct[i] + indirect[i], given.empty() ? 0 : given[i]});
    }
    const auto paths = object
                           ? foresee_paths(sums, positions, target,
                                           given.empty() ? kPercentileOfPaths : kPercentileBesideSets)
                           : spend(sums, kMarginOfMean * target.outside_mean, 0, count_most_paths(positions));
    for (std::size_t j = 0; j < members.size(); ++j) {
      const std::size_t i = members[j];
      const auto round = [&](double error) {
        return object && !given.empty() ? dither(paths[j], error, sums[j].of_paths, j)
                                        : share_of(paths[j], error, sums[j].of_paths);
      };
      maps.background[i] = round(background[i]);
      maps.direct[i] = round(direct[i]);
      maps.indirect[i] = round(indirect[i]);
    }
  }
  return maps;
}

PathMaps allot_paths(const TracedLayers& pilot, const PathMaps& pilot_maps, const HdrImage& coverage,
                     int positions, const ToneMapping& tone, const NoiseTarget& target) {
  const DisplayPilot view({&pilot.background.mean, &pilot.direct.mean, &pilot.indirect.mean}, coverage, tone);
  return allot_paths({view.find_errors(pilot.background, pilot_maps.background),
                      view.find_errors(pilot.direct, pilot_maps.direct),
                      view.find_errors(pilot.indirect, pilot_maps.indirect)},
                     coverage, positions, target);
}

}  // namespace equilux
