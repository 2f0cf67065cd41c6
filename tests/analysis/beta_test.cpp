// Draws of proportions against their distribution.
#include "analysis/beta.h"

#include <boost/math/distributions/beta.hpp>
#include <gtest/gtest.h>
#include <utility>
#include <vector>

#include "base/error.h"
#include "tests/support/statistics.h"

namespace equilux::tests {
namespace {

// Seed 7, 200,000 draws of each in 50 bins of equal probability; level 1 % over all. Jeffreys' posteriors of
// none, some and all of one, twelve and a million answers.
TEST(Beta, is_drawn_as_it_is_distributed) {
  constexpr int kDraws = 200000, kBins = 50;
  const std::vector<std::pair<double, double>> shapes{
      {.5, .5},      {.5, 1.5}, {1.5, .5}, {.5, 12.5}, {12.5, .5}, {9.5, 3.5}, {750000.5, 250000.5},
      {1e6 + .5, .5}};
  for (const auto& [a, b] : shapes) {
    RandomBits bits(RandomRun(7, "beta", static_cast<std::uint64_t>(2 * a + 1e7 * b)));
    Beta drawn(a, b);
    const boost::math::beta_distribution<double> exact(a, b);
    std::vector<double> counts(kBins, 0);
    for (int i = 0; i < kDraws; ++i) {
      const double x = drawn(bits);
      ASSERT_TRUE(x >= 0 && x <= 1) << x;
      ++counts[std::min<std::size_t>(kBins - 1, static_cast<std::size_t>(kBins * cdf(exact, x)))];
    }
    const std::vector<double> expected(kBins, kDraws / double{kBins});
    EXPECT_GT(test::test_chi_squared(counts, expected).p, .01 / 8) << a << ", " << b;
  }
}

TEST(Beta, of_a_shape_that_would_underflow_is_refused) { EXPECT_THROW(Beta(.1, 1), CheckFailure); }

}  // namespace
}  // namespace equilux::tests
