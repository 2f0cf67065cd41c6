// What layers.json tells of a reference: how it was made, by how much, and what its check found.
#pragma once

#include "base/json.h"
#include "renderer/reference.h"

namespace equilux {

/// Of a reference's indirect light; radiances of its regions in W/(m^2 sr).
Json tell_reference(const FamilyLayers& layers);

/// Of its room; null where that was path traced alone.
Json tell_room(const FamilyLayers& layers);

}  // namespace equilux
