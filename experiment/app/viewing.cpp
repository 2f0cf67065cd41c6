// Pixels, metres and degrees.
#include "experiment/app/viewing.h"

#include <cmath>
#include <fmt/format.h>
#include <numbers>

namespace equilux {
namespace {

constexpr double kToleranceDegrees = 1;

double angle_of(double size_m, double distance_m) {
  return 2 * std::atan(size_m / 2 / distance_m) * 180 / std::numbers::pi;
}

}  // namespace

std::optional<PixelPitch> find_pixel_pitch(Size screen, double diagonal_m, Size reported_mm) {
  if (screen.width <= 0 || screen.height <= 0) return std::nullopt;
  if (diagonal_m > 0) {
    const double pitch = diagonal_m / std::hypot(screen.width, screen.height);
    return PixelPitch{pitch, pitch};
  }
  if (reported_mm.width <= 0 || reported_mm.height <= 0) return std::nullopt;
  return PixelPitch{reported_mm.width / 1000.0 / screen.width, reported_mm.height / 1000.0 / screen.height};
}

Degrees find_degrees(Size picture, const PixelPitch& pitch, double viewing_distance_m) {
  return {angle_of(picture.width * pitch.x_m, viewing_distance_m),
          angle_of(picture.height * pitch.y_m, viewing_distance_m)};
}

std::string describe_deviation(const std::optional<Degrees>& achieved, const Degrees& target,
                               double viewing_distance_m) {
  if (!achieved) {
    return fmt::format(
        "the size of this screen is not known, so the {:.1f} x {:.1f} degrees that the study wants at {:.0f} "
        "cm cannot be checked. Measure the screen and give its diagonal.",
        target.wide, target.high, 100 * viewing_distance_m);
  }
  const bool is_close = std::abs(achieved->wide - target.wide) <= kToleranceDegrees &&
                        std::abs(achieved->high - target.high) <= kToleranceDegrees;
  if (is_close) return {};
  return fmt::format(
      "at {:.0f} cm from this screen a picture spans {:.1f} x {:.1f} degrees; the study wants {:.1f} x "
      "{:.1f}.",
      100 * viewing_distance_m, achieved->wide, achieved->high, target.wide, target.high);
}

}  // namespace equilux
