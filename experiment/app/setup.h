// What the experimenter sets up before a subject sits down: how large a pixel is and how far the eye. Pure.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "experiment/app/layout.h"
#include "experiment/app/viewing.h"

namespace equilux {

/// A bank card's long side. source: ISO/IEC 7810, ID-1. units: m
inline constexpr double kCardWidthM = 0.0856;

inline constexpr const char* kTypedDistance = "typed";
inline constexpr const char* kTargetDistance = "target";  ///< the study's, which nobody measured

/// What the system says of a screen, and what was measured on it.
struct ScreenFacts {
  std::string monitor;
  Size mode;  ///< of the current video mode; units: pixels
  double mode_hz = 0;
  Size reported_mm;  ///< 0: not known
  Size framebuffer;
  double content_scale = 1;
  std::optional<double> measured_hz;  ///< by the time from one shown frame to the next, its median
  std::string gl_renderer;
  std::string gl_version;
  std::string gamma_ramp;   ///< identity, changed, not known
  std::string gamma_curve;  ///< of one that was changed: what find_gamma_curve gives
  std::string icc_profile;  ///< name and size, or not known
};

/// What the experimenter gave; 0: not given.
struct SetupInput {
  double diagonal_m = 0;  ///< of the visible screen
  int card_px = 0;        ///< pixels that are as wide as a bank card held to the screen
  double viewing_distance_m = 0;
};

struct ViewingTarget {
  Degrees degrees;
  double viewing_distance_m = 0;
};

struct ViewingSetup {
  std::optional<PixelPitch> pitch;
  std::string pitch_source;  ///< card, diagonal, system or not known
  double viewing_distance_m = 0;
  std::string distance_source;       ///< kTypedDistance or kTargetDistance
  std::optional<Degrees> degrees;    ///< of one picture
  std::vector<std::string> remarks;  ///< for the experimenter: what is not as it should be
};

/// The card comes before the diagonal, and that before what the system says. `picture` in pixels.
ViewingSetup find_setup(const SetupInput& input, const ScreenFacts& facts, const ViewingTarget& target,
                        Size picture);

/// What a session keeps of it, by field name.
std::map<std::string, std::string> find_screen_fields(const ViewingSetup& setup, const ScreenFacts& facts);

/// A gamma ramp in red, green and blue at nine inputs from 0 to 1 in equal steps, as shares of full output:
/// "0 .125 ... 1; ...". shape: as many values of each, two at least
std::string find_gamma_curve(const std::vector<std::vector<std::uint16_t>>& channels);

/// From times of shown frames to frames a second, by the median interval; empty for fewer than three. units:
/// ns
std::optional<double> find_refresh_hz(const std::vector<std::int64_t>& shown_ns);

/// Whether frames come at the rate that the screen's mode says.
bool is_in_step(const ScreenFacts& facts);

/// Whether a pair took longer to the screen than a session should bear: more than 1.5 frames, that is one was
/// dropped; where frames are not in step with the screen, more than two of them and more than 50 ms.
bool is_slow_showing(std::int64_t took_ns, const ScreenFacts& facts);

}  // namespace equilux
