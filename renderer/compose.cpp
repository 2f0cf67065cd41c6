// Sums of layers through the family's tone curve.
#include "renderer/compose.h"

#include "stimuli/layers.h"

namespace equilux {
LoadedFamily load_family(const Study& study, const LayerStore& store, const Family& family) {
  const auto load = [&](const char* content) { return store.load(layer_name(family, content)); };
  LoadedFamily loaded{load("background"),
                      load("coverage"),
                      load("direct"),
                      load("indirect"),
                      load("standard_error"),
                      {},
                      {},
                      {}};
  loaded.base = composite({&loaded.background, &loaded.direct});
  const HdrImage reference = composite({&loaded.base, &loaded.indirect});
  loaded.tone = make_tone_curve(reference, loaded.coverage, study.tone);
  loaded.noise = measure_display_noise(reference, loaded.standard_error, loaded.coverage, loaded.tone);
  return loaded;
}

HdrImage load_vpl_layer(const LayerStore& store, Condition condition) {
  HdrImage layer = store.load(vpl_layer_name(condition));
  if (!condition.cell.normalised) return layer;
  condition.cell.clamp_level = 0;
  return normalise_luminance(layer, store.load(vpl_layer_name(condition)));
}

LdrImage compose_picture(const LoadedFamily& family, const HdrImage& indirect) {
  return apply_tone_curve(composite({&family.base, &indirect}), family.tone);
}

}  // namespace equilux
