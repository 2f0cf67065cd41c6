// What one picture's error is at each run time, method by method: measured by equilux-render, shown by the
// report.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/json.h"

namespace equilux {

/// Of an object's pixels, a mean over seeds. Radiance is compared in linear RGB with the reference's; what is
/// known of the reference's own noise is subtracted from the squares.
struct ErrorFigures {
  double relative_rms = 0;        ///< sqrt of the mean squared difference, over the reference's mean radiance
  double relative_rms_error = 0;  ///< its standard error, by the seeds and the reference's noise
  double relative_mse = 0;        ///< mean of (x - r)^2 / (r^2 + (mean / 100)^2)
  double bias = 0;                ///< mean difference over the mean radiance
  double bias_low = 0, bias_high = 0;  ///< 95 % confidence, the reference's noise included
  double flip = 0;                     ///< mean LDR-FLIP of the displayed pictures
  double share_over_one_step = 0;      ///< of pixels that differ by more than one displayed step of 255
  bool operator==(const ErrorFigures&) const = default;
};

/// One method at one setting. A count that the method lacks is 0.
struct ConvergencePoint {
  std::string series;   ///< "lightcuts C4, compensated": points of one curve
  std::string setting;  ///< "100k VPLs"
  std::int64_t vpls = 0;
  double error_ratio = 0;          ///< of lightcuts
  std::optional<int> clamp_level;  ///< with VPLs
  int paths_a_pixel = 0;
  int sets = 0;
  std::map<std::string, double> wall_s, cpu_s;  ///< by stage, means over seeds
  ErrorFigures error;

  double wall() const;  ///< of all stages. units: s
  double cpu() const;
  bool operator==(const ConvergencePoint&) const = default;
};

/// log(relative rms) against log(wall time) by least squares over a series of three settings or more.
struct FittedSlope {
  std::string series;
  double slope = 0;
  bool operator==(const FittedSlope&) const = default;
};

/// One cause of the condition's error by itself.
struct ErrorPart {
  std::string name;
  std::string measured_by;
  double relative_rms = 0;
  double bias = 0, bias_error = 0;  ///< mean over the mean radiance, and its standard error
  bool operator==(const ErrorPart&) const = default;
};

/// Which of the points is nearest to the truth in so many seconds.
struct ConvergenceAdvice {
  double seconds = 0;
  std::optional<std::size_t> point;  ///< empty: none is so fast
  bool operator==(const ConvergenceAdvice&) const = default;
};

struct Convergence {
  std::string source;     ///< name of the scene or study
  std::string condition;  ///< key
  int width = 0, height = 0, positions = 0;
  std::uint64_t seed = 0;
  int seeds = 0;
  int threads = 0;
  std::string isa, host;
  std::string reference;      ///< how it was made
  double reference_mean = 0;  ///< radiance of the object, mean of channels. units: W/(m^2 sr)
  double reference_rms = 0;   ///< relative rms of its own standard error
  /// By which a mean square of differences is wrong after that noise is subtracted: the standard error over
  /// the object's pixels. Relative.
  double reference_square_error = 0;
  std::size_t object_pixels = 0;
  std::vector<ConvergencePoint> points;
  std::vector<FittedSlope> slopes;
  std::vector<ErrorPart> parts;
  std::vector<ConvergenceAdvice> advice;
  std::vector<std::string> left_out;  ///< what could not be measured, and why
  bool operator==(const Convergence&) const = default;
};

/// errors: InputError
Convergence load_convergence(const std::filesystem::path& path);
/// errors: StoreError
void save_convergence(const Convergence& convergence, const std::filesystem::path& path);

/// Series in the order of their first points.
std::vector<std::string> list_series(const Convergence& convergence);

std::optional<double> find_slope(const Convergence& convergence, const std::string& series);

/// Smaller errors are lost in the reference's noise: the root of two standard errors of the mean square from
/// which it is subtracted. units: relative rms
double find_least_error(const Convergence& convergence);

/// False for an error that is lost in the reference's noise: such ones count as equal.
bool is_resolved(const Convergence& convergence, const ConvergencePoint& point);

/// By rising time, the points that are nearer to the truth than all that take no longer.
std::vector<const ConvergencePoint*> find_frontier(const Convergence& convergence);

/// Relative rms for a reader: "1.2 %", or "under .3 %" where it is lost in the reference's noise, "0 %" where
/// there is no noise.
std::string format_error(const Convergence& convergence, const ConvergencePoint& point);

/// The same with its standard error: "1.22 ± 0.05 %".
std::string format_error_interval(const Convergence& convergence, const ConvergencePoint& point);

/// "Within 10 s ...": the advice as sentences, with a warning where the reference is too noisy to give much.
std::string format_advice(const Convergence& convergence);

}  // namespace equilux
