// What rendering a set needs of memory.
#pragma once

#include "protocols/study.h"
#include "renderer/wanted.h"

namespace equilux {

/// Asks for what the largest pictures and VPL sets need at least: what is not there is said before hours of
/// work, not after. errors: InputError
void check_memory(const Study& study, const Wanted& missing);

}  // namespace equilux
