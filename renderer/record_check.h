// What the records of a set's layers say against them.
#pragma once

#include <string>
#include <vector>

#include "stimuli/layers.h"

namespace equilux {

/// Of a VPL layer whose study asks for certified cuts: that they are not. Else empty.
std::string find_uncertified(const LayerRecord& layer);

/// Of a reference by VPL sets, from the record of its indirect light or of its background: regions whose mean
/// is further from their path-traced check than chance explains.
std::vector<std::string> find_failed_checks(const LayerRecord& layer);

}  // namespace equilux
