// Sums of layers through the family's tone curve.
#include "renderer/compose.h"

#include <cmath>

#include "base/error.h"
#include "base/memory.h"
#include "stimuli/layers.h"

namespace equilux {
namespace {
namespace fs = std::filesystem;

// Of a pixel: six layers, two sums, the values that the curve is made of and, of the local operator, blurs;
// of a picture its layers, their sum, its pixels and what it is compared with.
constexpr std::uint64_t kBytesOfFamily = 180, kBytesOfPicture = 60;

std::uint64_t count_pixels(const Study& study) {
  return static_cast<std::uint64_t>(study.width) * static_cast<std::uint64_t>(study.height);
}

template <typename Allowed>
void check_values(const HdrImage& image, const fs::path& source, const char* expected,
                  const Allowed& allowed) {
  for (std::size_t i = 0; i < image.values.size(); ++i) {
    if (allowed(image.values[i])) continue;
    const std::size_t pixel = i / static_cast<std::size_t>(image.channels);
    const auto width = static_cast<std::size_t>(image.width);
    throw InputError(source.string(), fmt::format("pixel ({}, {})", pixel % width, pixel / width), expected,
                     fmt::format("{}", image.values[i]));
  }
}

// There is no light below nothing, and no logarithm of it.
HdrImage load_light(const LayerStore& store, const std::string& name) {
  HdrImage layer = store.load(name);
  check_values(layer, store.folder().root / store.record(name).file, "a value of 0 or more",
               [](float value) { return value >= 0; });
  return layer;
}

// Finite layers may add up to what no float holds.
HdrImage add_layers(const std::vector<const HdrImage*>& layers, const fs::path& source,
                    const char* expected) {
  HdrImage sum = composite(layers);
  check_values(sum, source, expected, [](float value) { return std::isfinite(value); });
  return sum;
}

}  // namespace

std::uint64_t estimate_family_memory(const Study& study) { return kBytesOfFamily * count_pixels(study); }

std::uint64_t estimate_picture_memory(const Study& study) { return kBytesOfPicture * count_pixels(study); }

void with_family_memory(const StudyFolder& folder, const Study& study, const std::function<void()>& body) {
  with_memory(fmt::format("{}: pictures of {} x {} pixels", folder.root.string(), study.width, study.height),
              estimate_family_memory(study), body);
}

LoadedFamily load_family(const Study& study, const LayerStore& store, const Family& family) {
  const auto load = [&](const char* content) { return load_light(store, layer_name(family, content)); };
  LoadedFamily loaded;
  loaded.layer_folder = store.folder().layer_folder();
  loaded.background = load("background");
  loaded.coverage = load("coverage");
  loaded.direct = load("direct");
  loaded.indirect = load("indirect");
  loaded.standard_error = load("standard_error");
  const fs::path source = loaded.layer_folder / (format_key(family) + ".*.exr");
  loaded.base =
      add_layers({&loaded.background, &loaded.direct}, source, "a finite sum of background and direct");
  const HdrImage reference =
      add_layers({&loaded.base, &loaded.indirect}, source, "a finite sum of background, direct and indirect");
  add_layers({&reference, &loaded.standard_error}, source, "a finite sum with the standard error");
  loaded.tone = make_tone_curve(reference, loaded.coverage, study.tone);
  loaded.noise = measure_display_noise(reference, loaded.standard_error, loaded.coverage, loaded.tone);
  return loaded;
}

HdrImage load_vpl_layer(const LayerStore& store, Condition condition) {
  HdrImage layer = load_light(store, vpl_layer_name(condition));
  if (!condition.cell.normalised) return layer;
  condition.cell.clamp_level = 0;
  return normalise_luminance(layer, load_light(store, vpl_layer_name(condition)));
}

LdrImage compose_picture(const LoadedFamily& family, const HdrImage& indirect, const std::string& layer) {
  const HdrImage sum = add_layers({&family.base, &indirect}, family.layer_folder / (layer + ".exr"),
                                  "a finite sum with its reference's background and direct");
  return apply_tone_curve(sum, family.tone);
}

}  // namespace equilux
