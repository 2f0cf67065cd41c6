// What all cuts of one call share, and the points of one group.
#pragma once

#include <algorithm>
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

inline void add_material(const Material& material, CutJob& job) {
  const auto is_grey = [](Vec3 colour) { return colour.x == colour.y && colour.y == colour.z; };
  job.grey = job.grey && is_grey(material.rho_d) && is_grey(material.rho_s);
  if (material.glossy_share == 0) return job.lobe_of.push_back(0);
  const Lobe lobe{material.model, material.alpha};
  const auto found = std::find(job.lobes.begin(), job.lobes.end(), lobe);
  job.lobe_of.push_back(static_cast<std::size_t>(found - job.lobes.begin()));
  if (found == job.lobes.end()) job.lobes.push_back(lobe);
}

// The samples of a pixel, again in every slot.
struct GroupPoints {
  LanePoint lanes{};
  Floats3 ng{}, origins{};
};

}  // namespace equilux::EQ_ISA

#include "renderer/isa_end.h"
