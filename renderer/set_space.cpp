// By pixels that are not black.
#include "renderer/set_space.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/memory.h"
#include "stimuli/layers.h"

namespace equilux {
namespace {

constexpr double kBytesOfPixel = 12;          // of a layer: three floats, of noise
constexpr double kBytesOfPicturePixel = 1.3;  // of a PNG picture of the café
constexpr double kBytesOfFile = 4096;         // its head, and the rest of its last block

}  // namespace

std::uint64_t estimate_set_bytes(const Study& study, const std::map<WorldKey, WorldCosts>& costs,
                                 const Wanted& wanted) {
  const double pixels = static_cast<double>(study.width) * study.height;
  const auto object_of = [&](const Object& object) {
    return kBytesOfPixel * costs.at(world_of(object)).points / study.subpixel_positions;
  };
  double bytes = 0;
  for (const Family& family : wanted.families)  // the room, two kinds of light, the error everywhere
    bytes +=
        2 * kBytesOfPixel * pixels + object_of(family.object) + std::size(kFamilyContents) * kBytesOfFile;
  for (const Condition& condition : wanted.conditions)
    bytes += object_of(condition.cell.column.object) + kBytesOfFile;
  const auto pictures = static_cast<double>(wanted.families.size() + wanted.conditions.size());
  return static_cast<std::uint64_t>(bytes + pictures * (kBytesOfPicturePixel * pixels + kBytesOfFile));
}

void check_space(const std::filesystem::path& folder, std::uint64_t bytes) {
  std::error_code unknown;
  const std::filesystem::space_info space = std::filesystem::space(folder, unknown);
  if (unknown || space.available >= bytes) return;
  throw InputError(folder.string(), "", fmt::format("about {} free on its disk", format_bytes(bytes)),
                   fmt::format("{}; what is rendered already stays", format_bytes(space.available)));
}

}  // namespace equilux
