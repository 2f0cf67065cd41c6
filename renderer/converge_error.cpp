// Squares less the reference's variance, and Student's interval.
#include "renderer/converge_error.h"

#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "base/error.h"
#include "renderer/flip.h"

namespace equilux {
namespace {

// Keeps relative squares finite where the reference is black.
constexpr double kDarkShare = 0.01;

double square(double x) { return x * x; }

// Of a square less its own variance, which is known from kBatches batches, over that variance squared.
constexpr double kVarianceOfSquare = 2 * (1 + 1.0 / (kBatches - 1));

struct Spread {
  double mean = 0, error = 0;
};

template <typename Value>
Spread spread_of(const std::vector<RunError>& runs, const Value& value) {
  const auto count = static_cast<double>(runs.size());
  Spread spread;
  for (const RunError& run : runs) spread.mean += value(run) / count;
  double squares = 0;
  for (const RunError& run : runs) squares += square(value(run) - spread.mean);
  spread.error = std::sqrt(squares / (count - 1) / count);
  return spread;
}

bool differs_by_more_than_a_step(const LdrImage& a, const LdrImage& b, std::size_t pixel) {
  for (std::size_t c = 0; c < 3; ++c) {
    if (std::abs(a.values[3 * pixel + c] - b.values[3 * pixel + c]) > 1) return true;
  }
  return false;
}

// Both shares of a 95 % interval at once: the seeds' by Student, the reference's as if it were known.
double half_width(double error, std::size_t runs, double error_of_mean) {
  const boost::math::students_t student(static_cast<double>(runs) - 1);
  return std::hypot(boost::math::quantile(student, 0.975) * error, 1.96 * error_of_mean);
}

}  // namespace

ReferenceTruth::ReferenceTruth(TruthLayers layers, const std::string& name) : layers_(std::move(layers)) {
  for (std::size_t i = 0; i < layers_.coverage.pixel_count(); ++i) {
    if (layers_.coverage.values[i] > 0) pixels_.push_back(i);
  }
  if (pixels_.empty()) throw InputError(name, "", "an object that is seen", "none in this view");
  mean_ = 1;
  const HdrImage object = composite({&layers_.direct, &layers_.indirect.mean});
  mean_ = average([&](std::size_t i) { return double{object.values[i]}; }, 1);
  if (!(mean_ > 0)) throw InputError(name, "", "an object that some light reaches", "a black one");
  const HdrImage& error = layers_.indirect.standard_error;
  rms_of_error_ = std::sqrt(average([&](std::size_t i) { return square(error.values[i]); }, 2));
  // Pixels are independent; the channels of one go together.
  double variance = 0;
  for (const std::size_t pixel : pixels_) {
    const float* e = error.pixel(pixel);
    variance += square((double{e[0]} + double{e[1]} + double{e[2]}) / 3);
  }
  double fourth = 0;
  for (const std::size_t pixel : pixels_)
    fourth += square(average_of(pixel, [&](std::size_t i) { return square(error.values[i]); }));
  error_of_square_ =
      std::sqrt(kVarianceOfSquare * fourth) / static_cast<double>(pixels_.size()) / square(mean_);
  error_of_mean_ = std::sqrt(variance) / static_cast<double>(pixels_.size()) / mean_;
  display_ = apply_tone_curve(composite({&layers_.background, &layers_.direct, &layers_.indirect.mean}),
                              layers_.tone);
}

RunError ReferenceTruth::compare(const HdrImage& indirect) const {
  const HdrImage &reference = layers_.indirect.mean, &error = layers_.indirect.standard_error;
  const auto difference = [&](std::size_t i) { return double{indirect.values[i]} - reference.values[i]; };
  const auto known = [&](std::size_t i) { return square(difference(i)) - square(error.values[i]); };
  RunError run;
  run.square = average(known, 2);
  run.relative_square = average(
      [&](std::size_t i) {
        const double r = double{reference.values[i]} + layers_.direct.values[i];
        return known(i) / (square(r) + square(kDarkShare * mean_));
      },
      0);
  run.bias = average(difference, 1);
  // Noise that is subtracted, and noise times what the picture errs by.
  double products = 0;
  for (const std::size_t pixel : pixels_)
    products +=
        average_of(pixel, known) * average_of(pixel, [&](std::size_t i) { return square(error.values[i]); });
  run.square_variance = square(error_of_square_) + 4 * std::max(0.0, products) /
                                                       square(static_cast<double>(pixels_.size())) /
                                                       square(square(mean_));
  const LdrImage shown =
      apply_tone_curve(composite({&layers_.background, &layers_.direct, &indirect}), layers_.tone);
  const std::vector<double> flip = measure_flip(display_, shown, layers_.pixels_per_degree);
  for (const std::size_t pixel : pixels_) {
    run.flip += flip[pixel];
    run.share_over_one_step += differs_by_more_than_a_step(display_, shown, pixel) ? 1 : 0;
  }
  run.flip /= static_cast<double>(pixels_.size());
  run.share_over_one_step /= static_cast<double>(pixels_.size());
  return run;
}

ErrorFigures summarise_runs(const std::vector<RunError>& runs, double error_of_mean) {
  EQ_CHECK(runs.size() >= 2, runs.size());
  const Spread squares = spread_of(runs, [](const RunError& run) { return run.square; });
  const Spread bias = spread_of(runs, [](const RunError& run) { return run.bias; });
  ErrorFigures figures;
  figures.relative_rms = std::sqrt(std::max(0.0, squares.mean));
  const double common = spread_of(runs, [](const RunError& run) { return run.square_variance; }).mean;
  figures.relative_rms_error = figures.relative_rms > 0
                                   ? std::hypot(squares.error, std::sqrt(common)) / (2 * figures.relative_rms)
                                   : 0;
  figures.relative_mse =
      std::max(0.0, spread_of(runs, [](const RunError& run) { return run.relative_square; }).mean);
  figures.bias = bias.mean;
  const double half = half_width(bias.error, runs.size(), error_of_mean);
  figures.bias_low = bias.mean - half;
  figures.bias_high = bias.mean + half;
  figures.flip = spread_of(runs, [](const RunError& run) { return run.flip; }).mean;
  figures.share_over_one_step =
      spread_of(runs, [](const RunError& run) { return run.share_over_one_step; }).mean;
  return figures;
}

}  // namespace equilux
