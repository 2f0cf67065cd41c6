// From the layers of a family to its pictures.
#pragma once

#include <cstdint>
#include <functional>

#include "renderer/layer_store.h"
#include "renderer/tone.h"

namespace equilux {

/// The layers of a family, loaded once for all its pictures. `base` is background and direct light.
struct LoadedFamily {
  std::filesystem::path layer_folder;
  HdrImage background, coverage, direct, indirect, standard_error, base;
  ToneCurve tone;
  DisplayNoise noise;
};

/// What a family takes while it is loaded, with a picture of its in the making; what each picture takes
/// beside it. units: bytes
std::uint64_t estimate_family_memory(const Study& study);
std::uint64_t estimate_picture_memory(const Study& study);

/// Runs `body` if there is room for a family. errors: InputError that names folder and size of pictures, also
/// where an allocation fails on the way
void with_family_memory(const StudyFolder& folder, const Study& study, const std::function<void()>& body);

/// errors: InputError for a layer that is missing or damaged or has a value below 0, and for a sum that is
/// not finite
LoadedFamily load_family(const Study& study, const LayerStore& store, const Family& family);

/// The object's indirect light of a VPL picture, normalised where the condition is. errors: as load_family
HdrImage load_vpl_layer(const LayerStore& store, Condition condition);

/// The picture of a family with the indirect light of this layer. errors: InputError for a sum that is not
/// finite
LdrImage compose_picture(const LoadedFamily& family, const HdrImage& indirect, const std::string& layer);

}  // namespace equilux
