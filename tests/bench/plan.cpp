// What each omission of the plan gains: with and without it, turn by turn, in one run.
#include "renderer/plan.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fmt/format.h>
#include <functional>
#include <memory>
#include <set>
#include <vector>

#include "renderer/compensation.h"
#include "renderer/lightcut.h"
#include "renderer/lights.h"
#include "renderer/reference.h"
#include "renderer/set.h"
#include "renderer/vpl_sets.h"
#include "tests/bench/bench.h"
#include "tests/renderer/tiny_study.h"

namespace equilux {
namespace {

using bench::all_levels;
using bench::time_s;

constexpr int kTurns = 5;
constexpr const char* kStudyMaterials[] = {"MS", "MR", "BS", "BR", "GS"};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + kTurns / 2, values.end());
  return values[kTurns / 2];
}

void print_row(const char* what, const char* measured, const std::function<void()>& with,
               const std::function<void()>& without) {
  std::vector<double> left_out, kept;
  for (int turn = 0; turn < kTurns; ++turn) {
    left_out.push_back(time_s(with));
    kept.push_back(time_s(without));
  }
  const double a = median(left_out), b = median(kept);
  fmt::print("| {} | {} | {:.3g} | {:.3g} | {:.2f} |\n", what, measured, a, b, b / a);
  std::fflush(stdout);
}

const Scene& cafe() {
  static const Scene scene = load_scene(EQUILUX_SOURCE_DIR "/stimuli/scenes/cafe.json");
  return scene;
}

struct Stage {
  World world;
  Materials materials;
  Primary primary;
  std::vector<ShadingPoint> points;

  Stage(const char* material, Illumination illumination, const WorldParams& params = {}, int width = 140)
      : world(make_world(cafe(), "G2", illumination, params)),
        materials(make_materials(world, find_material(cafe(), material))),
        primary(trace_primary(world, make_view_camera(cafe(), 0), width, width * 3 / 4, 2)),
        points(find_shading_points(primary)) {}

  FamilyScene family() const { return {world, materials, primary}; }
  VplList trace(std::int64_t count) const {
    VplSet set = trace_vpls(world, materials, find_path_count(world, count, 1), 1, "bench");
    VplList list = std::move(set.shared);
    list.append(set.own);
    return list;
  }
  void trace_layers(const PathCounts& paths) const {
    equilux::trace_layers(family(), make_fixed_maps(primary, paths), 1, "bench", {}, [](double) {});
  }
};

void cut(const Stage& stage, const LightTree& tree, const Material& material,
         const std::vector<double>& clamps) {
  shade_lightcut(stage.world, stage.points, tree, {material}, clamps, {0.0075, 1e-4});
}

void sum(const Stage& stage, const VplList& list, const Material& material,
         const std::vector<double>& clamps) {
  shade_all_vpls(stage.world, stage.points, list, {material}, clamps, [](double) {});
}

Material force_lobe(Material material) {
  material.glossy_share = 1e-30f;
  material.alpha = 0.15f;
  return material;
}

// What is measured of the object's glossy lobe.
struct LobeWork {
  const char* name;
  const char* measured;
  std::function<void(const Material&)> run;
};

std::vector<LobeWork> list_lobe_work(const Stage& stage, const VplList& few, const LightTree& tree) {
  const auto totals = std::make_shared<const ShadedPoints>(shade_lightcut(
      stage.world, stage.points, tree, {stage.materials[0]}, {clamp_per_m2(8)}, {0.0075, 1e-4}));
  return {
      {"sum", "plain sum of 1k, LG",
       [&](const Material& material) { sum(stage, few, material, all_levels()); }},
      {"cuts", "cuts of 1M, LG", [&](const Material& material) { cut(stage, tree, material, all_levels()); }},
      {"set", "a set's cuts of 1M at 1 %, LG, C8",
       [&stage, &tree, totals](const Material& material) {
         shade_lightcut(stage.world, stage.points, tree, {material}, {clamp_per_m2(8)},
                        make_set_rule(0.01, 1e-4, *totals, 1, "bench"));
       }},
      {"paths", "indirect light, LG, 64 paths a pixel", [&](const Material& material) {
         Materials materials = stage.materials;
         materials[0] = material;
         equilux::trace_layers({stage.world, materials, stage.primary},
                               make_fixed_maps(stage.primary, {0, 0, 64}), 1, "bench", {}, [](double) {});
       }}};
}

void compare_lobe() {
  const Stage stage("LG", Illumination::kIndirect);
  const Material plain = stage.materials[0], forced = force_lobe(plain);
  const VplList few = stage.trace(1000);
  const LightTree tree = make_light_tree(stage.trace(1000000), {1, 4});
  const char* what = "the object's glossy lobe";
  for (const LobeWork& work : list_lobe_work(stage, few, tree)) {
    print_row(
        what, work.measured, [&] { work.run(plain); }, [&] { work.run(forced); });
    what = "";
  }
}

// For a profiler that counts instructions: gains of a hundredth do not show in times.
void run_lobe_once(const std::string& name, bool with_lobe) {
  const Stage stage("LG", Illumination::kIndirect, {}, 48);
  const VplList few = stage.trace(1000);
  const LightTree tree = make_light_tree(stage.trace(100000), {1, 4});
  const Material material = with_lobe ? force_lobe(stage.materials[0]) : stage.materials[0];
  for (const LobeWork& work : list_lobe_work(stage, few, tree)) {
    if (work.name == name) work.run(material);
  }
}

void compare_emission() {
  const Stage stage("MS", Illumination::kIndirect);
  VplList list = stage.trace(1000000), forced(list);
  forced.gloss.push_back({{0, 0, 1}, {0, 0, 1}, {}, 0.1f, GlossModel::kWardDuer});
  const LightTree tree = make_light_tree(std::move(list), {1, 4}),
                  forced_tree = make_light_tree(std::move(forced), {1, 4});
  print_row(
      "emission directions of VPLs", "cuts of 1M, MS",
      [&] { cut(stage, tree, stage.materials[0], all_levels()); },
      [&] { cut(stage, forced_tree, stage.materials[0], all_levels()); });
  print_row(
      "clamp levels that are not asked for", "cuts of 1M, MS, C0 alone or all eleven",
      [&] { cut(stage, tree, stage.materials[0], {all_levels()[0]}); },
      [&] { cut(stage, tree, stage.materials[0], all_levels()); });
  print_row(
      "a traversal for each clamp level", "cuts of 1M, MS",
      [&] { cut(stage, tree, stage.materials[0], all_levels()); },
      [&] {
        for (const double clamp : all_levels()) cut(stage, tree, stage.materials[0], {clamp});
      });
}

void compare_lights() {
  const Stage with("MS", Illumination::kIndirect), without("MS", Illumination::kIndirect, {false});
  print_row(
      "direct light of the object", "direct layer, ind, 16 x 2 samples a pixel",
      [&] {
        with.trace_layers({0, 32, 0});
      },
      [&] {
        without.trace_layers({0, 32, 0});
      });
  print_row(
      "spots out of reach", "background and indirect light, 64 paths a pixel",
      [&] {
        with.trace_layers({64, 0, 64});
      },
      [&] {
        without.trace_layers({64, 0, 64});
      });
  // Without: what was done before, sixteen evaluations of the same.
  print_row(
      "sampling of direct light", "direct light at every point, ind, all spots asked",
      [&] {
        PathSampler sampler{RandomStream(1, "bench", 0)};
        for (const ShadingPoint& point : without.points)
          estimate_direct(without.world, without.materials, point.surface, point.v, sampler);
      },
      [&] {
        PathSampler sampler{RandomStream(1, "bench", 0)};
        for (const ShadingPoint& point : without.points) {
          for (int batch = 0; batch < kBatches; ++batch)
            estimate_direct(without.world, without.materials, point.surface, point.v, sampler);
        }
      });
}

void compare_tree() {
  const Stage stage("MS", Illumination::kIndirect);
  const VplList list = stage.trace(1000);
  std::vector<Material> materials;
  for (const char* name : kStudyMaterials) materials.push_back(make_material(find_material(cafe(), name)));
  print_row(
      "the light tree", "five materials by one sum of 1k, or by cuts of each",
      [&] { shade_all_vpls(stage.world, stage.points, list, materials, all_levels(), [](double) {}); },
      [&] {
        const LightTree tree = make_light_tree(VplList(list), {1, 4});
        for (const Material& material : materials) cut(stage, tree, material, all_levels());
      });
  print_row(
      "", "one material", [&] { sum(stage, list, materials[0], all_levels()); },
      [&] {
        cut(stage, make_light_tree(VplList(list), {1, 4}), materials[0], all_levels());
      });
}

void compare_sharing() {
  const Stage stage("MS", Illumination::kIndirect);
  std::vector<Materials> materials;
  for (const char* name : kStudyMaterials)
    materials.push_back(make_materials(stage.world, find_material(cafe(), name)));
  const std::int64_t paths = find_path_count(stage.world, 1000000, 1);
  print_row(
      "particles again for each material", "1M VPLs for five materials",
      [&] {
        const VplSet first = trace_vpls(stage.world, materials[0], paths, 1, "bench");
        for (std::size_t i = 1; i < materials.size(); ++i)
          trace_own_vpls(stage.world, materials[i], first, 1, "bench");
      },
      [&] {
        for (const Materials& one : materials) trace_vpls(stage.world, one, paths, 1, "bench");
      });
  const PathMap map(stage.primary.hits.size() / 2, 2);
  const PathMeasures measures;
  const BatchJob job{make_background_key(1, "bench"), map, measures};
  const auto trace = [&](std::span<const Materials> some) {
    trace_backgrounds(stage.world, some, stage.primary, job, "bench", [](double) {});
  };
  print_row(
      "the background's paths again for each material", "five materials, 64 paths a pixel",
      [&] { trace(materials); },
      [&] {
        for (const Materials& one : materials) trace({&one, 1});
      });
  const auto grow = [&] { make_light_tree(stage.trace(1000000), {1, 4}); };
  print_row("VPLs and trees again for each view", "1M VPLs for two views", grow, [&] {
    grow();
    grow();
  });
}

void compare_rays() {
  const Stage stage("LG", Illumination::kIndirect);
  const PathMap map(stage.primary.hits.size() / 2, 2);
  const auto trace = [&](std::vector<double> clamps) {
    trace_compensation(stage.family(), map, {std::move(clamps), Emission::kFull, 1, "bench", {}},
                       [](double) {});
  };
  print_row(
      "long rays of compensation", "LG, C4, 64 paths a pixel", [&] { trace({clamp_per_m2(4)}); },
      [&] {
        trace({clamp_per_m2(4), 1e-12});
      });
}

// With it: what is read and made of every mesh that the scene names, as one file for all conditions would.
void compare_parts() {
  const std::set<std::string> used = [] {
    std::set<std::string> meshes = list_used_meshes(cafe(), cafe().geometries.at("G2"));
    for (const Instance& instance : cafe().instances) meshes.merge(list_used_meshes(cafe(), instance.mesh));
    return meshes;
  }();
  const auto make = [] { make_world(cafe(), "G2", Illumination::kIndirect); };
  print_row("meshes of other conditions", "the world of G2", make, [&] {
    make();
    for (const auto& [name, spec] : cafe().meshes) {
      if (!used.contains(name) && !spec.find("file")) make_mesh(cafe(), name);
    }
  });
}

void compare_disk() {
  const test::TinyStudy study;
  const std::filesystem::path whole = study.folder() / "whole", fresh = study.folder() / "fresh";
  make_set({study.path(), whole});
  print_row(
      "layers that are on disk", "a study of 24 x 18 pixels, again or for the first time",
      [&] {
        make_set({study.path(), whole});
      },
      [&] {
        std::filesystem::remove_all(fresh);
        make_set({study.path(), fresh});
      });
}

}  // namespace
}  // namespace equilux

int main(int argc, char** argv) {
  using namespace equilux;
  CLI::App app("What each omission of the plan gains");
  std::string lobe;
  bool with_lobe = false;
  app.add_option("--lobe-once", lobe, "Only the object's lobe, in small, once: for a profiler")
      ->check(CLI::IsMember({"none", "sum", "cuts", "set", "paths"}));
  app.add_flag("--with-lobe", with_lobe, "That with it");
  CLI11_PARSE(app, argc, argv);
  if (!lobe.empty()) {
    run_lobe_once(lobe, with_lobe);
    return 0;
  }
  fmt::print("| left out | measured | s | s with it | gain |\n|---|---|---:|---:|---:|\n");
  compare_lobe();
  compare_emission();
  compare_lights();
  compare_tree();
  compare_sharing();
  compare_rays();
  compare_parts();
  compare_disk();
}
