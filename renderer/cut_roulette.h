// Shadow rays for some members of a cut, each with a probability in proportion to what it could bring.
#pragma once

#include <array>
#include <vector>

#include "base/random.h"
#include "renderer/lanes.h"

// After all other headers.
// clang-format off
#include "renderer/isa_begin.h"
// clang-format on

namespace equilux::EQ_ISA {

// Systematic sampling, lane by lane: probabilities are added up from one random start, and a ray is traced
// where the sum passes a whole number. Each has exactly its probability, and how many there are of some that
// follow one another varies by less than one, so that what is left out of one stretch of the cut is not made
// up for by another. Sums are whole numbers of float, without rounding. source: Madow, On the theory of
// systematic sampling, II, 1949.
class RayRoulette {
 public:
  // `share`: of a point's total, from which on a ray is certain. `floor`: as LightcutParams
  RayRoulette(double share, double floor)
      : share_(static_cast<float>(share)), floor_(static_cast<float>(floor)) {}

  // For the points of the lanes, whose totals are given. starts: uniform on [0, 1)
  void start(const std::vector<Floats>& totals, Floats starts) {
    thresholds_.clear();
    for (const Floats total : totals) thresholds_.push_back(share_ * max(total, broadcast(floor_)));
    sum_ = to_floats(truncate(starts * kWhole));
  }

  // Of light over that of a certain ray, at most 1; by the index of a total.
  Floats find_share(std::size_t index, Floats light) const {
    const Floats threshold = thresholds_[index];
    return select(threshold > light, light / threshold, select(light > 0.0f, broadcast(1), zeros()));
  }

  // What a ray's light counts for, 0 where none is traced. share: at most 1; 0: never
  Floats draw(Floats share) {
    const Floats steps = min(to_floats(truncate(share * kWhole)) + 1.0f, broadcast(kWhole));
    const Floats taken = select(share > 0.0f, steps, zeros());
    sum_ += taken;
    const Mask traced = sum_ >= broadcast(kWhole);
    sum_ = select(traced, sum_ - kWhole, sum_);
    return select(traced, kWhole / steps, zeros());
  }

 private:
  static constexpr float kWhole = 1 << 20;

  float share_, floor_;
  std::vector<Floats> thresholds_;  // of light. shape: material x level
  Floats sum_ = zeros();            // of probabilities, in steps of 1 / kWhole
};

// Of the lanes of S points from `first` on, each point's its own. Uniform on [0, 1)
template <std::size_t S>
Floats draw_starts(const StreamKey& key, std::size_t first) {
  std::array<float, kLanes> starts;
  for (std::size_t point = 0; point < S; ++point) {
    RandomStream random(key, first + point);
    for (std::size_t lane = point; lane < kLanes; lane += S) starts[lane] = random.next_float();
  }
  return load(starts.data());
}

}  // namespace equilux::EQ_ISA

#include "renderer/isa_end.h"
