// Statistics that tests share.
#pragma once

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <cstddef>
#include <vector>

namespace equilux::test {

struct ChiSquared {
  double statistic = 0;
  int degrees = 0;
  double p = 1;  ///< probability of so large a statistic if the expected counts are true
};

/// Pearson's test; bins expected under five times are pooled.
inline ChiSquared test_chi_squared(const std::vector<double>& observed, const std::vector<double>& expected) {
  double statistic = 0, pooled_observed = 0, pooled_expected = 0;
  int bins = 0;
  for (std::size_t i = 0; i < observed.size(); ++i) {
    if (expected[i] < 5) {
      pooled_observed += observed[i];
      pooled_expected += expected[i];
      continue;
    }
    statistic += (observed[i] - expected[i]) * (observed[i] - expected[i]) / expected[i];
    ++bins;
  }
  if (pooled_expected > 5) {
    statistic += (pooled_observed - pooled_expected) * (pooled_observed - pooled_expected) / pooled_expected;
    ++bins;
  }
  const int degrees = bins - 1;
  if (degrees < 1) return {statistic, degrees, 1};
  return {statistic, degrees,
          boost::math::cdf(boost::math::complement(boost::math::chi_squared(degrees), statistic))};
}

struct Mean {
  double mean = 0;
  double standard_error = 0;
};

inline Mean mean_of(const std::vector<double>& values) {
  double sum = 0, squares = 0;
  for (double value : values) sum += value;
  const double n = static_cast<double>(values.size()), mean = sum / n;
  for (double value : values) squares += (value - mean) * (value - mean);
  return {mean, std::sqrt(squares / (n - 1) / n)};
}

/// Two-sided p of Welch's test, at the smaller of the two degrees of freedom (conservative).
inline double test_equal_means(const Mean& a, const Mean& b, int smaller_sample) {
  const double error = std::hypot(a.standard_error, b.standard_error);
  if (error == 0) return a.mean == b.mean ? 1 : 0;
  const double t = std::abs(a.mean - b.mean) / error;
  return 2 * boost::math::cdf(boost::math::complement(boost::math::students_t(smaller_sample - 1), t));
}

}  // namespace equilux::test
