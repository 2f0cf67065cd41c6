// Instruction sets of the kernels: one is chosen at the start, and the same bytes come of it on every
// machine.
#pragma once

#include <string>

namespace equilux {

enum class Isa {
  kV3,  ///< x86-64-v3, AVX2
  kV4   ///< x86-64-v4, AVX-512
};

std::string format_isa(Isa isa);

/// "v3" or "v4". errors: InputError that names `where` for any other text
Isa parse_isa(const std::string& text, const std::string& where);

bool has_isa(Isa isa);

/// The best that the processor has, or the one that was fixed.
Isa current_isa();

/// Before the first world is made: Embree's kernels follow. errors: InputError if the processor lacks it.
void fix_isa(Isa isa);

}  // namespace equilux
