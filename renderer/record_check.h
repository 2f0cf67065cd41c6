// What the records of a set's layers say against them.
#pragma once

#include <string>
#include <vector>

#include "protocols/study.h"
#include "stimuli/layers.h"

namespace equilux {

/// Of a VPL layer that says that its cuts are not certified, or says nothing where they are `wanted`. Else
/// empty.
std::string find_uncertified(const LayerRecord& layer, bool wanted = false);

/// Of the indirect light of a reference: that it is said to be by VPL sets without a check, or, where the
/// study asks for VPL sets, that nothing is said. Else empty.
std::string find_unchecked(const LayerRecord& layer, const Study& study);

/// Of a reference by VPL sets, from the record of its indirect light or of its background: regions whose mean
/// is further from their path-traced check than chance explains.
std::vector<std::string> find_failed_checks(const LayerRecord& layer);

/// Regions of path-traced checks; in the unsure ones the paths met the light so rarely that no difference
/// could have been found.
struct CheckedRegions {
  std::size_t all = 0, unsure = 0;
};
CheckedRegions count_checked_regions(const LayerRecord& layer);

}  // namespace equilux
