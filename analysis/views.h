// Whether one camera shows what the other does not.
#pragma once

#include <array>
#include <optional>

#include "analysis/evidence.h"

namespace equilux {

/// Correct answers of the finished sessions by the view of the test picture, v0 and v1; empty without
/// answers, and where the view of any is not known.
std::optional<std::array<Count, 2>> count_by_view(const ExperimentEvidence& evidence);

}  // namespace equilux
