// Costs by a few numbers, items by what they share, runs by bisection.
#include "renderer/work.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "base/error.h"
#include "renderer/batches.h"
#include "renderer/object_rays.h"
#include "renderer/parallel.h"
#include "renderer/reference.h"
#include "renderer/stopwatch.h"

namespace equilux {
namespace {

constexpr int kBisections = 50;

void add_costs(const WorldCosts& costs, WorkItem& item) {
  const std::string world =
      item.family.object.geometry + "-" + format_illumination(item.family.object.illumination);
  item.shared[world] = costs.world;
  item.own += costs.layer * static_cast<double>(item.conditions.size());
  std::set<std::int64_t> counts;
  for (const Condition& condition : item.conditions) counts.insert(condition.cell.column.vpl_count);
  for (const std::int64_t count : counts) {
    const auto vpls = static_cast<double>(count);
    const std::string key = world + "-" + format_vpl_count(count);
    item.shared[key] = kVplCost * vpls * (1 - kOwnVpls);
    item.shared[key + "-" + item.family.object.material] = kVplCost * vpls * kOwnVpls;
    if (is_summed_plainly(count)) {
      item.shared[fmt::format("{}-v{}", key, item.family.view)] =
          kPairCost * costs.shape.sums * vpls * costs.points;
    } else {
      item.own += costs.shape.cuts * (cost_of_cuts(count, costs.points) + cost_of_measuring(count));
    }
  }
  if (item.has_reference) {
    item.own += costs.object.at(item.family.object.material);
    item.own += costs.layer * std::size(kFamilyContents);
    item.shared[fmt::format("{}-room-v{}", world, item.family.view)] = costs.room;
  }
}

// Without `shared` of what `paid` has, which is added.
double add_work(const WorkItem& item, std::set<std::string>& paid) {
  double work = item.own;
  for (const auto& [key, cost] : item.shared) work += paid.insert(key).second ? cost : 0;
  return work;
}

// Items with numbers in place of the names of what they share.
struct PricedItem {
  double own = 0;
  std::vector<std::pair<std::size_t, double>> shared;
};

struct PricedWork {
  std::vector<PricedItem> items;
  std::size_t products = 0;
};

PricedWork price_work(const std::vector<WorkItem>& items) {
  PricedWork work;
  std::map<std::string, std::size_t> numbers;
  for (const WorkItem& item : items) {
    PricedItem priced{item.own, {}};
    for (const auto& [key, cost] : item.shared)
      priced.shared.emplace_back(numbers.try_emplace(key, numbers.size()).first->second, cost);
    work.items.push_back(std::move(priced));
  }
  work.products = numbers.size();
  return work;
}

// Where runs begin: as many items as fit, again and again.
std::vector<std::size_t> fill_runs(const PricedWork& all, double most) {
  std::vector<std::size_t> begins;
  std::vector<std::size_t> payers(all.products, 0);  // the last run that paid, counted from 1
  double work = 0;
  for (std::size_t i = 0; i < all.items.size(); ++i) {
    const PricedItem& item = all.items[i];
    double more = item.own, alone = item.own;
    for (const auto& [product, cost] : item.shared) {
      more += payers[product] == begins.size() ? 0 : cost;
      alone += cost;
    }
    const bool begins_run = begins.empty() || work + more > most;
    if (begins_run) begins.push_back(i);
    work = begins_run ? alone : work + more;
    for (const auto& [product, cost] : item.shared) payers[product] = begins.size();
  }
  return begins;
}

// Share of rays from what the camera sees of the object that meet it again: of a ball none.
double estimate_self_occlusion(const World& world, const Primary& primary) {
  constexpr std::uint64_t kSeed = 1;
  std::vector<AreaPoint> points;
  for (const PrimaryHit& hit : primary.hits) {
    if (hit.kind == PrimaryKind::kObject) points.push_back({hit.point.p, hit.point.ng, hit.point.epsilon});
  }
  const Share met = find_self_occlusion(world, points, kSeed);
  return met.total > 0 ? static_cast<double>(met.count) / static_cast<double>(met.total) : 0;
}

}  // namespace

double cost_of_cuts(std::int64_t vpls, double points) {
  if (!(points > 0)) return 0;
  return 57 * std::pow(static_cast<double>(vpls) / 1e5, 0.1) * std::pow(points / 2.6e5, -0.26) * points;
}

// Points against all VPLs, and what comes with any.
double cost_of_measuring(std::int64_t vpls) { return 3e6 + 1.5 * static_cast<double>(vpls); }

ShapeCosts cost_of_shape(double self_occlusion) {
  return {1 + 3 * self_occlusion, 1 + 5 * self_occlusion, 1 + 8 * self_occlusion};
}

double ShapeCosts::of_reference(const ReferenceParams& params) const {
  return params.fixed ? sums : references;
}

WorldKey world_of(const Object& object) { return {object.geometry, object.illumination}; }

std::vector<Family> pick_references(const Study& study) {
  std::vector<Family> picked;
  std::set<std::string> materials;
  for (const Family& family : enumerate_references(study)) {
    if (materials.insert(family.object.material).second) picked.push_back(family);
  }
  return picked;
}

WorldCosts estimate_costs(const Study& study, const Scene& scene, const World& world,
                          const std::vector<Family>& references) {
  const Primary small = trace_primary(world, make_view_camera(scene, 0), 64, 48, 1);
  double object = 0;
  for (const PrimaryHit& hit : small.hits) object += hit.kind == PrimaryKind::kObject;
  const double all_pixels = static_cast<double>(study.width) * study.height,
               pixels = all_pixels / static_cast<double>(small.hits.size());
  WorldCosts costs;
  costs.layer = kLayerCost + kLayerPixelCost * all_pixels;
  costs.world = kWorldCost + kWorldTriangleCost * static_cast<double>(world.triangle_count());
  costs.points = pixels * object * study.subpixel_positions;
  costs.shape = cost_of_shape(estimate_self_occlusion(world, small));
  for (const Family& family : references) {
    const ReferenceParams params = make_reference_params(study, scene, family);
    costs.object[family.object.material] =
        costs.shape.of_reference(params) * estimate_object_paths(params, small, pixels);
    if (costs.room == 0) costs.room = estimate_background_paths(params, small, pixels);
  }
  return costs;
}

double measure_speed(const Study& study, const Scene& scene) {
  constexpr double kEnough = 0.5;  // s
  constexpr int kMostPaths = 1 << 16;
  constexpr double kWholePictures = 1.2;  // whose paths are faster than those of a few pixels
  constexpr double kUsual = 1e6;          // where the camera sees nothing that could be timed
  const Object object = enumerate_objects(study).front();
  const World world = make_world(scene, object.geometry, object.illumination);
  const Materials materials = make_materials(world, find_material(scene, object.material));
  const Primary primary = trace_primary(world, make_view_camera(scene, 0), 64, 48, 1);
  double seconds = 0, traced = 0;
  for (int paths = kBatches; paths <= kMostPaths && seconds < kEnough; paths *= 4) {
    const PathMaps maps = make_fixed_maps(primary, {paths, paths, paths});
    traced = count_paths(primary, maps);
    const double before = measure_processor_seconds();
    trace_layers({world, materials, primary}, maps, study.seed, "speed", {}, [](double) {});
    seconds = (measure_processor_seconds() - before) / count_threads();
  }
  return traced > 0 && seconds > 0 ? kWholePictures * traced / seconds : kUsual;
}

std::string tell_narrow_target(const Study& study) {
  constexpr double kNarrow = 0.1;
  const NoiseTarget& target = study.noise_target;
  const double least = std::min({target.object_mean, target.object_p99, target.outside_mean});
  if (study.paths || !(least < kNarrow)) return "";
  return fmt::format(
      "noise_target asks for errors of {} displayed steps, which nobody sees; time goes with the inverse "
      "square",
      least);
}

std::vector<WorkItem> list_work(const std::map<WorldKey, WorldCosts>& costs, const Wanted& wanted) {
  std::map<Family, WorkItem> by_family;
  for (const Family& family : wanted.families) by_family[family].has_reference = true;
  for (const Condition& condition : wanted.conditions)
    by_family[family_of(condition)].conditions.push_back(condition);
  std::vector<WorkItem> items;
  for (auto& [family, item] : by_family) {
    item.family = family;
    add_costs(costs.at(world_of(family.object)), item);
    items.push_back(std::move(item));
  }
  const auto order = [](const WorkItem& item) {
    return std::tuple(world_of(item.family.object), item.family.view, item.family.object.material);
  };
  std::stable_sort(items.begin(), items.end(),
                   [&](const WorkItem& a, const WorkItem& b) { return order(a) < order(b); });
  return items;
}

double cost_of_pictures(const Study& study, const Wanted& wanted) {
  const double pixels = static_cast<double>(study.width) * study.height;
  return (kPictureCost + kPicturePixelCost * pixels) *
         static_cast<double>(wanted.conditions.size() + wanted.families.size());
}

double sum_work(const std::vector<WorkItem>& items) {
  std::set<std::string> paid;
  double work = 0;
  for (const WorkItem& item : items) work += add_work(item, paid);
  return work;
}

std::vector<std::vector<WorkItem>> split_work(const std::vector<WorkItem>& items, int count) {
  EQ_CHECK(count >= 1, count);
  const PricedWork work = price_work(items);
  double low = 0, high = sum_work(items);
  for (int step = 0; step < kBisections; ++step) {
    const double middle = (low + high) / 2;
    (fill_runs(work, middle).size() <= static_cast<std::size_t>(count) ? high : low) = middle;
  }
  std::vector<std::size_t> begins = fill_runs(work, high);
  EQ_CHECK(begins.size() <= static_cast<std::size_t>(count), begins.size(), count);
  begins.resize(static_cast<std::size_t>(count) + 1, items.size());
  std::vector<std::vector<WorkItem>> runs;
  for (std::size_t run = 0; run + 1 < begins.size(); ++run)
    runs.emplace_back(items.begin() + static_cast<std::ptrdiff_t>(begins[run]),
                      items.begin() + static_cast<std::ptrdiff_t>(begins[run + 1]));
  return runs;
}

Wanted join_work(const std::vector<WorkItem>& items) {
  Wanted wanted;
  for (const WorkItem& item : items) {
    if (item.has_reference) wanted.families.push_back(item.family);
    wanted.conditions.insert(wanted.conditions.end(), item.conditions.begin(), item.conditions.end());
  }
  return wanted;
}

}  // namespace equilux
