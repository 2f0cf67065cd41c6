// The last step of a set: pictures of whole layers.
#pragma once

#include "renderer/layer_store.h"
#include "renderer/set.h"
#include "renderer/wanted.h"

namespace equilux {

/// Tone-maps what is wanted and not whole, and writes the manifest; adds to the summary its pictures, errors,
/// warnings and seconds. errors: InputError for a layer that is missing or damaged, or where a picture that
/// may have been shown would change; StoreError; WorkCancelled
void tonemap_wanted(const Study& study, const StudyFolder& folder, const LayerStore& store,
                    const Wanted& wanted, SetSummary& summary);

}  // namespace equilux
