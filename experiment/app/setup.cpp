// From what was typed and measured to degrees, remarks and fields.
#include "experiment/app/setup.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace equilux {
namespace {

constexpr double kPitchTolerance = 0.03;  // between card, diagonal and system
constexpr double kDroppedFrames = 1.5, kSlowFrames = 2, kSlowNs = 50e6;
constexpr double kRefreshTolerance = 0.05;  // between measured and nominal

struct NamedPitch {
  const char* source;
  std::optional<PixelPitch> pitch;
};

// In order of trust.
std::vector<NamedPitch> list_pitches(const SetupInput& input, const ScreenFacts& facts) {
  std::vector<NamedPitch> pitches;
  if (input.card_px > 0) {
    const double pitch = kCardWidthM / input.card_px;
    pitches.push_back({"card", PixelPitch{pitch, pitch}});
  }
  if (input.diagonal_m > 0)
    pitches.push_back({"diagonal", find_pixel_pitch(facts.mode, input.diagonal_m, {})});
  pitches.push_back({"system", find_pixel_pitch(facts.mode, 0, facts.reported_mm)});
  std::erase_if(pitches, [](const NamedPitch& named) { return !named.pitch; });
  return pitches;
}

void remark_on_pitches(const std::vector<NamedPitch>& pitches, std::vector<std::string>& remarks) {
  for (std::size_t i = 1; i < pitches.size(); ++i) {
    const double first = pitches[0].pitch->x_m, other = pitches[i].pitch->x_m;
    if (std::abs(other / first - 1) <= kPitchTolerance) continue;
    remarks.push_back(
        fmt::format("by the {} a pixel is {:.4f} mm wide, by the {} {:.4f} mm; the first one is used.",
                    pitches[0].source, 1000 * first, pitches[i].source, 1000 * other));
  }
}

void remark_on_screen(const ScreenFacts& facts, std::vector<std::string>& remarks) {
  if (facts.content_scale != 1) {
    remarks.push_back(
        fmt::format("the system scales what is on this screen by {:.2f}; pictures are shown pixel for "
                    "pixel all the same, but set it to 1 so that nothing else is scaled.",
                    facts.content_scale));
  }
  if (facts.gamma_ramp == "changed")
    remarks.push_back(
        "the graphics card's gamma ramp is not the identity (a night light or a calibration changes it).");
  if (!facts.measured_hz || facts.mode_hz <= 0 || is_in_step(facts)) return;
  remarks.push_back(
      fmt::format("frames come at {:.1f} Hz where the screen's mode says {:.0f} Hz: times of onset are "
                  "not in step with the screen.",
                  *facts.measured_hz, facts.mode_hz));
}

}  // namespace

ViewingSetup find_setup(const SetupInput& input, const ScreenFacts& facts, const ViewingTarget& target,
                        Size picture) {
  ViewingSetup setup;
  const std::vector<NamedPitch> pitches = list_pitches(input, facts);
  setup.pitch_source = pitches.empty() ? "not known" : pitches[0].source;
  if (!pitches.empty()) setup.pitch = pitches[0].pitch;
  const bool is_typed = input.viewing_distance_m > 0;
  setup.viewing_distance_m = is_typed ? input.viewing_distance_m : target.viewing_distance_m;
  setup.distance_source = is_typed ? kTypedDistance : kTargetDistance;
  if (setup.pitch) setup.degrees = find_degrees(picture, *setup.pitch, setup.viewing_distance_m);
  const std::string deviation = describe_deviation(setup.degrees, target.degrees, setup.viewing_distance_m);
  if (!deviation.empty()) setup.remarks.push_back(deviation);
  remark_on_pitches(pitches, setup.remarks);
  remark_on_screen(facts, setup.remarks);
  return setup;
}

std::map<std::string, std::string> find_screen_fields(const ViewingSetup& setup, const ScreenFacts& facts) {
  std::map<std::string, std::string> fields{
      {"pixel_pitch_source", setup.pitch_source},
      {"viewing_distance_source", setup.distance_source},
      {"video_mode", fmt::format("{}x{}", facts.mode.width, facts.mode.height)},
      {"refresh_hz_nominal", fmt::format("{:g}", facts.mode_hz)},
      {"content_scale", fmt::format("{:g}", facts.content_scale)},
      {"gamma_ramp", facts.gamma_ramp},
      {"icc_profile", facts.icc_profile},
      {"gl_renderer", facts.gl_renderer},
      {"gl_version", facts.gl_version}};
  if (!facts.gamma_curve.empty()) fields["gamma_curve"] = facts.gamma_curve;
  if (setup.pitch) {
    fields["pixel_pitch_x_mm"] = fmt::format("{:.5f}", 1000 * setup.pitch->x_m);
    fields["pixel_pitch_y_mm"] = fmt::format("{:.5f}", 1000 * setup.pitch->y_m);
  }
  if (facts.measured_hz) fields["refresh_hz_measured"] = fmt::format("{:.3f}", *facts.measured_hz);
  return fields;
}

std::string find_gamma_curve(const std::vector<std::vector<std::uint16_t>>& channels) {
  constexpr int kSteps = 8;
  std::vector<std::string> curves;
  for (const std::vector<std::uint16_t>& channel : channels) {
    std::vector<std::string> values;
    for (int step = 0; step <= kSteps; ++step) {
      const double at = static_cast<double>(step) / kSteps * static_cast<double>(channel.size() - 1);
      values.push_back(fmt::format("{:.3g}", channel[static_cast<std::size_t>(std::lround(at))] / 65535.0));
    }
    curves.push_back(fmt::format("{}", fmt::join(values, " ")));
  }
  return fmt::format("{}", fmt::join(curves, "; "));
}

bool is_in_step(const ScreenFacts& facts) {
  return facts.measured_hz && *facts.measured_hz > 0 && facts.mode_hz > 0 &&
         std::abs(*facts.measured_hz / facts.mode_hz - 1) <= kRefreshTolerance;
}

bool is_slow_showing(std::int64_t took_ns, const ScreenFacts& facts) {
  const double frame_ns = facts.measured_hz && *facts.measured_hz > 0 ? 1e9 / *facts.measured_hz : 0;
  const double most_ns =
      is_in_step(facts) ? kDroppedFrames * frame_ns : std::max(kSlowNs, kSlowFrames * frame_ns);
  return static_cast<double>(took_ns) > most_ns;
}

std::optional<double> find_refresh_hz(const std::vector<std::int64_t>& shown_ns) {
  if (shown_ns.size() < 3) return std::nullopt;
  std::vector<double> intervals;
  for (std::size_t i = 1; i < shown_ns.size(); ++i)
    intervals.push_back(static_cast<double>(shown_ns[i] - shown_ns[i - 1]));
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  if (!(*middle > 0)) return std::nullopt;
  return 1e9 / *middle;
}

}  // namespace equilux
