// The one file that knows Boost.Math.
#include "analysis/probability.h"

#include <algorithm>
#include <boost/math/distributions/beta.hpp>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>

#include "base/error.h"

namespace equilux {
namespace {

constexpr std::int64_t kLargestExactN = 62;  // sums of C(n, i) stay below 2^63

void check_count(const Count& count) { EQ_CHECK(count.k >= 0 && count.k <= count.n, count.k, count.n); }

// Number of the 2^n outcomes with k or more correct.
std::uint64_t count_upper_outcomes(const Count& count) {
  std::uint64_t outcomes = 0;
  unsigned __int128 choose = 1;
  for (std::int64_t i = 0; i <= count.n; ++i) {
    if (i >= count.k) outcomes += static_cast<std::uint64_t>(choose);
    choose = choose * static_cast<unsigned>(count.n - i) / static_cast<unsigned>(i + 1);
  }
  return outcomes;
}

boost::math::binomial_distribution<double> make_binomial(std::int64_t n, double proportion) {
  return {static_cast<double>(n), proportion};
}

boost::math::beta_distribution<double> make_posterior(const Count& count) {
  return {static_cast<double>(count.k) + 0.5, static_cast<double>(count.n - count.k) + 0.5};
}

// Of x successes before the ends of the interval, as quantiles of the beta distribution.
double find_beta_quantile(std::int64_t successes, std::int64_t failures, double p) {
  const boost::math::beta_distribution<double> beta(static_cast<double>(successes),
                                                    static_cast<double>(failures));
  return boost::math::quantile(beta, p);
}

}  // namespace

std::optional<double> eval_p_guess(const Count& count) {
  check_count(count);
  if (count.n == 0) return std::nullopt;
  if (count.n <= kLargestExactN) {
    return std::ldexp(static_cast<double>(count_upper_outcomes(count)), -static_cast<int>(count.n));
  }
  if (count.k == 0) return 1.0;
  return boost::math::cdf(
      boost::math::complement(make_binomial(count.n, 0.5), static_cast<double>(count.k - 1)));
}

std::optional<double> eval_p_two_sided(const Count& count) {
  check_count(count);
  if (count.n == 0) return std::nullopt;
  return std::min(1.0, 2 * *eval_p_guess({std::max(count.k, count.n - count.k), count.n}));
}

bool is_supported(const Count& count, int percent) {
  check_count(count);
  if (count.n == 0) return false;
  return boost::math::cdf(make_binomial(count.n, percent / 100.0), static_cast<double>(count.k)) <=
         kSupportLevel;
}

std::optional<Interval> find_clopper_pearson(const Count& count, double level) {
  check_count(count);
  if (count.n == 0) return std::nullopt;
  const double tail = (1 - level) / 2;
  Interval interval;
  if (count.k > 0) interval.lower = find_beta_quantile(count.k, count.n - count.k + 1, tail);
  if (count.k < count.n) interval.upper = find_beta_quantile(count.k + 1, count.n - count.k, 1 - tail);
  return interval;
}

std::optional<Interval> find_jeffreys(const Count& count, double level) {
  check_count(count);
  if (count.n == 0) return std::nullopt;
  const double tail = (1 - level) / 2;
  const auto posterior = make_posterior(count);
  Interval interval;
  if (count.k > 0) interval.lower = boost::math::quantile(posterior, tail);
  if (count.k < count.n) interval.upper = boost::math::quantile(posterior, 1 - tail);
  return interval;
}

double find_bootstrap_tail(std::size_t subjects, double level) {
  EQ_CHECK(subjects > 1, subjects);
  const auto n = static_cast<double>(subjects);
  const double t = boost::math::quantile(boost::math::students_t(n - 1), (1 - level) / 2);
  return boost::math::cdf(boost::math::normal(), t * std::sqrt(n / (n - 1)));
}

std::optional<double> eval_posterior_over(const Count& count, double proportion) {
  check_count(count);
  if (count.n == 0) return std::nullopt;
  return boost::math::cdf(boost::math::complement(make_posterior(count), proportion));
}

std::vector<double> adjust_false_discovery(const std::vector<double>& p_values) {
  const std::size_t m = p_values.size();
  std::vector<std::size_t> order(m);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return p_values[a] < p_values[b]; });
  std::vector<double> q_values(m);
  double least = 1;
  for (std::size_t rank = m; rank > 0; --rank) {
    const std::size_t i = order[rank - 1];
    least = std::min(least, p_values[i] * static_cast<double>(m) / static_cast<double>(rank));
    q_values[i] = least;
  }
  return q_values;
}

}  // namespace equilux
