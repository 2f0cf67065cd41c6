// How large a picture is to the eye: from the screen's pixels and the viewing distance to degrees.
#pragma once

#include <optional>
#include <string>

#include "experiment/app/layout.h"

namespace equilux {

/// Distance between the centres of neighbouring pixels. units: m
struct PixelPitch {
  double x_m = 0;
  double y_m = 0;
};

/// Angles that a picture spans. units: degrees
struct Degrees {
  double wide = 0;
  double high = 0;
};

/// From the diagonal where it is given (square pixels), else from the size that the system reports; empty
/// where that is 0.
std::optional<PixelPitch> find_pixel_pitch(Size screen, double diagonal_m, Size reported_mm);

/// 2 atan(size / 2 / distance), for a picture before the eye's line of sight.
Degrees find_degrees(Size picture, const PixelPitch& pitch, double viewing_distance_m);

/// A sentence for the experimenter where a picture is more than one degree off its target, or where its size
/// is not known; else empty.
std::string describe_deviation(const std::optional<Degrees>& achieved, const Degrees& target,
                               double viewing_distance_m);

}  // namespace equilux
