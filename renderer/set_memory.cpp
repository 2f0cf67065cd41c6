// By pixels, materials and VPLs.
#include "renderer/set_memory.h"

#include <algorithm>
#include <fmt/format.h>
#include <set>
#include <string>

#include "base/memory.h"
#include "renderer/primary.h"
#include "renderer/vpl.h"

namespace equilux {
namespace {

// Of a pixel where there are cuts: the layers that the floor of their error comes from, and the curve's
// values.
constexpr std::uint64_t kBytesOfFloor = 76;

// Of a pixel and material: layers of five kinds, with the sums that their errors come from.
constexpr std::uint64_t kBytesOfMaterial = 190;

// What a view's pixels and the layers of its materials take at least.
std::uint64_t estimate_view_memory(const Study& study) {
  std::set<std::string> materials;
  for (const Block& block : study.blocks) materials.insert(block.materials.begin(), block.materials.end());
  const auto pixels = static_cast<std::uint64_t>(study.width) * static_cast<std::uint64_t>(study.height);
  return pixels * (static_cast<std::uint64_t>(study.subpixel_positions) * sizeof(PrimaryHit) +
                   kBytesOfMaterial * materials.size() + kBytesOfFloor);
}

}  // namespace

void check_memory(const Study& study, const Wanted& missing) {
  const auto nothing = [] {};
  with_memory(fmt::format("pictures of {} x {} pixels, {} positions each", study.width, study.height,
                          study.subpixel_positions),
              estimate_view_memory(study), nothing);
  std::int64_t most = 0;
  for (const Condition& condition : missing.conditions)
    most = std::max(most, condition.cell.column.vpl_count);
  with_vpl_memory(most, nothing);
}

}  // namespace equilux
