// The renderer's order of work: geometry and illumination, then references by view, then VPL counts.
#include "renderer/render_layers.h"

#include <algorithm>

#include "base/error.h"
#include "base/progress.h"
#include "renderer/cut_error.h"
#include "renderer/reference.h"
#include "renderer/reference_record.h"
#include "renderer/set_memory.h"
#include "renderer/set_space.h"
#include "renderer/shade.h"
#include "renderer/stopwatch.h"
#include "renderer/vpl.h"
#include "renderer/work.h"
#include "renderer/world_shelf.h"

namespace equilux {
namespace {

std::string count_materials(std::size_t count) {
  return fmt::format("{} material{}", count, count == 1 ? "" : "s");
}

std::map<WorldKey, Wanted> group_layers(const Wanted& missing) {
  std::map<WorldKey, Wanted> groups;
  for (const Family& family : missing.families) groups[world_of(family.object)].families.push_back(family);
  for (const Condition& condition : missing.conditions)
    groups[world_of(condition.cell.column.object)].conditions.push_back(condition);
  return groups;
}

// Particles, by VPL count.
using PathsByCount = std::map<std::int64_t, std::int64_t>;

struct GroupJob {
  const Recipes& recipes;
  const Study& study;
  const Scene& scene;
  const World& world;
  const WorldCosts& costs;
  const PathsByCount& paths;
  LayerStore& store;
  Progress& progress;
  std::map<std::string, double>& seconds;
  WorkLog& log;
  WorkCounts& counts;

  void tell(const std::string& what) const {
    progress.tell(fmt::format("{} of {} references, {} of {} VPL layers; {}", counts.references,
                              counts.all_references, counts.layers, counts.all_layers, what));
  }
};

// Adds the time that it lives to a stage, and to the log what was done in it.
class LoggedWork {
 public:
  LoggedWork(const GroupJob& job, const char* stage, const std::string& what)
      : work_(job.log, what), watch_(job.seconds[stage]) {
    job.tell(what);
  }

 private:
  LoggedProduct work_;
  Stopwatch watch_;
};

Materials materials_of(const GroupJob& job, const std::string& material) {
  return make_materials(job.world, find_material(job.scene, material));
}

void save_family(const GroupJob& job, const Primary& primary, const Family& family,
                 const FamilyLayers& layers) {
  const Stopwatch watch(job.seconds["files"]);
  const std::string recipe = digest_family_recipe(job.recipes, family);
  const HdrImage coverage = make_coverage(primary);
  const std::map<std::string, const HdrImage*> by_content{{"background", &layers.background},
                                                          {"coverage", &coverage},
                                                          {"direct", &layers.direct},
                                                          {"indirect", &layers.indirect},
                                                          {"standard_error", &layers.standard_error}};
  for (const char* content : kFamilyContents) {
    Json reference;
    if (content == std::string("indirect")) reference = tell_reference(layers);
    if (content == std::string("background")) reference = tell_room(layers);
    job.store.save(layer_name(family, content), recipe, *by_content.at(content), {}, {},
                   std::move(reference));
  }
  job.store.save_group();
  job.progress.advance(job.costs.layer * std::size(kFamilyContents));
  ++job.counts.references;
}

// A room that is made in seconds costs more to keep than to make again. units: paths
constexpr double kWorthKeeping = 3e5;

// What an interrupted run made of this room.
RoomStages open_stages(const GroupJob& job, const Primary& primary, const ReferenceParams& params,
                       const std::vector<Family>& families) {
  if (estimate_background_paths(params, primary) < kWorthKeeping) return {};
  std::vector<RoomMember> members;
  for (const Family& family : families)
    members.push_back({format_key(family), digest_family_recipe(job.recipes, family)});
  return {job.store.folder().rooms() / name_background_stream(families.front()),
          std::move(members),
          {job.study.width, job.study.height}};
}

// Of one view: their backgrounds from the same paths, then each object.
void render_families(const GroupJob& job, const Primary& primary, const std::vector<Family>& families) {
  if (families.empty()) return;
  const auto scale_progress = [&](double cost) {
    return FamilyProgress{[&job, cost](double paths) { job.progress.advance(cost * paths); },
                          [&job, cost](double paths) { job.progress.expect_more(cost * paths); }};
  };
  std::vector<Materials> materials;
  for (const Family& family : families) materials.push_back(materials_of(job, family.object.material));
  const ReferenceParams params = make_reference_params(job.study, job.scene, families.front());
  const RoomStages stages = open_stages(job, primary, params, families);
  const FamilyProgress of_room = scale_progress(1),
                       of_object = scale_progress(job.costs.shape.of_reference(params));
  BackgroundPlan plan;
  std::vector<Background> backgrounds;
  {
    const LoggedWork work(job, "backgrounds",
                          fmt::format("backgrounds {} of {}", name_background_stream(families[0]),
                                      count_materials(families.size())));
    plan = plan_background(job.world, primary, params, of_room, stages);
    backgrounds = trace_planned_backgrounds({job.world, materials, primary}, plan, params, of_room, stages);
  }
  for (std::size_t i = 0; i < families.size(); ++i) {
    FamilyLayers layers;
    {
      const LoggedWork work(job, "references", "reference " + format_key(families[i]));
      layers = trace_object({job.world, materials[i], primary}, plan, backgrounds[i],
                            make_reference_params(job.study, job.scene, families[i]), of_object);
    }
    save_family(job, primary, families[i], layers);
  }
  stages.remove();
}

// VPL layers wanted: material -> clamp levels.
using LevelsByMaterial = std::map<std::string, std::set<int>>;

Condition make_condition(const WorldKey& group, const std::string& material, std::int64_t vpl_count,
                         int level, int view) {
  return {{{{group.geometry, material, group.illumination}, vpl_count}, level, false}, view};
}

std::vector<double> clamps_of(const std::vector<int>& levels) {
  std::vector<double> clamps;
  for (int level : levels) clamps.push_back(clamp_per_m2(level));
  return clamps;
}

std::vector<int> all_levels(const LevelsByMaterial& wanted) {
  std::set<int> levels;
  for (const auto& [material, some] : wanted) levels.insert(some.begin(), some.end());
  return {levels.begin(), levels.end()};
}

// What the camera sees of the object in a view, and the layers wanted of it.
struct ViewJob {
  int view = 0;
  Primary primary;
  std::vector<ShadingPoint> points;
  std::map<std::int64_t, LevelsByMaterial> wanted;  // by VPL count
};

// One geometry, illumination and VPL count: what the VPL layers of its views are made from.
struct VplJob {
  const GroupJob& group;
  const WorldKey& key;
  std::int64_t vpl_count;
  std::int64_t paths;
  std::vector<const ViewJob*> views;  // that want some of it

  const LevelsByMaterial& wanted(const ViewJob& view) const { return view.wanted.at(vpl_count); }

  // A product as the log tells it, such as "light tree G0-MS-ind-5M".
  std::string name(const char* product, const std::string& material) const {
    const Column column{{key.geometry, material, key.illumination}, vpl_count};
    return fmt::format("{} {}", product, format_key(column));
  }
};

// Of all views.
LevelsByMaterial find_wanted(const VplJob& job) {
  LevelsByMaterial all;
  for (const ViewJob* view : job.views) {
    for (const auto& [material, levels] : job.wanted(*view))
      all[material].insert(levels.begin(), levels.end());
  }
  return all;
}

// The VPLs of all materials, one after another: paths that never met the object are traced for the first
// alone.
class SharedVpls {
 public:
  explicit SharedVpls(const VplJob& job)
      : job_(job),
        stream_(fmt::format("vpls/{}/{}/{}", job.key.geometry, format_illumination(job.key.illumination),
                            format_vpl_count(job.vpl_count))) {}

  /// Those of this material alone; `shared` of the first.
  VplSet trace(const std::string& material) {
    const GroupJob& group = job_.group;
    const LoggedWork work(group, "VPL tracing", job_.name("VPLs", material));
    const Materials materials = materials_of(group, material);
    const Emission emission = group.study.emission;
    const auto cost = kVplCost * static_cast<double>(job_.vpl_count);
    group.progress.advance(cost * (first_.paths == 0 ? 1 : kOwnVpls));
    if (first_.paths == 0) {
      VplSet set = trace_vpls(group.world, materials, job_.paths, group.study.seed, stream_, emission);
      first_.paths = set.paths;
      first_.met = set.met;
      return set;
    }
    VplSet set;
    set.own = trace_own_vpls(group.world, materials, first_, group.study.seed, stream_, emission);
    return set;
  }

 private:
  const VplJob& job_;
  std::string stream_;
  VplSet first_;  // its paths, without its VPLs
};

// Light of one of the materials that it was made for.
struct LightPart {
  const ShadedPoints& shaded;
  std::size_t material;
};

// A material's light as the sum of its parts; `record` tells of a level.
struct MaterialLight {
  std::vector<LightPart> parts;
  std::function<VplRecord(std::size_t)> record;
};

void save_vpl_layers(const VplJob& job, const ViewJob& view, const std::string& material,
                     const std::vector<int>& levels, const MaterialLight& light) {
  const GroupJob& group = job.group;
  const Stopwatch watch(group.seconds["files"]);
  for (std::size_t level = 0; level < levels.size(); ++level) {
    if (!job.wanted(view).at(material).contains(levels[level])) continue;
    const Condition condition = make_condition(job.key, material, job.vpl_count, levels[level], view.view);
    HdrImage layer(view.primary.width, view.primary.height);
    for (const LightPart& part : light.parts)
      add_to_layer(part.shaded, part.material, level, view.points, view.primary.positions, layer);
    const VplRecord record = light.record(level);
    group.store.save(vpl_layer_name(condition), digest_vpl_recipe(group.recipes, condition), layer,
                     {{"equilux_clamp_per_m2", fmt::format("{}", clamp_per_m2(levels[level]))},
                      {"equilux_vpl_count", fmt::format("{}", record.count)}},
                     record);
    group.progress.advance(group.costs.layer);
    ++group.counts.layers;
  }
}

// The VPLs of all materials of a plain sum: few enough to hold them side by side.
struct PlainVpls {
  VplList shared;
  std::map<std::string, VplList> own;
};

// All materials and levels of a view in one pass over the VPLs.
void render_plain_sums(const VplJob& job, const ViewJob& view, const PlainVpls& vpls) {
  const GroupJob& group = job.group;
  const LevelsByMaterial& wanted = job.wanted(view);
  const std::vector<int> levels = all_levels(wanted);
  const std::vector<double> clamps = clamps_of(levels);
  std::vector<Material> materials;
  for (const auto& [material, some] : wanted)
    materials.push_back(make_material(find_material(group.scene, material)));
  const auto shade = [&](const std::string& what, const VplList& list, const std::vector<Material>& of,
                         double cost) {
    const LoggedWork work(group, "VPL shading", what);
    return shade_all_vpls(group.world, view.points, list, of, clamps,
                          [&](double pairs) { group.progress.advance(cost * pairs); });
  };
  const ShadedPoints shared =
      shade(fmt::format("plain sums {}-{}-{}-v{} of {}", job.key.geometry,
                        format_illumination(job.key.illumination), format_vpl_count(job.vpl_count), view.view,
                        count_materials(materials.size())),
            vpls.shared, materials, kPairCost * group.costs.shape.sums);
  std::size_t index = 0;
  for (const auto& [material, some] : wanted) {
    const VplList& list = vpls.own.at(material);
    const ShadedPoints own =
        shade(fmt::format("{}-v{} of its own", job.name("plain sums", material), view.view), list,
              {materials[index]}, 0);
    Json record;
    record.set("method", "plain sum").set("shadow_rays", shared.rays + own.rays);
    const VplRecord told{static_cast<std::int64_t>(vpls.shared.size() + list.size()), std::move(record), {}};
    save_vpl_layers(job, view, material, levels,
                    {{{shared, index}, {own, 0}}, [&](std::size_t) { return told; }});
    ++index;
  }
}

void render_all_plain_sums(const VplJob& job) {
  SharedVpls tracing(job);
  PlainVpls vpls;
  for (const auto& [material, some] : find_wanted(job)) {
    VplSet set = tracing.trace(material);
    if (vpls.own.empty()) vpls.shared = std::move(set.shared);
    vpls.own[material] = std::move(set.own);
  }
  for (const ViewJob* view : job.views) {
    render_plain_sums(job, *view, vpls);
    job.group.store.save_group();
  }
}

// The luminance that a quarter of a displayed step stands for in the family of this material.
double find_floor(const VplJob& job, const ViewJob& view, const std::string& material) {
  const GroupJob& group = job.group;
  const Family family{{job.key.geometry, material, job.key.illumination}, view.view};
  const auto load = [&](const char* content) { return group.store.load(layer_name(family, content)); };
  const HdrImage background = load("background"), direct = load("direct"), indirect = load("indirect"),
                 coverage = load("coverage"), reference = composite({&background, &direct, &indirect});
  const ToneMapping& planned = group.study.planned_tone;
  return find_radiance_of_step(
      make_tone_curve(reference, coverage, {ToneOperator::kGlobal, planned.key, planned.exposure}).record,
      0.25);
}

// The trees of one material.
struct MaterialTrees {
  const LightTree& shared;
  const LightTree& own;
  std::int64_t count;
};

// At all levels whatever is missing: so that no layer depends on what it was made with.
void render_lightcuts(const VplJob& job, const ViewJob& view, const std::string& name,
                      const MaterialTrees& trees) {
  const GroupJob& group = job.group;
  const std::vector<int> levels = traversed_levels(group.study);
  const std::vector<double> clamps = clamps_of(levels);
  const Material material = make_material(find_material(group.scene, name));
  const auto all = std::max(1.0, static_cast<double>(view.points.size()));
  const auto advance = [&](double points) {
    group.progress.advance(group.costs.shape.cuts * cost_of_cuts(job.vpl_count, all) * points / all);
  };
  const auto shade = [&] {
    const std::string what =
        fmt::format("{}-v{} at {} levels", job.name("cuts", name), view.view, levels.size());
    const LoggedProduct work(group.log, what);
    group.tell(what);
    return shade_measured({group.world, view.points, {&trees.shared, &trees.own}, material, clamps, advance},
                          {kErrorRatio, find_floor(job, view, name), group.study.certified},
                          group.study.seed);
  };
  const MeasuredCut cut = shade();
  group.progress.advance(group.costs.shape.cuts * cost_of_measuring(job.vpl_count));
  group.seconds["VPL shading"] += cut.measures.seconds_cut;
  group.seconds["measured error"] += cut.measures.seconds_measured;
  save_vpl_layers(
      job, view, name, levels,
      {{{cut.shaded, 0}}, [&](std::size_t level) {
         return VplRecord{trees.count, make_json(cut.measures, level), make_pool(cut.measures, level)};
       }});
}

// Each material by cuts of its own through the shared tree and one of its own, both views through the same.
void render_all_lightcuts(const VplJob& job) {
  const LightTreeParams tree_params{job.group.study.seed, 4};
  SharedVpls tracing(job);
  LightTree shared_tree;
  std::int64_t shared_count = -1;
  for (const auto& [name, some] : find_wanted(job)) {
    LightTree own_tree;
    std::int64_t count = 0;
    with_vpl_memory(job.vpl_count, [&] {
      VplSet set = tracing.trace(name);
      const LoggedWork work(job.group, "light trees", job.name("light tree", name));
      if (shared_count < 0) {
        shared_count = static_cast<std::int64_t>(set.shared.size());
        shared_tree = make_light_tree(std::move(set.shared), tree_params);
      }
      count = shared_count + static_cast<std::int64_t>(set.own.size());
      own_tree = make_light_tree(std::move(set.own), tree_params);
    });
    for (const ViewJob* view : job.views) {
      if (!job.wanted(*view).contains(name)) continue;
      render_lightcuts(job, *view, name, {shared_tree, own_tree, count});
      job.group.store.save_group();
    }
  }
}

void render_vpl_layers(const VplJob& job) {
  if (is_summed_plainly(job.vpl_count)) {
    render_all_plain_sums(job);
  } else {
    render_all_lightcuts(job);
  }
}

// A view's families, whose references its cuts need.
ViewJob open_view(const GroupJob& job, const Wanted& missing, int view) {
  ViewJob opened;
  opened.view = view;
  std::vector<Family> families;
  for (const Condition& condition : missing.conditions) {
    if (condition.view != view) continue;
    const Column& column = condition.cell.column;
    opened.wanted[column.vpl_count][column.object.material].insert(condition.cell.clamp_level);
  }
  for (const Family& family : missing.families) {
    if (family.view == view) families.push_back(family);
  }
  if (opened.wanted.empty() && families.empty()) return opened;
  opened.primary = trace_primary(job.world, make_view_camera(job.scene, view), job.study.width,
                                 job.study.height, job.study.subpixel_positions);
  opened.points = find_shading_points(opened.primary);
  render_families(job, opened.primary, families);
  return opened;
}

// References of all views, then VPL count by count: the views share VPLs and trees.
void render_group(const GroupJob& job, const WorldKey& key, const Wanted& missing) {
  std::vector<ViewJob> views;
  std::set<std::int64_t> counts;
  for (int view = 0; view < kViewCount; ++view) {
    views.push_back(open_view(job, missing, view));
    for (const auto& [count, wanted] : views.back().wanted) counts.insert(count);
  }
  for (const std::int64_t count : counts) {
    std::vector<const ViewJob*> wanting;
    for (const ViewJob& view : views) {
      if (view.wanted.contains(count)) wanting.push_back(&view);
    }
    render_vpl_layers({job, key, count, job.paths.at(count), wanting});
  }
}

PathsByCount find_paths(const Study& study, const World& world, const Wanted& missing) {
  PathsByCount paths;
  for (const Condition& condition : missing.conditions) {
    const std::int64_t count = condition.cell.column.vpl_count;
    if (!paths.contains(count)) paths[count] = find_path_count(world, count, study.seed, study.emission);
  }
  return paths;
}

// What is known of all groups before the first reference.
struct GroupCosts {
  std::map<WorldKey, WorldCosts> work;
  std::map<WorldKey, PathsByCount> paths;
};

// Every world is made, so that a mesh that cannot be read or a world without VPLs is said now; in reverse, so
// that the last one is the first that is rendered.
GroupCosts survey_groups(const Study& study, const Scene& scene, const std::map<WorldKey, Wanted>& groups,
                         WorldShelf& worlds, double& seconds) {
  GroupCosts costs;
  const std::vector<Family> references = pick_references(study);
  Progress progress("looking at worlds", static_cast<double>(groups.size()));
  for (auto group = groups.rbegin(); group != groups.rend(); ++group) {
    const auto& [key, missing] = *group;
    const World& world = worlds.take(key);
    const Stopwatch watch(seconds);
    costs.work[key] = estimate_costs(study, scene, world, references);
    costs.paths[key] = find_paths(study, world, missing);
    progress.advance(1);
  }
  return costs;
}

}  // namespace

double render_layers(const Recipes& recipes, const Scene& scene, const Wanted& missing, WorkCounts counts,
                     LayerStore& store, WorkLog& log, std::map<std::string, double>& seconds) {
  const Study& study = recipes.study;
  check_memory(study, missing);
  const auto groups = group_layers(missing);
  WorldShelf worlds(scene, seconds["worlds"]);
  const GroupCosts costs = survey_groups(study, scene, groups, worlds, seconds["worlds"]);
  check_space(store.folder().root, estimate_set_bytes(study, costs.work, missing));
  check_same_files(recipes, scene);  // what was looked at is what layers are recorded to be made from
  const double work = sum_work(list_work(costs.work, missing));
  Progress progress("rendering", work);
  for (const auto& [key, group] : groups) {
    const GroupJob job{
        recipes, study, scene, worlds.take(key), costs.work.at(key), costs.paths.at(key), store, progress,
        seconds, log,   counts};
    job.tell("the world of " + job.world.name());
    progress.advance(job.costs.world);
    render_group(job, key, group);
  }
  return work;
}

}  // namespace equilux
