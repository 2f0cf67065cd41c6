// Sixteen floats at a time: the kernels' arithmetic. Vectors stay within one file, so their calling
// convention does not matter.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "stimuli/vec.h"

namespace equilux {

inline constexpr std::size_t kLanes = 16;

using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));
using Ints = int __attribute__((vector_size(kLanes * sizeof(int))));

#define EQ_INLINE inline __attribute__((always_inline))

EQ_INLINE Floats broadcast(float value) { return Floats{} + value; }

EQ_INLINE Floats min(Floats a, Floats b) { return a < b ? a : b; }
EQ_INLINE Floats max(Floats a, Floats b) { return a > b ? a : b; }

EQ_INLINE Floats sqrt(Floats a) {
  Floats root;
  for (std::size_t i = 0; i < kLanes; ++i) root[i] = std::sqrt(a[i]);
  return root;
}

// exp(x) for x <= 0, relative error under 3e-7; 0 below -87, where float has only denormals left.
EQ_INLINE Floats exp_of_negative(Floats x) {
  const Floats clamped = max(x, broadcast(-87.0f));
  const Ints n = __builtin_convertvector(clamped * 1.44269504f - 0.5f, Ints);
  const Floats nf = __builtin_convertvector(n, Floats);
  const Floats f = (clamped - nf * 0.693359375f) - nf * -2.12194440e-4f;
  const Floats poly =
      1.0f + f * (1.0f + f * (0.5f + f * (1.6666667e-1f +
                                          f * (4.1666668e-2f + f * (8.3333333e-3f + f * 1.3888889e-3f)))));
  const Ints bits = (n + 127) << 23;
  return x < -87.0f ? Floats{} : poly * std::bit_cast<Floats>(bits);
}

struct Floats3 {
  Floats x, y, z;
};
EQ_INLINE Floats dot(const Floats3& a, const Floats3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
EQ_INLINE Floats3 splat(Vec3 v) { return {broadcast(v.x), broadcast(v.y), broadcast(v.z)}; }
inline void set_lane(Floats3& target, std::size_t lane, Vec3 v) {
  target.x[lane] = v.x;
  target.y[lane] = v.y;
  target.z[lane] = v.z;
}

EQ_INLINE std::uint32_t lane_mask(const Ints& lanes) {
  std::uint32_t mask = 0;
  for (std::size_t i = 0; i < kLanes; ++i) mask |= static_cast<std::uint32_t>(lanes[i] & 1) << i;
  return mask;
}

EQ_INLINE Floats from_mask(std::uint32_t mask) {
  Floats ones{};
  for (std::size_t i = 0; i < kLanes; ++i) ones[i] = (mask >> i) & 1u ? 1.0f : 0.0f;
  return ones;
}

}  // namespace equilux
