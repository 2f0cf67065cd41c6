// The one file that knows Boost.Math.
#include "analysis/probability.h"

#include <boost/math/distributions/binomial.hpp>
#include <cmath>

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

bool is_supported(const Count& count) {
  check_count(count);
  if (count.n == 0) return false;
  return boost::math::cdf(make_binomial(count.n, kFlagProportion), static_cast<double>(count.k)) <=
         kSupportLevel;
}

}  // namespace equilux
