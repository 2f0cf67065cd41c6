// The kernels, once for each instruction set. Only what chooses between them includes this.
#pragma once

#include "renderer/isa.h"
#include "renderer/lightcut.h"
#include "renderer/node_bounds.h"
#include "renderer/shade.h"

#define EQ_DECLARE_KERNELS(isa)                                                                             \
  namespace equilux::isa {                                                                                  \
  ShadedPoints shade_all_vpls(const World& world, const std::vector<ShadingPoint>& points,                  \
                              const VplList& vpls, const std::vector<Material>& materials,                  \
                              const std::vector<double>& clamps_per_m2,                                     \
                              const std::function<void(double)>& progress, const ShadowRoulette& roulette); \
  ShadedPoints shade_lightcut(const World& world, const std::vector<ShadingPoint>& points,                  \
                              const LightTree& tree, const std::vector<Material>& materials,                \
                              const std::vector<double>& clamps_per_m2, const LightcutParams& params,       \
                              CutRecord* record);                                                           \
  NodeBounds bound_nodes(const LightTree& tree, const Material& material, const BoundPoint& point,          \
                         const std::uint32_t* ids, std::size_t count);                                      \
  }

EQ_DECLARE_KERNELS(v3)
EQ_DECLARE_KERNELS(v4)
