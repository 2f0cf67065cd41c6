// What pictures were made from, by the records alone: no layer is read.
#pragma once

#include <map>
#include <string>

#include "stimuli/layers.h"
#include "stimuli/manifest.h"

namespace equilux {

using LayerRecords = std::map<std::string, LayerRecord>;

/// PictureRecord::made_from of a reference: digest of its family's layers and of its tone curve. Layers that
/// are not recorded count as none.
std::string digest_reference(const LayerRecords& layers, const ToneRecord& tone, const Family& family);

/// The same of a VPL picture, whose layers are more.
std::string digest_picture(const LayerRecords& layers, const ToneRecord& tone, const Condition& condition);

}  // namespace equilux
