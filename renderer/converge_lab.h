// One condition's world, camera and reference, and the parts of its error. Only converge*.cpp include this.
#pragma once

#include <vector>

#include "renderer/converge.h"
#include "renderer/converge_error.h"
#include "renderer/converge_run.h"

namespace equilux {

/// What all ladders share.
struct Laboratory {
  const ConvergeParams& params;
  World world;
  Materials materials;
  Primary primary;
  std::vector<ShadingPoint> points;

  Laboratory(const Scene& scene, const ConvergeParams& converge)
      : params(converge),
        world(make_world(scene, object().geometry, object().illumination)),
        materials(make_materials(world, find_material(scene, object().material))),
        primary(trace_primary(world, make_view_camera(scene, converge.condition.view), converge.width,
                              converge.height, converge.positions)),
        points(find_shading_points(primary)) {}

  const Object& object() const { return params.condition.cell.column.object; }
  std::int64_t vpls() const { return params.condition.cell.column.vpl_count; }
  int level() const { return params.condition.cell.clamp_level; }
  std::uint64_t seed(int run) const { return params.seed + static_cast<std::uint64_t>(run); }
  FamilyScene family() const { return {world, materials, primary}; }
  /// The fewest paths that a pixel can take.
  int least_paths() const { return kBatches * params.positions; }
  LitScene lit(double floor) const { return {world, materials, primary, points, params.emission, floor}; }
};

/// What each cause does by itself to the condition's own picture, and all of them together.
std::vector<ErrorPart> measure_parts(const Laboratory& lab, const ReferenceTruth& truth,
                                     const LitScene& scene);

}  // namespace equilux
