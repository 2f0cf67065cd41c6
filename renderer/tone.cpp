// Tone mapping.
#include "renderer/tone.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "base/error.h"
#include "renderer/local_tone.h"

namespace equilux {
namespace {

double luminance_of(const float* rgb) { return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; }

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (double value : values) sum += value;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

// Mean with what is above the top cut down to it: one hot pixel must not lift delta over all the others.
double mean_below(const std::vector<double>& values, double top) {
  double sum = 0;
  for (double value : values) sum += std::min(value, top);
  return sum / static_cast<double>(values.size());
}

std::vector<double> collect_luminance(const HdrImage& image, const HdrImage& coverage,
                                      const std::function<bool(float)>& is_wanted) {
  std::vector<double> values;
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    if (is_wanted(coverage.values[i])) values.push_back(luminance_of(image.pixel(i)));
  }
  return values;
}

// Of the pixels that set the curve. Black ones beside a lit object would set none.
std::vector<double> collect_adaptation(const HdrImage& image, const HdrImage& coverage, Exposure exposure) {
  if (exposure == Exposure::kWhole) return collect_luminance(image, coverage, [](float) { return true; });
  std::vector<double> outside = collect_luminance(image, coverage, [](float share) { return share == 0; });
  if (mean_of(outside) > 0) return outside;
  return collect_luminance(image, coverage, [](float share) { return share != 0; });
}

double mean_luminance(const HdrImage& image) {
  double sum = 0;
  for (std::size_t i = 0; i < image.pixel_count(); ++i) sum += luminance_of(image.pixel(i));
  return sum / static_cast<double>(image.pixel_count());
}

// The record of the global operator.
ToneRecord make_global_curve(const HdrImage& reference, const HdrImage& coverage,
                             const ToneMapping& mapping) {
  const std::vector<double> values = collect_adaptation(reference, coverage, mapping.exposure);
  ToneRecord tone;
  tone.key = mapping.key;
  tone.exposure = mapping.exposure == Exposure::kWhole ? "whole" : "background";
  const double top = nearest_rank(values, 0.999);
  const double mean = top > 0 ? mean_below(values, top) : mean_of(values);
  if (!(mean > 0)) {
    tone.log_average = 1;
    return tone;
  }
  tone.delta = 1e-6 * mean;
  double logs = 0;
  for (double value : values) logs += std::log(tone.delta + value);
  tone.log_average = std::exp(logs / static_cast<double>(values.size()));
  tone.white = top * tone.key / tone.log_average;
  return tone;
}

// Scaled luminance around each pixel; for some of them that of their own kind alone.
std::vector<float> find_surrounds(const HdrImage& reference, const HdrImage& coverage, const ToneRecord& tone,
                                  const ToneMapping& mapping) {
  std::vector<double> scaled(reference.pixel_count());
  for (std::size_t i = 0; i < scaled.size(); ++i)
    scaled[i] = tone.key * std::max(0.0, luminance_of(reference.pixel(i))) / tone.log_average;
  LocalTone local;
  local.key = tone.key;
  const auto look_at = [&](const std::vector<double>& weights) {
    return choose_surrounds(
        [&](int index) { return blur_gaussian(scaled, weights, reference.width, find_scale(local, index)); },
        local);
  };
  const std::vector<double> of_all = look_at(std::vector<double>(scaled.size(), 1));
  std::vector<float> surrounds(of_all.begin(), of_all.end());
  if (mapping.exposure == Exposure::kWhole) return surrounds;
  std::vector<double> outside(scaled.size());
  for (std::size_t i = 0; i < outside.size(); ++i) outside[i] = coverage.values[i] == 0;
  const std::vector<double> of_outside = look_at(outside);
  for (std::size_t i = 0; i < outside.size(); ++i) {
    if (coverage.values[i] == 0) surrounds[i] = static_cast<float>(of_outside[i]);
  }
  return surrounds;
}

}  // namespace

double encode_srgb(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

double decode_srgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

double nearest_rank(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  const auto index =
      static_cast<std::ptrdiff_t>(std::clamp(rank, 1.0, static_cast<double>(values.size()))) - 1;
  std::nth_element(values.begin(), values.begin() + index, values.end());
  return values[static_cast<std::size_t>(index)];
}

HdrImage composite(const std::vector<const HdrImage*>& layers) {
  EQ_CHECK(!layers.empty());
  HdrImage sum = *layers.front();
  for (std::size_t i = 1; i < layers.size(); ++i) {
    EQ_CHECK(layers[i]->values.size() == sum.values.size(), layers[i]->values.size(), sum.values.size());
    for (std::size_t j = 0; j < sum.values.size(); ++j) sum.values[j] += layers[i]->values[j];
  }
  return sum;
}

ToneCurve make_tone_curve(const HdrImage& reference, const HdrImage& coverage, const ToneMapping& mapping) {
  ToneCurve curve{make_global_curve(reference, coverage, mapping), {}};
  if (mapping.operation == ToneOperator::kLocal) {
    curve.record.tone_operator = "local";
    curve.record.white = 0;
    curve.surrounds = find_surrounds(reference, coverage, curve.record, mapping);
  }
  return curve;
}

std::array<double, 3> eval_display(const ToneCurve& curve, std::size_t pixel, const float* rgb) {
  const ToneRecord& tone = curve.record;
  const double world = luminance_of(rgb);
  if (!(world > 0)) return {0, 0, 0};
  const double scaled = tone.key * world / tone.log_average;
  const double burn = tone.white > 0 ? scaled / (tone.white * tone.white) : 0;
  const double around = curve.surrounds.empty() ? scaled : curve.surrounds[pixel];
  const double display = scaled * (1 + burn) / (1 + around);
  std::array<double, 3> values{};
  for (std::size_t c = 0; c < 3; ++c) {
    values[c] = 255 * encode_srgb(std::clamp(rgb[c] * display / world, 0.0, 1.0));
  }
  return values;
}

double find_radiance_of_step(const ToneRecord& tone, double share) {
  // The curve starts at a slope of key / log-average, the transfer function at 12.92.
  return tone.key > 0 && tone.log_average > 0 ? share / 255 / 12.92 * tone.log_average / tone.key : 0;
}

LdrImage apply_tone_curve(const HdrImage& image, const ToneCurve& tone) {
  LdrImage picture(image.width, image.height);
  for (std::size_t i = 0; i < image.pixel_count(); ++i) {
    const auto display = eval_display(tone, i, image.pixel(i));
    for (std::size_t c = 0; c < 3; ++c)
      picture.values[3 * i + c] = static_cast<std::uint8_t>(std::floor(display[c] + 0.5));
  }
  return picture;
}

std::vector<double> measure_pixel_noise(const HdrImage& reference, const HdrImage& standard_error,
                                        const ToneCurve& tone) {
  std::vector<double> noise(reference.pixel_count());
  for (std::size_t i = 0; i < noise.size(); ++i) {
    std::array<float, 3> low{}, high{};
    for (std::size_t c = 0; c < 3; ++c) {
      low[c] = std::max(0.0f, reference.pixel(i)[c] - standard_error.pixel(i)[c]);
      high[c] = reference.pixel(i)[c] + standard_error.pixel(i)[c];
    }
    const auto below = eval_display(tone, i, low.data()), above = eval_display(tone, i, high.data());
    for (std::size_t c = 0; c < 3; ++c) noise[i] = std::max(noise[i], (above[c] - below[c]) / 2);
  }
  return noise;
}

LdrImage show_noise(const std::vector<double>& noise, int width, int height) {
  LdrImage shown(width, height);
  for (std::size_t i = 0; i < shown.values.size(); ++i)
    shown.values[i] = static_cast<std::uint8_t>(std::min(255.0, 51 * noise[i / 3]));
  return shown;
}

DisplayNoise measure_display_noise(const HdrImage& reference, const HdrImage& standard_error,
                                   const HdrImage& coverage, const ToneCurve& tone) {
  const std::vector<double> noise = measure_pixel_noise(reference, standard_error, tone);
  std::vector<double> object, outside;
  for (std::size_t i = 0; i < noise.size(); ++i)
    (coverage.values[i] > 0 ? object : outside).push_back(noise[i]);
  return {mean_of(object), nearest_rank(object, 0.99), mean_of(outside)};
}

bool meets_target(const DisplayNoise& noise, const NoiseTarget& target) {
  return noise.object_mean <= target.object_mean && noise.object_p99 <= target.object_p99 &&
         noise.outside_mean <= target.outside_mean;
}

HdrImage normalise_luminance(const HdrImage& clamped, const HdrImage& unclamped) {
  const double have = mean_luminance(clamped), want = mean_luminance(unclamped);
  if (!(have > 0)) return clamped;
  HdrImage scaled = clamped;
  for (float& value : scaled.values) value = static_cast<float>(value * (want / have));
  return scaled;
}

}  // namespace equilux
