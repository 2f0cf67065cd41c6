// Draws from beta distributions, by the hundred thousand.
#pragma once

#include <boost/random/normal_distribution.hpp>
#include <cstdint>

#include "base/random_run.h"

namespace equilux {

/// A stream as Boost draws from it.
class RandomBits {
 public:
  using result_type = std::uint32_t;
  explicit RandomBits(const RandomRun& stream) : stream_(stream) {}
  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return ~result_type{0}; }
  result_type operator()() { return stream_.next_u32(); }
  double next_double() { return stream_.next_double(); }

 private:
  RandomRun stream_;
};

/// Gamma distribution of unit scale. errors: EQ_CHECK of a shape below 1/2, as no posterior here has: draws
/// of a much smaller one underflow. source: Marsaglia and Tsang 2000, A simple method for generating gamma
/// variables, ACM TOMS 26 (3).
class Gamma {
 public:
  explicit Gamma(double shape);
  double operator()(RandomBits& bits);

 private:
  double shape_, d_, c_;
  boost::random::normal_distribution<double> normal_;  // by Boost's ziggurat
};

/// Beta distribution with a, b of 1/2 or more; a draw is in [0, 1].
class Beta {
 public:
  Beta(double a, double b) : a_(a), b_(b), first_(a), second_(b) {}
  double a() const { return a_; }
  double b() const { return b_; }
  double operator()(RandomBits& bits);

 private:
  double a_, b_;
  Gamma first_, second_;
};

}  // namespace equilux
