// Tails of the binomial distribution against closed forms, a rational recursion and the other half.
#include "analysis/probability.h"

#include <cmath>
#include <gtest/gtest.h>

#include "base/error.h"

namespace equilux::tests {
namespace {

TEST(Probability, nine_of_twelve_by_guessing_is_299_of_4096) {
  EXPECT_EQ(*eval_p_guess({9, 12}), 299.0 / 4096.0);
}

TEST(Probability, eleven_of_fourteen_by_guessing_is_470_of_16384) {
  EXPECT_EQ(*eval_p_guess({11, 14}), 470.0 / 16384.0);
}

TEST(Probability, nobody_asked_has_no_probability) { EXPECT_FALSE(eval_p_guess({0, 0}).has_value()); }

TEST(Probability, none_or_more_is_certain_and_all_of_n_is_two_to_the_minus_n) {
  for (int n = 1; n <= 400; ++n) {
    ASSERT_EQ(*eval_p_guess({0, n}), 1.0) << n;
    ASSERT_NEAR(*eval_p_guess({n, n}) / std::ldexp(1.0, -n), 1.0, 1e-12) << n;
  }
}

// P(X >= k) + P(X >= n - k + 1) = 1, exact in integers over 2^n up to n = 53, where doubles hold both.
TEST(Probability, both_tails_add_up_to_one_exactly) {
  for (std::int64_t n = 1; n <= 53; ++n) {
    for (std::int64_t k = 1; k <= n; ++k) {
      ASSERT_EQ(*eval_p_guess({k, n}) + *eval_p_guess({n - k + 1, n}), 1.0) << k << " of " << n;
    }
  }
}

// Pascal's rule: P(n, k) = (P(n-1, k-1) + P(n-1, k)) / 2. It ties the incomplete beta function beyond n = 62
// to the integers below.
TEST(Probability, tails_obey_pascals_rule_across_the_change_of_method) {
  for (std::int64_t n = 2; n <= 300; ++n) {
    for (std::int64_t k = 1; k < n; ++k) {
      const double expected = (*eval_p_guess({k - 1, n - 1}) + *eval_p_guess({k, n - 1})) / 2;
      ASSERT_NEAR(*eval_p_guess({k, n}) / expected, 1.0, 1e-11) << k << " of " << n;
    }
  }
}

TEST(Probability, supported_is_five_of_twelve_and_seven_of_fourteen_and_no_more) {
  EXPECT_TRUE(is_supported({5, 12}));
  EXPECT_FALSE(is_supported({6, 12}));
  EXPECT_TRUE(is_supported({7, 14}));
  EXPECT_FALSE(is_supported({8, 14}));
  EXPECT_FALSE(is_supported({0, 0}));
}

TEST(Probability, a_count_above_its_n_is_our_bug) { EXPECT_THROW(eval_p_guess({13, 12}), CheckFailure); }

}  // namespace
}  // namespace equilux::tests
