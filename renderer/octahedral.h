// Unit vectors in four bytes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "stimuli/vec.h"

namespace equilux {

/// Decoding what was encoded errs by at most this; the axes come back exact. units: radians
inline constexpr float kOctahedralError = 1.2e-4f;
inline constexpr float kOctahedralSteps = 32767;

/// The octahedron's faces folded into a square. source: Cigolle et al., "A survey of efficient
/// representations for independent unit vectors", JCGT 3(2), 2014.
using Octahedral = std::array<std::int16_t, 2>;

inline Octahedral encode_octahedral(Vec3 unit) {
  const float sum = std::abs(unit.x) + std::abs(unit.y) + std::abs(unit.z);
  float x = unit.x / sum, y = unit.y / sum;
  if (unit.z < 0) {
    const float fold_x = (1 - std::abs(y)) * std::copysign(1.0f, x);
    y = (1 - std::abs(x)) * std::copysign(1.0f, y);
    x = fold_x;
  }
  const auto round = [](float value) {
    return static_cast<std::int16_t>(std::lround(std::clamp(value, -1.0f, 1.0f) * kOctahedralSteps));
  };
  return {round(x), round(y)};
}

inline Vec3 decode_octahedral(Octahedral code) {
  constexpr float kStep = 1 / kOctahedralSteps;
  Vec3 unit{static_cast<float>(code[0]) * kStep, static_cast<float>(code[1]) * kStep, 0};
  unit.z = 1 - std::abs(unit.x) - std::abs(unit.y);
  const float fold = std::max(0.0f, -unit.z);
  unit.x -= std::copysign(fold, unit.x);
  unit.y -= std::copysign(fold, unit.y);
  return normalize(unit);
}

}  // namespace equilux
