// Region means, Welch's test, and the error of a pixel.
#include "tests/peer/compare.h"

#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <fmt/format.h>

#include "base/error.h"
#include "stimuli/vec.h"

namespace equilux::test {
namespace {

using boost::math::complement;
using boost::math::students_t;

constexpr double kPower = 0.95;

void normalise(std::vector<double>& weights) {
  double sum = 0;
  for (double weight : weights) sum += weight;
  EQ_CHECK(sum > 0, sum);
  for (double& weight : weights) weight /= sum;
}

Region make_cell(int width, int height, int columns, int rows, int column, int row) {
  Region region{fmt::format("{},{}", column, row), {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x)
      region.weights.push_back(x * columns / width == column && y * rows / height == row);
  }
  normalise(region.weights);
  return region;
}

double region_mean(const HdrImage& picture, const Region& region, std::size_t channel) {
  EQ_CHECK(picture.pixel_count() == region.weights.size(), picture.pixel_count(), region.weights.size());
  double sum = 0;
  for (std::size_t i = 0; i < picture.pixel_count(); ++i)
    sum += region.weights[i] * double{picture.pixel(i)[channel]};
  return sum;
}

Mean mean_over_seeds(const Pictures& pictures, const Region& region, std::size_t channel) {
  std::vector<double> values;
  for (const HdrImage& picture : pictures) values.push_back(region_mean(picture, region, channel));
  return mean_of(values);
}

double pixel_luminance(const HdrImage& picture, std::size_t i) {
  const float* rgb = picture.pixel(i);
  return double{luminance({rgb[0], rgb[1], rgb[2]})};
}

double mean_luminance(const Pictures& pictures, std::size_t i) {
  double sum = 0;
  for (const HdrImage& picture : pictures) sum += pixel_luminance(picture, i);
  return sum / static_cast<double>(pictures.size());
}

double luminance_variance(const Pictures& pictures, std::size_t i) {
  const double mean = mean_luminance(pictures, i);
  double squares = 0;
  for (const HdrImage& picture : pictures) squares += std::pow(pixel_luminance(picture, i) - mean, 2);
  return squares / (static_cast<double>(pictures.size()) - 1);
}

// Welch's test with the degrees of freedom after Satterthwaite.
void test_difference(Agreement& agreement, std::size_t our_count, std::size_t their_count) {
  const double a = std::pow(agreement.ours.standard_error, 2),
               b = std::pow(agreement.theirs.standard_error, 2);
  if (a + b == 0) {
    agreement.p = std::abs(agreement.relative_difference()) <= kMargin ? 1 : 0;
    return;
  }
  const double difference = agreement.theirs.mean - agreement.ours.mean;
  agreement.t = difference / std::sqrt(a + b);
  agreement.degrees =
      (a + b) * (a + b) /
      (a * a / static_cast<double>(our_count - 1) + b * b / static_cast<double>(their_count - 1));
  const double beyond =
      std::max(0.0, std::abs(difference) - kMargin * agreement.ours.mean) / std::sqrt(a + b);
  agreement.p = 2 * cdf(complement(students_t(agreement.degrees), beyond));
}

}  // namespace

std::vector<Region> make_regions(const HdrImage& coverage, int columns, int rows) {
  std::vector<Region> regions;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column)
      regions.push_back(make_cell(coverage.width, coverage.height, columns, rows, column, row));
  }
  regions.push_back(make_cell(coverage.width, coverage.height, 1, 1, 0, 0));
  regions.back().name = "all";
  Region object{"object", {coverage.values.begin(), coverage.values.end()}};
  normalise(object.weights);
  regions.push_back(std::move(object));
  return regions;
}

double Agreement::visible_bias(double level) const {
  if (degrees == 0) return 0;
  const students_t distribution(degrees);
  const double steps = quantile(complement(distribution, level / 2)) + quantile(distribution, kPower);
  return kMargin + steps * std::hypot(ours.standard_error, theirs.standard_error) / ours.mean;
}

std::vector<Agreement> compare_regions(const Pictures& ours, const Pictures& theirs,
                                       const std::vector<Region>& regions) {
  std::vector<Agreement> agreements;
  for (const Region& region : regions) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      Agreement agreement{region.name, channel, mean_over_seeds(ours, region, channel),
                          mean_over_seeds(theirs, region, channel)};
      test_difference(agreement, ours.size(), theirs.size());
      agreements.push_back(agreement);
    }
  }
  return agreements;
}

double measure_pixel_error(const Pictures& pictures, const Pictures& others) {
  double sum = 0;
  const std::size_t count = pictures.front().pixel_count();
  for (std::size_t i = 0; i < count; ++i) {
    const double mean = (mean_luminance(pictures, i) + mean_luminance(others, i)) / 2;
    EQ_CHECK(mean > 0, i, mean);
    sum += luminance_variance(pictures, i) / (mean * mean);
  }
  return std::sqrt(sum / static_cast<double>(count));
}

}  // namespace equilux::test
