// Cutting, drawing points, measuring, telling.
#include "renderer/cut_error.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "base/random.h"
#include "renderer/stopwatch.h"

namespace equilux {
namespace {

constexpr std::size_t kMeasuredPoints = 256, kCheckedPoints = 16;
constexpr std::size_t kMostSummedVpls = 110000;  // a count of 100k is met within some per cent
constexpr double kFiner = 20;
constexpr double kLeastRatio = 1e-4;  // certifying ends here
constexpr double kPoolUnit = 1e-5;

void add_shaded(const ShadedPoints& more, ShadedPoints& total) {
  for (std::size_t i = 0; i < total.radiance.size(); ++i) total.radiance[i] += more.radiance[i];
}

ShadedPoints make_black(const CutTask& task) {
  ShadedPoints black{task.clamps_per_m2.size(), task.points.size(), {}, 0};
  black.radiance.resize(black.levels * black.points);
  return black;
}

ShadedPoints cut_trees(const CutTask& task, double ratio, double floor, CutRecord& record) {
  ShadedPoints total = make_black(task);
  record = {std::vector<std::uint32_t>(task.points.size()), 0};
  const auto lit = static_cast<double>(std::count_if(task.trees.begin(), task.trees.end(),
                                                     [](const LightTree* tree) { return !tree->empty(); }));
  for (const LightTree* tree : task.trees) {
    LightcutParams params{ratio, floor};
    params.base = &total;
    if (task.progress) {
      params.progress = [&](double points) { task.progress(points / lit); };
    }
    CutRecord own;
    const ShadedPoints part =
        shade_lightcut(task.world, task.points, *tree, {task.material}, task.clamps_per_m2, params, &own);
    add_shaded(part, total);
    for (std::size_t i = 0; i < own.sizes.size(); ++i) record.sizes[i] += own.sizes[i];
    record.shadow_rays += own.shadow_rays;
  }
  return total;
}

ShadedPoints sum_trees(const CutTask& task) {
  ShadedPoints total = make_black(task);
  for (const LightTree* tree : task.trees) {
    add_shaded(shade_all_vpls(task.world, task.points, tree->vpls, {task.material}, task.clamps_per_m2,
                              [](double) {}),
               total);
  }
  return total;
}

// Indices of points, each at most once, in rising order: so that neighbours stay neighbours.
std::vector<std::size_t> draw_points(std::string_view what, std::size_t count, std::size_t wanted,
                                     std::uint64_t seed) {
  std::vector<std::size_t> indices(count);
  std::iota(indices.begin(), indices.end(), std::size_t{0});
  RandomStream random(seed, what, count);
  shuffle(indices, random);
  indices.resize(std::min(count, wanted));
  std::sort(indices.begin(), indices.end());
  return indices;
}

std::vector<ShadingPoint> take_points(const std::vector<ShadingPoint>& points,
                                      const std::vector<std::size_t>& indices) {
  std::vector<ShadingPoint> taken;
  for (std::size_t index : indices) taken.push_back(points[index]);
  return taken;
}

// Of `shaded` at indices against the truth there. shape: level x index
std::vector<std::vector<double>> find_errors(const ShadedPoints& shaded,
                                             const std::vector<std::size_t>& indices,
                                             const ShadedPoints& truth, double floor) {
  std::vector<std::vector<double>> errors(shaded.levels);
  for (std::size_t level = 0; level < shaded.levels; ++level) {
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const double seen = luminance(shaded.radiance[shaded.index(0, level, indices[i])]);
      const double known = luminance(truth.radiance[truth.index(0, level, i)]);
      const double scale = std::max(known, floor);
      // Beyond a million times the truth it is wrong, and that is all that matters.
      errors[level].push_back(scale > 0 ? std::clamp((seen - known) / scale, -1e6, 1e6) : 0);
    }
  }
  return errors;
}

// The value that at most a share of `share` lies above. `sorted` rises.
double find_quantile(const std::vector<double>& sorted, double share) {
  if (sorted.empty()) return 0;
  const auto rank = static_cast<std::size_t>(std::ceil(share * static_cast<double>(sorted.size())));
  return sorted[std::clamp<std::size_t>(rank, 1, sorted.size()) - 1];
}

void set_sizes(const CutRecord& record, CutMeasures& measures) {
  std::vector<double> sizes(record.sizes.begin(), record.sizes.end());
  std::sort(sizes.begin(), sizes.end());
  measures.rays = record.shadow_rays;
  measures.mean_size =
      sizes.empty() ? 0
                    : std::accumulate(sizes.begin(), sizes.end(), 0.0) / static_cast<double>(sizes.size());
  measures.p99_size = find_quantile(sizes, 0.99);
  measures.max_size = sizes.empty() ? 0 : sizes.back();
}

// Cuts, and holds them to what is known better at points that it draws.
class Judge {
 public:
  Judge(const CutTask& task, std::string_view what, std::uint64_t seed)
      : task_(task),
        indices_(draw_points(what, task.points.size(), kMeasuredPoints, seed)),
        points_(take_points(task.points, indices_)) {
    const Stopwatch watch(seconds_);
    std::size_t count = 0;
    for (const LightTree* tree : task.trees) count += tree->vpls.size();
    by_sum_ = count <= kMostSummedVpls;
    checked_ = draw_points(what, points_.size(), kCheckedPoints, seed);
    const auto summed = by_sum_ ? points_ : take_points(points_, checked_);
    sum_ = sum_trees(at(summed));
  }

  MeasuredCut cut(double ratio, double floor) const {
    MeasuredCut cut;
    cut.measures.error_ratio = ratio;
    cut.measures.floor = floor;
    cut.measures.against_plain_sum = by_sum_;
    {
      const Stopwatch watch(cut.measures.seconds_cut);
      CutRecord record;
      cut.shaded = cut_trees(task_, ratio, floor, record);
      set_sizes(record, cut.measures);
    }
    const Stopwatch watch(cut.measures.seconds_measured);
    measure(cut);
    return cut;
  }

  double seconds() const { return seconds_; }

 private:
  CutTask at(const std::vector<ShadingPoint>& points) const {
    return {task_.world, points, task_.trees, task_.material, task_.clamps_per_m2};
  }

  void measure(MeasuredCut& cut) const {
    CutMeasures& measures = cut.measures;
    if (by_sum_) {
      measures.errors = find_errors(cut.shaded, indices_, sum_, measures.floor);
      return;
    }
    CutRecord record;
    const ShadedPoints finer = cut_trees(at(points_), measures.error_ratio / kFiner, measures.floor, record);
    measures.errors = find_errors(cut.shaded, indices_, finer, measures.floor);
    for (const auto& errors : find_errors(finer, checked_, sum_, measures.floor))
      measures.finer.push_back(summarise_errors(errors));
  }

  const CutTask& task_;
  std::vector<std::size_t> indices_, checked_;  // among all points, among those drawn
  std::vector<ShadingPoint> points_;
  ShadedPoints sum_;  // at all points drawn or at those checked
  bool by_sum_ = false;
  double seconds_ = 0;
};

bool is_certified(const CutMeasures& measures) {
  return std::all_of(measures.errors.begin(), measures.errors.end(),
                     [](const auto& errors) { return summarise_errors(errors).p99 < kCertifiedError; }) &&
         std::all_of(measures.finer.begin(), measures.finer.end(),
                     [](const ErrorSummary& finer) { return finer.rms < kCertifiedError / 2; });
}

Json make_json(const ErrorSummary& summary) {
  Json json;
  json.set("points", summary.points).set("mean", summary.mean).set("rms", summary.rms);
  json.set("rms_95", Json(Json::Array{summary.rms_low, summary.rms_high}));
  return json.set("p99", summary.p99).set("max", summary.max);
}

}  // namespace

ErrorSummary summarise_errors(const std::vector<double>& errors) {
  ErrorSummary summary;
  summary.points = errors.size();
  if (errors.empty()) return summary;
  const auto count = static_cast<double>(errors.size());
  std::vector<double> sizes;
  double squares = 0, fourths = 0;
  for (double error : errors) {
    summary.mean += error / count;
    squares += error * error / count;
    fourths += error * error * error * error / count;
    sizes.push_back(std::abs(error));
  }
  std::sort(sizes.begin(), sizes.end());
  const double margin = 1.96 * std::sqrt(std::max(0.0, fourths - squares * squares) / count);
  summary.rms = std::sqrt(squares);
  summary.rms_low = std::sqrt(std::max(0.0, squares - margin));
  summary.rms_high = std::sqrt(squares + margin);
  summary.p99 = find_quantile(sizes, 0.99);
  summary.max = sizes.back();
  return summary;
}

MeasuredCut shade_measured(const CutTask& task, const CutRule& rule, std::uint64_t seed) {
  double ratio = rule.error_ratio;
  double searched = 0;
  if (rule.certified) {
    const Stopwatch watch(searched);
    const auto points =
        take_points(task.points, draw_points("cut-error-search", task.points.size(), kMeasuredPoints, seed));
    const CutTask few{task.world, points, task.trees, task.material, task.clamps_per_m2};
    const Judge judge(few, "cut-error-search", seed);
    while (!is_certified(judge.cut(ratio, rule.floor).measures) && ratio >= kLeastRatio) ratio /= 2;
  }
  const Judge judge(task, "cut-error", seed);
  MeasuredCut cut = judge.cut(ratio, rule.floor);
  while (rule.certified && !is_certified(cut.measures) && ratio >= kLeastRatio)
    cut = judge.cut(ratio /= 2, rule.floor);
  if (rule.certified) cut.measures.certified = is_certified(cut.measures);
  cut.measures.seconds_measured += judge.seconds() + searched;
  return cut;
}

Json make_json(const CutMeasures& measures, std::size_t level) {
  Json size;
  size.set("mean", measures.mean_size).set("p99", measures.p99_size).set("max", measures.max_size);
  Json error = make_json(summarise_errors(measures.errors[level]));
  error.set("against", measures.against_plain_sum ? "plain sum" : "cut at a twentieth");
  if (!measures.finer.empty()) error.set("of_that", make_json(measures.finer[level]));
  Json json;
  json.set("method", "lightcut").set("error_ratio", measures.error_ratio).set("floor", measures.floor);
  if (measures.certified) json.set("certified", *measures.certified);
  json.set("cut_size", std::move(size)).set("shadow_rays", measures.rays);
  return json.set("error", std::move(error));
}

Json make_pool(const CutMeasures& measures, std::size_t level) {
  std::vector<std::int64_t> units;
  for (double error : measures.errors[level])
    units.push_back(static_cast<std::int64_t>(std::min(std::abs(error) / kPoolUnit + 1e-6, 1e15)));
  std::sort(units.begin(), units.end());
  Json pool{Json::Array{}};
  for (std::int64_t unit : units) pool.push(unit);
  return pool;
}

ErrorSummary summarise_pools(const std::vector<const Json*>& pools) {
  std::vector<double> errors;
  for (const Json* pool : pools) {
    for (const Json& unit : pool->as_array())
      errors.push_back(static_cast<double>(unit.as_int()) * kPoolUnit);
  }
  return summarise_errors(errors);
}

}  // namespace equilux
