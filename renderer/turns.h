// What becomes of renderings that missed their noise target: to an object another is added, a room is
// exchanged.
#pragma once

#include "renderer/reference.h"

namespace equilux {

/// So much less than the target is what is made after a miss meant to err by.
inline constexpr double kTurnMargin = 1.1;

/// A rendering to be added: its target over the whole's, and its weight in the mean of both.
struct Addition {
  double target = 1, share = 1;
};

/// Such that the mean errs by as much less than the target as kTurnMargin says: weights go by one over
/// variance, as far as it is foreseen. `miss`: error over target, more than 1
Addition find_addition(double miss);

/// An independent rendering of the same object beside the same room, whose error both have. Regions are mixed
/// where both have some, which must be the same ones.
void add_turn(FamilyLayers& layers, FamilyLayers other, const TracedLayer& room, double share);

/// Another room in place of the one that is in it, each with its standard error.
void exchange_room(FamilyLayers& layers, const TracedLayer& before, const TracedLayer& after);

}  // namespace equilux
