// What a session's fields mean: a line for each name that this program gives one.
#pragma once

#include <vector>

#include "experiment/export_columns.h"

namespace equilux {

/// By name, sorted. Fields of other programs, which a merge may bring in, have none.
const std::vector<ColumnNote>& field_notes();

}  // namespace equilux
