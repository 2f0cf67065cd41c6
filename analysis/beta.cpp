// A normal to a gamma variable, two of these to a proportion.
#include "analysis/beta.h"

#include <cmath>

#include "base/error.h"

namespace equilux {

// A shape below one is drawn as one more, times a power of a uniform number.
Gamma::Gamma(double shape)
    : shape_(shape), d_((shape < 1 ? shape + 1 : shape) - 1.0 / 3), c_(1 / std::sqrt(9 * d_)) {
  EQ_CHECK(shape >= 0.5, shape);
}

double Gamma::operator()(RandomBits& bits) {
  const double scale = shape_ < 1 ? std::pow(bits.next_double(), 1 / shape_) : 1;
  for (;;) {
    const double x = normal_(bits), root = 1 + c_ * x;
    if (root <= 0) continue;
    const double v = root * root * root, u = bits.next_double(), square = x * x;
    const bool is_surely_in = u < 1 - 0.0331 * square * square;
    if (is_surely_in || std::log(u) < 0.5 * square + d_ * (1 - v + std::log(v))) return scale * d_ * v;
  }
}

double Beta::operator()(RandomBits& bits) {
  const double first = first_(bits), second = second_(bits);
  return first / (first + second);
}

}  // namespace equilux
