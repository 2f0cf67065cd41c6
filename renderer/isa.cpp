#include "renderer/isa.h"

#include <atomic>

#include "base/error.h"

namespace equilux {
namespace {

Isa find_best() { return has_isa(Isa::kV4) ? Isa::kV4 : Isa::kV3; }

std::atomic<Isa>& chosen() {
  static std::atomic<Isa> isa = find_best();
  return isa;
}

}  // namespace

std::string format_isa(Isa isa) { return isa == Isa::kV4 ? "v4" : "v3"; }

Isa parse_isa(const std::string& text, const std::string& where) {
  if (text == "v3") return Isa::kV3;
  if (text == "v4") return Isa::kV4;
  throw InputError(where, "", "v3 or v4", text);
}

bool has_isa(Isa isa) {
  __builtin_cpu_init();
  const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  if (isa == Isa::kV3) return v3;
  return v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
         __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512vl");
}

Isa current_isa() { return chosen(); }

void fix_isa(Isa isa) {
  if (!has_isa(isa)) throw InputError("instruction set", "", "one that this processor has", format_isa(isa));
  chosen() = isa;
}

}  // namespace equilux
