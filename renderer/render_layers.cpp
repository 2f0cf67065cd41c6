// The renderer's order of work: geometry and illumination, then view, then family or VPL count.
#include "renderer/render_layers.h"

#include <chrono>

#include "base/error.h"
#include "base/progress.h"
#include "renderer/reference.h"
#include "renderer/shade.h"

namespace equilux {
namespace {

// Cost of a point-VPL pair in units of a path, for the estimate of what is left; measured on the café.
constexpr double kPairCost = 0.05;

struct GroupKey {
  std::string geometry;
  Illumination illumination;
  auto operator<=>(const GroupKey&) const = default;
};

GroupKey group_of(const Object& object) { return {object.geometry, object.illumination}; }

std::map<GroupKey, MissingLayers> group_layers(const MissingLayers& missing) {
  std::map<GroupKey, MissingLayers> groups;
  for (const Family& family : missing.families) groups[group_of(family.object)].families.push_back(family);
  for (const Condition& condition : missing.conditions) {
    groups[group_of(condition.cell.column.object)].conditions.push_back(condition);
  }
  return groups;
}

class Stopwatch {
 public:
  explicit Stopwatch(double& seconds) : seconds_(seconds), start_(std::chrono::steady_clock::now()) {}
  ~Stopwatch() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_;
};

// Work of a group, from a small picture of what the camera sees. units: paths
double estimate_work(const Study& study, const Scene& scene, const World& world,
                     const MissingLayers& missing) {
  const Primary small = trace_primary(world, make_view_camera(scene, 0), 64, 48, 1);
  double object = 0;
  for (const PrimaryHit& hit : small.hits) object += hit.kind == PrimaryKind::kObject;
  const double pixels =
      static_cast<double>(study.width) * study.height / static_cast<double>(small.hits.size());
  const double family = pixels * estimate_family_paths(make_reference_params(study, ""), small);
  double pairs = 0;
  std::set<std::pair<std::int64_t, int>> seen;  // materials and levels share the pairs
  for (const Condition& condition : missing.conditions) {
    if (!seen.insert({condition.cell.column.vpl_count, condition.view}).second) continue;
    pairs +=
        pixels * object * study.subpixel_positions * static_cast<double>(condition.cell.column.vpl_count);
  }
  return family * static_cast<double>(missing.families.size()) + kPairCost * pairs;
}

struct GroupJob {
  const Recipes& recipes;
  const Study& study;
  const Scene& scene;
  const World& world;
  LayerStore& store;
  Progress& progress;
  std::map<std::string, double>& seconds;
};

Materials materials_of(const GroupJob& job, const std::string& material) {
  return make_materials(job.world, find_material(job.scene, material));
}

void render_family(const GroupJob& job, const Primary& primary, const Family& family) {
  const std::string recipe = digest_family_recipe(job.recipes, family);
  FamilyLayers layers;
  {
    const Stopwatch watch(job.seconds["references"]);
    layers = trace_family({job.world, materials_of(job, family.object.material), primary},
                          make_reference_params(job.study, format_key(family)),
                          {[&](double paths) { job.progress.advance(paths); },
                           [&](double paths) { job.progress.expect_more(paths); }});
  }
  const HdrImage coverage = make_coverage(primary);
  const Stopwatch watch(job.seconds["files"]);
  const std::map<std::string, const HdrImage*> by_content{{"background", &layers.background},
                                                          {"coverage", &coverage},
                                                          {"direct", &layers.direct},
                                                          {"indirect", &layers.indirect},
                                                          {"standard_error", &layers.standard_error}};
  for (const char* content : kFamilyContents) {
    job.store.save(layer_name(family, content), recipe, *by_content.at(content), {});
  }
  job.store.save_record();
}

// The VPL layers of one geometry, illumination, view and VPL count: material -> clamp levels.
using LevelsByMaterial = std::map<std::string, std::set<int>>;

Condition make_condition(const GroupKey& group, const std::string& material, std::int64_t vpl_count,
                         int level, int view) {
  return {{{{group.geometry, material, group.illumination}, vpl_count}, level, false}, view};
}

std::vector<int> all_levels(const LevelsByMaterial& wanted) {
  std::set<int> levels;
  for (const auto& [material, some] : wanted) levels.insert(some.begin(), some.end());
  return {levels.begin(), levels.end()};
}

void render_vpl_layers(const GroupJob& job, const GroupKey& group, int view, const Primary& primary,
                       const std::vector<ShadingPoint>& points, std::int64_t vpl_count, std::int64_t paths,
                       const LevelsByMaterial& wanted) {
  const std::string stream = fmt::format(
      "vpls/{}/{}/{}", group.geometry, format_illumination(group.illumination), format_vpl_count(vpl_count));
  const std::vector<int> levels = all_levels(wanted);
  std::vector<double> clamps;
  for (int level : levels) clamps.push_back(clamp_per_m2(level));
  std::vector<VplSet> sets;
  std::vector<Material> materials;
  {
    const Stopwatch watch(job.seconds["VPL tracing"]);
    for (const auto& [material, some] : wanted) {
      materials.push_back(make_material(find_material(job.scene, material)));
      sets.push_back(trace_vpls(job.world, materials_of(job, material), paths, job.study.seed, stream,
                                job.study.emission));
    }
  }
  const auto advance = [&](double pairs) { job.progress.advance(kPairCost * pairs); };
  ShadedPoints shared;
  {
    const Stopwatch watch(job.seconds["VPL shading"]);
    shared = shade_all_vpls(job.world, points, sets.front().shared, materials, clamps, advance);
  }
  std::size_t index = 0;
  for (const auto& [material, some] : wanted) {
    ShadedPoints own;
    {
      const Stopwatch watch(job.seconds["VPL shading"]);
      own = shade_all_vpls(job.world, points, sets[index].own, {materials[index]}, clamps, [](double) {});
    }
    const Stopwatch watch(job.seconds["files"]);
    for (std::size_t level = 0; level < levels.size(); ++level) {
      if (!some.contains(levels[level])) continue;
      const Condition condition = make_condition(group, material, vpl_count, levels[level], view);
      HdrImage layer(primary.width, primary.height);
      add_to_layer(shared, index, level, points, primary.positions, layer);
      add_to_layer(own, 0, level, points, primary.positions, layer);
      job.store.save(vpl_layer_name(condition), digest_vpl_recipe(job.recipes, condition), layer,
                     {{"equilux_clamp_per_m2", fmt::format("{}", clamps[level])},
                      {"equilux_vpl_count", fmt::format("{}", sets[index].count())}},
                     sets[index].count());
    }
    ++index;
  }
  job.store.save_record();
}

void render_view(const GroupJob& job, const GroupKey& group, const MissingLayers& missing, int view,
                 std::map<std::int64_t, std::int64_t>& path_counts) {
  std::map<std::int64_t, LevelsByMaterial> by_count;
  for (const Condition& condition : missing.conditions) {
    if (condition.view != view) continue;
    const Column& column = condition.cell.column;
    by_count[column.vpl_count][column.object.material].insert(condition.cell.clamp_level);
  }
  std::vector<Family> families;
  for (const Family& family : missing.families) {
    if (family.view == view) families.push_back(family);
  }
  if (by_count.empty() && families.empty()) return;
  const Primary primary = trace_primary(job.world, make_view_camera(job.scene, view), job.study.width,
                                        job.study.height, job.study.subpixel_positions);
  const auto points = find_shading_points(primary);
  for (const Family& family : families) render_family(job, primary, family);
  for (const auto& [vpl_count, wanted] : by_count) {
    const auto [paths, added] = path_counts.try_emplace(vpl_count, 0);
    if (added) paths->second = find_path_count(job.world, vpl_count, job.study.seed);
    render_vpl_layers(job, group, view, primary, points, vpl_count, paths->second, wanted);
  }
}

}  // namespace

std::map<std::string, double> render_layers(const Recipes& recipes, const Scene& scene,
                                            const MissingLayers& missing, LayerStore& store) {
  const Study& study = recipes.study;
  std::map<std::string, double> seconds;
  const auto groups = group_layers(missing);
  std::map<GroupKey, World> worlds;
  double work = 0;
  {
    const Stopwatch watch(seconds["worlds"]);
    for (const auto& [key, group] : groups) {
      const auto& world =
          worlds.emplace(key, make_world(scene, key.geometry, key.illumination)).first->second;
      work += estimate_work(study, scene, world, group);
    }
  }
  Progress progress("rendering", work);
  for (const auto& [key, group] : groups) {
    const GroupJob job{recipes, study, scene, worlds.at(key), store, progress, seconds};
    std::map<std::int64_t, std::int64_t> path_counts;
    for (int view = 0; view < kViewCount; ++view) render_view(job, key, group, view, path_counts);
    worlds.erase(key);
  }
  return seconds;
}

}  // namespace equilux
