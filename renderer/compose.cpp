// Sums of layers through the family's tone curve.
#include "renderer/compose.h"

#include <fmt/format.h>

#include "base/digest.h"
#include "renderer/local_tone.h"
#include "renderer/wanted.h"

namespace equilux {
namespace {

// Of what load_vpl_layer loads.
std::string vpl_digests(const LayerStore& store, Condition condition) {
  std::string digests = store.record(vpl_layer_name(condition)).digest;
  if (condition.cell.normalised) {
    condition.cell.clamp_level = 0;
    digests += " normalised to " + store.record(vpl_layer_name(condition)).digest;
  }
  return digests;
}

}  // namespace

LoadedFamily load_family(const Study& study, const LayerStore& store, const Family& family) {
  const auto load = [&](const char* content) { return store.load(layer_name(family, content)); };
  LoadedFamily loaded{load("background"),
                      load("coverage"),
                      load("direct"),
                      load("indirect"),
                      load("standard_error"),
                      {},
                      {},
                      {},
                      {}};
  loaded.base = composite({&loaded.background, &loaded.direct});
  const HdrImage reference = composite({&loaded.base, &loaded.indirect});
  loaded.tone = make_tone_curve(reference, loaded.coverage, study.tone);
  loaded.noise = measure_display_noise(reference, loaded.standard_error, loaded.coverage, loaded.tone);
  for (const char* content : kFamilyContents)
    loaded.digests += store.record(layer_name(family, content)).digest + " ";
  const ToneRecord& tone = loaded.tone.record;
  loaded.digests +=
      fmt::format("{} {} {} {} {}", tone.log_average, tone.white, tone.delta, tone.key, tone.exposure);
  if (study.tone.operation == ToneOperator::kLocal)
    loaded.digests += fmt::format(" local {}", kLocalToneVersion);
  return loaded;
}

HdrImage load_vpl_layer(const LayerStore& store, Condition condition) {
  HdrImage layer = store.load(vpl_layer_name(condition));
  if (!condition.cell.normalised) return layer;
  condition.cell.clamp_level = 0;
  return normalise_luminance(layer, store.load(vpl_layer_name(condition)));
}

std::string digest_reference(const LoadedFamily& family) { return digest_text(family.digests); }

std::string digest_picture(const LoadedFamily& family, const LayerStore& store, const Condition& condition) {
  return digest_text(family.digests + " " + vpl_digests(store, condition));
}

LdrImage compose_picture(const LoadedFamily& family, const HdrImage& indirect) {
  return apply_tone_curve(composite({&family.base, &indirect}), family.tone);
}

}  // namespace equilux
