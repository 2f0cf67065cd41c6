// Points and VPLs in the café, to hold cuts to the plain sum.
#pragma once

#include <string>
#include <vector>

#include "renderer/lightcut.h"
#include "tests/renderer/test_scene.h"

namespace equilux::test {

inline const std::vector<double> kAllClamps = [] {
  std::vector<double> clamps;
  for (int level = 0; level < kClampLevelCount; ++level) clamps.push_back(clamp_per_m2(level));
  return clamps;
}();

struct Cafe {
  Scene scene = load_scene(std::filesystem::path(EQUILUX_SOURCE_DIR) / "stimuli/scenes/cafe.json");
  World world;
  std::vector<Material> materials;
  std::vector<ShadingPoint> points;
  VplList vpls;

  // Of what the camera sees every `stride`-th point, and about `count` VPLs.
  Cafe(const std::string& geometry, std::size_t stride, std::int64_t paths, Emission emission,
       std::vector<std::string> names = {"MS", "MR", "GS", "LG"},
       Illumination illumination = Illumination::kDirectAndIndirect)
      : world(make_world(scene, geometry, illumination)) {
    for (const std::string& name : names) materials.push_back(make_material(find_material(scene, name)));
    const auto all = find_shading_points(trace_primary(world, make_view_camera(scene, 0), 112, 84, 1));
    for (std::size_t i = 0; i < all.size(); i += stride) points.push_back(all[i]);
    const Materials traced = make_materials(world, find_material(scene, "MS"));
    const VplSet set = trace_vpls(world, traced, paths, 1, "lightcut-test", emission);
    vpls = set.shared;
    vpls.append(set.own);
  }

  ShadedPoints sum(const std::vector<double>& clamps) const {
    return shade_all_vpls(world, points, vpls, materials, clamps, [](double) {});
  }
  ShadedPoints cut(decltype(&shade_lightcut) shade, const std::vector<double>& clamps, double ratio,
                   std::uint64_t seed, CutRecord* record = nullptr, int leaf_size = 1) const {
    const LightTree tree = make_light_tree(vpls, {seed, leaf_size});
    return shade(world, points, tree, materials, clamps, {ratio, 1e-5}, record);
  }
};

}  // namespace equilux::test
