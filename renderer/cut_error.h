// Lightcuts whose error is measured: at some points of the picture against light that is known better.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/json.h"
#include "renderer/lightcut.h"

namespace equilux {

/// One material's light at points by cuts through trees, one after another: of each the total so far is the
/// base of the next.
struct CutTask {
  const World& world;
  const std::vector<ShadingPoint>& points;
  std::vector<const LightTree*> trees;
  const Material& material;
  const std::vector<double>& clamps_per_m2;
  std::function<void(double)> progress = {};  ///< told points done, each once, from any thread
};

struct CutRule {
  double error_ratio = 0.0075;
  double floor = 0;  ///< as LightcutParams::floor
  /// The ratio is halved until the 99th percentile of the errors is under kCertifiedError at every level:
  /// first at points drawn for that, then at those that the record tells of.
  bool certified = false;
};
inline constexpr double kCertifiedError = 0.01;

/// Relative errors at points of one level: luminance less the true one, over the true one or the floor.
struct ErrorSummary {
  std::size_t points = 0;
  double mean = 0, rms = 0;
  double rms_low = 0, rms_high = 0;  ///< 95 % confidence, by the spread of the squares
  double p99 = 0, max = 0;           ///< of the absolute values
};
ErrorSummary summarise_errors(const std::vector<double>& errors);

/// What is known of a picture by cuts, for all levels.
struct CutMeasures {
  double error_ratio = 0;  ///< that the rule ended with
  double floor = 0;
  std::optional<bool> certified;                     ///< where that was asked for: whether it was reached
  double mean_size = 0, p99_size = 0, max_size = 0;  ///< clusters and VPLs of a point's cut
  std::uint64_t rays = 0;
  double seconds_cut = 0, seconds_measured = 0;
  bool against_plain_sum = true;            ///< else against cuts of a twentieth of the ratio
  std::vector<std::vector<double>> errors;  ///< shape: level x point drawn
  /// Of those finer cuts against the plain sum; empty if that is what all are held to. shape: level
  std::vector<ErrorSummary> finer;
};

struct MeasuredCut {
  ShadedPoints shaded;  ///< shape: one material
  CutMeasures measures;
};

/// Cuts, and measures the error at 256 points drawn by `seed`: against the plain sum up to 100,000 VPLs, else
/// against cuts of a twentieth of the ratio that are themselves held to the plain sum at 16 of the points:
/// what these err by must be under half of what is certified.
MeasuredCut shade_measured(const CutTask& task, const CutRule& rule, std::uint64_t seed);

/// The record of one level, for layers.json and manifest.json. Errors are relative.
Json make_json(const CutMeasures& measures, std::size_t level);

/// The absolute errors of one level, sorted, in units of 1e-5: so that those of many pictures can be pooled.
Json make_pool(const CutMeasures& measures, std::size_t level);

/// Of all that were pooled: how many points, rms, 99th percentile and largest, relative.
ErrorSummary summarise_pools(const std::vector<const Json*>& pools);

}  // namespace equilux
