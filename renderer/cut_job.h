// What all cuts of one call share, and the points of one group.
#pragma once

#include <vector>

#include "renderer/lane_bounds.h"
#include "renderer/lightcut.h"

// After all other headers.
// clang-format off
#include "renderer/isa_begin.h"
// clang-format on

namespace equilux::EQ_ISA {

struct CutJob {
  const World& world;
  const std::vector<ShadingPoint>& points;
  const LightTree& tree;
  const std::vector<Material>& materials;
  std::vector<Lobe> lobes;           // of all glossy materials, each once
  std::vector<std::size_t> lobe_of;  // each material's, if it is glossy
  bool grey;                         // all materials are: their light differs by one factor
  std::vector<float> clamps_per_m2;
  std::size_t levels;
  const LightcutParams& params;
  const std::vector<std::uint32_t>& top;
};

// The samples of a pixel, again in every slot.
struct GroupPoints {
  LanePoint lanes{};
  Floats3 ng{}, origins{};
};

}  // namespace equilux::EQ_ISA

#include "renderer/isa_end.h"
