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

/// PictureRecord::reference: how a family's object and room were made; null where nothing is known. shape of
/// `layers`: with the family's
Json tell_picture_reference(const LayerRecords& layers, const Family& family);

/// PictureRecord::vpls: what is known of the VPL layer that a picture shows, before any normalisation; else
/// null. shape of `layers`: with that layer
Json tell_picture_vpls(const LayerRecords& layers, const Condition& condition);

}  // namespace equilux
