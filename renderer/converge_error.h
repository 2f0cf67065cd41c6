// Layers of indirect light held to a reference whose own error is known.
#pragma once

#include "renderer/tone.h"
#include "renderer/vpl_sets.h"
#include "stimuli/convergence.h"

namespace equilux {

/// A family's reference: what all methods share and what they are held to. All premultiplied by coverage.
struct TruthLayers {
  HdrImage background, direct, coverage;
  TracedLayer indirect;
  ToneCurve tone;
  double pixels_per_degree = 35;
};

/// Sums over the object's pixels and channels, means. units: relative to the mean radiance of the object
struct RunError {
  double square = 0;           ///< of x less the reference; the reference's variance subtracted
  double relative_square = 0;  ///< each over r^2 + (mean / 100)^2, likewise
  double bias = 0;             ///< of x less the reference
  /// Of `square`, by the reference's noise, which all runs have in common.
  double square_variance = 0;
  double flip = 0, share_over_one_step = 0;
};

class ReferenceTruth {
 public:
  /// errors: InputError if the object is not seen, or black
  ReferenceTruth(TruthLayers layers, const std::string& name);

  const TruthLayers& layers() const { return layers_; }
  std::size_t object_pixels() const { return pixels_.size(); }
  /// Radiance of the object's direct and indirect light. units: W/(m^2 sr)
  double mean() const { return mean_; }
  /// Relative rms of the reference's own standard error, and that of its mean.
  double rms_of_error() const { return rms_of_error_; }
  double error_of_mean() const { return error_of_mean_; }
  /// Relative standard error of the mean square of a picture without error, from which that noise is
  /// subtracted.
  double error_of_square() const { return error_of_square_; }

  RunError compare(const HdrImage& indirect) const;

  /// Mean over the object's pixels and channels of f(value index) in units of the mean radiance to `power`.
  template <typename Value>
  double average(const Value& value, int power) const {
    double sum = 0;
    for (const std::size_t pixel : pixels_) {
      for (std::size_t c = 0; c < 3; ++c) sum += value(3 * pixel + c);
    }
    return sum / static_cast<double>(3 * pixels_.size()) / std::pow(mean_, power);
  }

 private:
  /// Mean over a pixel's channels of f(value index).
  template <typename Value>
  double average_of(std::size_t pixel, const Value& value) const {
    return (value(3 * pixel) + value(3 * pixel + 1) + value(3 * pixel + 2)) / 3;
  }

  TruthLayers layers_;
  std::vector<std::size_t> pixels_;
  LdrImage display_;
  double mean_ = 0, rms_of_error_ = 0, error_of_mean_ = 0, error_of_square_ = 0;
};

/// Of runs that differ by their seeds, at least two. `error_of_mean`: the reference's, relative.
ErrorFigures summarise_runs(const std::vector<RunError>& runs, double error_of_mean);

}  // namespace equilux
