// The scalar lightcut: the oracle of the fast one.
#include <algorithm>
#include <atomic>
#include <cmath>

#include "base/error.h"
#include "renderer/cut_groups.h"
#include "renderer/lightcut.h"
#include "renderer/parallel.h"

namespace equilux {
namespace {

struct CutJob {
  const World& world;
  const LightTree& tree;
  const std::vector<Material>& materials;
  const std::vector<double>& clamps;
  const LightcutParams& params;
};

using Rgb = std::array<double, 3>;

double luminance_of(const Rgb& rgb) { return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; }

// A cluster or a single VPL in a cut: its light and the bound of its luminance, material x level.
struct CutMember {
  static constexpr std::uint32_t kSingle = ~0u;
  std::uint32_t node = kSingle;
  std::vector<Rgb> light;
  std::vector<double> bounds;  // empty for a single VPL, which is exact
};

class PointCut {
 public:
  PointCut(const CutJob& job, const ShadingPoint& point, std::size_t index)
      : job_(job), point_(point), bound_point_(make_bound_point(point)), base_(cells(), 0) {
    const ShadedPoints* base = job.params.base;
    for (std::size_t i = 0; base && i < base_.size(); ++i) {
      const std::size_t levels = job.clamps.size();
      base_[i] = luminance(base->radiance[base->index(i / levels, i % levels, index)]);
    }
  }

  // Refines until every cluster keeps the rule with the totals of the cut itself.
  void find() {
    if (job_.tree.empty()) return;
    std::vector<double> thresholds(cells(), 0);
    if (!job_.params.adaptive) {
      set_thresholds({}, thresholds);
      for (CutMember& member : refine_all({make_cluster(0)}, thresholds)) kept_.push_back(std::move(member));
      return;
    }
    std::vector<CutMember> open = start();
    set_thresholds(open, thresholds);
    while (!open.empty()) {
      open = refine_all(std::move(open), thresholds);
      set_thresholds(open, thresholds);
      open = take_failing(std::move(open), thresholds);
    }
  }

  const std::vector<CutMember>& members() const { return kept_; }
  std::uint64_t rays() const { return rays_; }

 private:
  std::size_t cells() const { return job_.materials.size() * job_.clamps.size(); }

  // Some hundred clusters from level by level, for first thresholds: too high or too low, they only decide
  // how many rounds follow and whether some clusters are split in vain.
  std::vector<CutMember> start() {
    std::vector<CutMember> members;
    for (std::uint32_t index : find_top(job_.tree)) members.push_back(make_cluster(index));
    return members;
  }

  // Light of one VPL times `scale`, material x level.
  std::vector<Rgb> shade(std::uint32_t index, double scale) {
    std::vector<Rgb> light(cells(), Rgb{});
    const Vpl& vpl = job_.tree.vpls.vpls[index];
    const SurfacePoint& x = point_.surface;
    const Vec3 d = vpl.p - x.p;
    const float r2 = dot(d, d);
    if (!(r2 > 0)) return light;
    const Vec3 l = d / std::sqrt(r2);
    if (!(dot(x.ng, l) > 0) || !(dot(x.ns, l) > 0)) return light;
    const Vec3 emitted = emit_vpl(job_.tree.vpls, vpl, -l);
    if (emitted == Vec3{}) return light;
    ++rays_;
    if (job_.world.is_occluded(x.origin(), vpl.end())) return light;
    const Vec3 local = bound_point_.shading.to_local(l);
    for (std::size_t m = 0; m < job_.materials.size(); ++m)
      add_levels(eval_brdf(job_.materials[m], bound_point_.v, local) * local.z, emitted, r2, scale,
                 &light[m * job_.clamps.size()]);
    return light;
  }

  void add_levels(Vec3 f, Vec3 emitted, float r2, double scale, Rgb* light) const {
    const double most = max_component(f);
    if (!(most > 0)) return;
    for (std::size_t level = 0; level < job_.clamps.size(); ++level) {
      const double share = std::min(job_.clamps[level], most / r2) / most * scale;
      light[level] = {f.x * share * emitted.x, f.y * share * emitted.y, f.z * share * emitted.z};
    }
  }

  CutMember make_single(std::uint32_t index) { return {CutMember::kSingle, shade(index, 1), {}}; }

  CutMember make_cluster(std::uint32_t node_index) {
    const LightNode& node = job_.tree.nodes[node_index];
    const double scale = double{node.weight} / weigh_vpl(job_.tree.vpls, node.representative);
    return {node_index, shade(node.representative, scale), bound(node_index)};
  }

  std::vector<double> bound(std::uint32_t node_index) const {
    const Cluster cluster = unpack_cluster(job_.tree, job_.tree.nodes[node_index]);
    const GlossCluster* gloss = job_.tree.gloss.empty() ? nullptr : &job_.tree.gloss[node_index];
    const BoxSight sight = sight_box(bound_point_, cluster.low, cluster.high);
    const double emission = bound_emission(bound_point_.p, cluster, gloss);
    std::vector<double> bounds(cells(), 0);
    for (std::size_t m = 0; m < job_.materials.size() && emission > 0; ++m) {
      const float most_m = bound_material(job_.materials[m], bound_point_, sight);
      for (std::size_t level = 0; level < job_.clamps.size(); ++level) {
        const float transfer = bound_transfer(most_m, sight.least_r2, static_cast<float>(job_.clamps[level]));
        bounds[m * job_.clamps.size() + level] = transfer > 0 ? emission * transfer : 0;
      }
    }
    return bounds;
  }

  // Totals of what is kept and of `open`, times the ratio.
  void set_thresholds(const std::vector<CutMember>& open, std::vector<double>& thresholds) const {
    std::vector<double> totals = base_;
    for (const auto* part : {&kept_, &open}) {
      for (const CutMember& member : *part) {
        for (std::size_t i = 0; i < totals.size(); ++i) totals[i] += luminance_of(member.light[i]);
      }
    }
    for (std::size_t i = 0; i < totals.size(); ++i)
      thresholds[i] = job_.params.error_ratio * std::max(totals[i], job_.params.floor);
  }

  static bool keeps_rule(const CutMember& member, const std::vector<double>& thresholds) {
    for (std::size_t i = 0; i < member.bounds.size(); ++i) {
      if (!(member.bounds[i] <= thresholds[i])) return false;
    }
    return true;
  }

  // Splits members until all keep the rule; singles go to what is kept.
  std::vector<CutMember> refine_all(std::vector<CutMember> stack, const std::vector<double>& thresholds) {
    std::vector<CutMember> done;
    while (!stack.empty()) {
      CutMember member = std::move(stack.back());
      stack.pop_back();
      if (keeps_rule(member, thresholds)) {
        done.push_back(std::move(member));
      } else {
        split(member.node, stack);
      }
    }
    return done;
  }

  void split(std::uint32_t node_index, std::vector<CutMember>& stack) {
    const LightNode& node = job_.tree.nodes[node_index];
    if (node.leaf_count == 0) {
      stack.push_back(make_cluster(node.next));
      stack.push_back(make_cluster(node.next + 1));
      return;
    }
    for (std::uint32_t i = 0; i < node.leaf_count; ++i) kept_.push_back(make_single(node.next + i));
  }

  // Clusters that keep the rule go to what is kept, which is looked at again only when a total falls.
  std::vector<CutMember> take_failing(std::vector<CutMember> open, const std::vector<double>& thresholds) {
    std::vector<CutMember> failing;
    open.insert(open.end(), std::make_move_iterator(kept_.begin()), std::make_move_iterator(kept_.end()));
    kept_.clear();
    for (CutMember& member : open)
      (keeps_rule(member, thresholds) ? kept_ : failing).push_back(std::move(member));
    return failing;
  }

  const CutJob& job_;
  const ShadingPoint& point_;
  BoundPoint bound_point_;
  std::vector<double> base_;  // luminance that is there already, material x level
  std::vector<CutMember> kept_;
  std::uint64_t rays_ = 0;
};

void store_totals(const CutJob& job, const PointCut& cut, std::size_t point, ShadedPoints& shaded) {
  for (std::size_t m = 0; m < job.materials.size(); ++m) {
    for (std::size_t level = 0; level < job.clamps.size(); ++level) {
      Rgb sum{};
      for (const CutMember& member : cut.members()) {
        const Rgb& light = member.light[m * job.clamps.size() + level];
        for (std::size_t c = 0; c < 3; ++c) sum[c] += light[c];
      }
      shaded.radiance[shaded.index(m, level, point)] = {
          static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
    }
  }
}

}  // namespace

ShadedPoints shade_lightcut_scalar(const World& world, const std::vector<ShadingPoint>& points,
                                   const LightTree& tree, const std::vector<Material>& materials,
                                   const std::vector<double>& clamps_per_m2, const LightcutParams& params,
                                   CutRecord* record) {
  EQ_CHECK(params.error_ratio >= 0 && params.floor >= 0, params.error_ratio, params.floor);
  EQ_CHECK(params.roulette.share == 0, params.roulette.share);
  const CutJob job{world, tree, materials, clamps_per_m2, params};
  ShadedPoints shaded{clamps_per_m2.size(), points.size(), {}, 0};
  shaded.radiance.resize(materials.size() * shaded.levels * shaded.points);
  std::vector<std::uint32_t> sizes(points.size());
  std::atomic<std::uint64_t> rays = 0;
  for_each_parallel(points.size(), [&](std::size_t i) {
    PointCut cut(job, points[i], i);
    cut.find();
    sizes[i] = static_cast<std::uint32_t>(cut.members().size());
    rays += cut.rays();
    store_totals(job, cut, i, shaded);
  });
  check_finite(shaded);
  if (record) *record = {std::move(sizes), rays};
  return shaded;
}

}  // namespace equilux
