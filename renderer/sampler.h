// Numbers for one path: the first few from a lattice with a random shift, the rest from a stream.
#pragma once

#include <array>

#include "base/random.h"

namespace equilux {

inline constexpr std::size_t kLatticeDimensions = 9;

/// A point of [0, 1)^9 in units of 2^-64, so that adding wraps around exactly.
using LatticePoint = std::array<std::uint64_t, kLatticeDimensions>;

LatticePoint draw_shift(RandomStream& stream);

/// A source of numbers in [0, 1). Paths that share a shift are one randomisation of a quasi-Monte Carlo rule:
/// any path by itself is uniform, all together are spread evenly, best where their number is a power of 2.
/// source: Cools, Kuo, Nuyens, "Constructing embedded lattice rules for multivariate integration", SIAM J.
/// Sci. Comput. 28(6), 2006; generating vector lattice-32001-1024-1048576.3600 of F. Y. Kuo; Cranley and
/// Patterson, SIAM J. Numer. Anal. 13(6), 1976 (the shift).
class PathSampler {
 public:
  /// Paths one after another: the shift and what no lattice gives come from one stream, each path's at a
  /// place of its own.
  explicit PathSampler(RandomStream stream, bool low_discrepancy = true);
  /// One path among many that share a shift, whatever their order; `stream` is the path's own.
  PathSampler(const LatticePoint& shift, std::uint64_t path, const RandomStream& stream);

  /// Begins the next path.
  void next_path();
  float next();

 private:
  RandomStream stream_;
  LatticePoint shift_{};
  std::uint64_t place_ = 0;  // radical inverse of the path's index
  std::uint64_t path_ = 0;
  std::size_t dimension_ = 0;
  bool low_discrepancy_ = true;
};

}  // namespace equilux
