// From layers of radiance to what a screen shows: one tone curve a family, from its reference.
#pragma once

#include "protocols/study.h"
#include "stimuli/image.h"
#include "stimuli/manifest.h"

namespace equilux {

/// The value at the nearest rank of a share of the sorted values; 0 of none.
double nearest_rank(std::vector<double> values, double share);

/// Sum of layers of one size. Layers are premultiplied by coverage, so they simply add up.
HdrImage composite(const std::vector<const HdrImage*>& layers);

/// The tone curve of a family.
struct ToneCurve {
  ToneRecord record;
  /// Of the local operator, else empty: the scaled luminance around each pixel of the reference. A test
  /// picture is shown by its reference's, so that only the light on the object differs. shape: height x width
  std::vector<float> surrounds;
};

/// Reinhard's operators, their log-average and white point (99.9th percentile of L by nearest rank) taken
/// over the pixels of coverage 0, or over all if `exposure` says so; where those of coverage 0 are black, or
/// there are none, over the others. Black ones would drag the log-average down to delta.
/// Luminance is that of Rec.709 (the paper of the operator uses .27, .67, .06). A black picture gets a curve
/// that keeps black black. delta is 1e-6 of a mean in which values above the white point count as it, so that
/// one hot pixel does not set it. The local operator has no white point. Around pixels of coverage 0 it looks
/// at such pixels alone, where `exposure` says so: else a black and a grey object dodge the walls beside
/// them. source: Reinhard, Stark, Shirley, Ferwerda, "Photographic tone reproduction for digital images",
/// SIGGRAPH 2002, eq. 1-4 and 5-9.
ToneCurve make_tone_curve(const HdrImage& reference, const HdrImage& coverage, const ToneMapping& mapping);

/// The sRGB transfer function and its inverse. units: both sides 0 to 1
double encode_srgb(double linear);
double decode_srgb(double encoded);

/// The displayed value of a linear colour in a pixel before rounding. shape: 3. units: steps of 255
std::array<double, 3> eval_display(const ToneCurve& tone, std::size_t pixel, const float* rgb);

/// The luminance that is displayed as this share of a step of 255, where it is darkest.
double find_radiance_of_step(const ToneRecord& tone, double share);

/// Tone curve, sRGB transfer function, 8 bit.
LdrImage apply_tone_curve(const HdrImage& image, const ToneCurve& tone);

/// Standard error of a reference as displayed. units: steps of 255
struct DisplayNoise {
  double object_mean = 0;
  double object_p99 = 0;
  double outside_mean = 0;
};

/// Each pixel's standard error through the tone curve, its surroundings as they are: half the displayed
/// difference of mean + and - one standard error, the largest channel. shape: height x width. units: steps of
/// 255
std::vector<double> measure_pixel_noise(const HdrImage& reference, const HdrImage& standard_error,
                                        const ToneCurve& tone);

/// Pixels of noise as greys, 51 levels a step: white is five steps and more.
LdrImage show_noise(const std::vector<double>& noise, int width, int height);

/// Its means and 99th percentile over pixels of coverage > 0 and of coverage 0.
DisplayNoise measure_display_noise(const HdrImage& reference, const HdrImage& standard_error,
                                   const HdrImage& coverage, const ToneCurve& tone);

bool meets_target(const DisplayNoise& noise, const NoiseTarget& target);

/// Scales a clamped layer so that its mean luminance equals that of the unclamped layer of the same VPLs.
/// Layers are premultiplied, so their plain means are weighted by coverage. A black clamped layer stays
/// black.
HdrImage normalise_luminance(const HdrImage& clamped, const HdrImage& unclamped);

}  // namespace equilux
