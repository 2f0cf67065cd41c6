// The fast lightcut: light of sixteen VPLs, or the rule at sixteen levels at a time.
#include "renderer/lightcut.h"

#include <algorithm>
#include <atomic>

#include "base/error.h"
#include "renderer/lane_lobe.h"
#include "renderer/node_bounds.h"
#include "renderer/parallel.h"

namespace equilux {
namespace {

constexpr std::size_t kBlockOfSums = 256;  // members summed in float before they go to double

EQ_INLINE Floats3 minus(const Floats3& a, const Floats3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

struct CutJob {
  const World& world;
  const LightTree& tree;
  const Material& material;
  Floats clamps;  // lanes beyond the levels: 0
  std::size_t levels;
  const LightcutParams& params;
  std::size_t base_material;  // of params.base
  const std::vector<std::uint32_t>& top;
};

// A cluster or a single VPL in a cut. Its light at a level is light x min{c, peak_light}, its bound there
// emission x min{c, peak_bound}.
struct Member {
  static constexpr std::uint32_t kSingle = ~0u;
  std::uint32_t node;
  float emission, peak_bound;
  float peak_light;
  Vec3 light;
};

// Per unit of the VPLs' weight: M / largest M x emission x cosine, and the largest M / r^2. Black where
// unseen.
struct LightLanes {
  Floats3 light;
  Floats peak;
};

EQ_INLINE Floats3 eval_m(const Material& material, float cos_v, const Floats& cos_l, const HalfVector& half) {
  const Floats diffuse = cos_l * kInvPi;
  Floats3 m{material.rho_d.x * diffuse, material.rho_d.y * diffuse, material.rho_d.z * diffuse};
  if (material.glossy_share == 0 || !(cos_v > 0)) return m;
  const Floats lobe = eval_lobe(material.model, material.alpha, broadcast(cos_v), cos_l, half);
  m.x += material.rho_s.x * lobe;
  m.y += material.rho_s.y * lobe;
  m.z += material.rho_s.z * lobe;
  return m;
}

LightLanes shade_vpls(const CutJob& job, const ShadingPoint& point, const BoundPoint& frame,
                      const std::uint32_t* ids, std::size_t count, std::uint64_t& rays) {
  const VplList& list = job.tree.vpls;
  Floats3 p, ng, intensity;
  PointPacket targets;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const Vpl& vpl = list.vpls[ids[std::min(lane, count - 1)]];
    set_lane(p, lane, vpl.p);
    set_lane(ng, lane, vpl.ng);
    set_lane(intensity, lane, vpl.intensity);
    const Vec3 target = vpl.p + vpl.ng * vpl.epsilon;
    targets.x[lane] = target.x;
    targets.y[lane] = target.y;
    targets.z[lane] = target.z;
  }
  const Floats3 d = minus(p, splat(point.surface.p));
  const Floats r2 = dot(d, d), inverse = 1.0f / sqrt(r2);
  const Floats3 l{d.x * inverse, d.y * inverse, d.z * inverse};
  const Floats cos_l = dot(splat(frame.shading.n), l), cos_vpl = -dot(ng, l);
  const Ints faced =
      (r2 > 0.0f) & (cos_l > 0.0f) & (dot(splat(point.surface.ng), l) > 0.0f) & (cos_vpl > 0.0f);
  const std::uint32_t wanted = lane_mask(faced) & ((count < kLanes ? 1u << count : 0u) - 1u);
  rays += static_cast<std::uint64_t>(std::popcount(wanted));
  const std::uint32_t visible =
      wanted == 0 ? 0 : job.world.find_visible(point.surface.origin(), targets, wanted);
  const HalfVector half = make_half_vector(dot(splat(frame.shading.s), l) + frame.v.x,
                                           dot(splat(frame.shading.t), l) + frame.v.y, cos_l + frame.v.z);
  const Floats3 m = eval_m(job.material, frame.v.z, cos_l, half);
  Floats3 light{intensity.x * cos_vpl, intensity.y * cos_vpl, intensity.z * cos_vpl};
  for (std::size_t lane = 0; !list.gloss.empty() && lane < count; ++lane) {
    const Vpl& vpl = list.vpls[ids[lane]];
    if (vpl.gloss >= 0) set_lane(light, lane, emit_vpl(list, vpl, {-l.x[lane], -l.y[lane], -l.z[lane]}));
  }
  const Floats largest = max(m.x, max(m.y, m.z));
  const Ints seen = (from_mask(visible) > 0.0f) & (largest > 0.0f);
  const Floats share = 1.0f / largest;
  LightLanes lanes;
  lanes.light = {seen ? m.x * share * light.x : Floats{}, seen ? m.y * share * light.y : Floats{},
                 seen ? m.z * share * light.z : Floats{}};
  lanes.peak = seen ? largest / r2 : Floats{};
  return lanes;
}

class PointCut {
 public:
  explicit PointCut(const CutJob& job) : job_(job) {}

  // From the top of the tree, which most cuts lie below: cuts of few clusters err by too much. Thresholds
  // stay from the point before; none yet: they come from the top.
  void find(const ShadingPoint& point, std::size_t index) {
    point_ = &point;
    frame_.emplace(make_bound_point(point));
    set_base(index);
    kept_.clear();
    open_.clear();
    if (!job_.params.adaptive) {
      thresholds_ = find_thresholds();
      add_nodes({0});
      return refine();
    }
    add_nodes(job_.top);
    if (!has_thresholds_) thresholds_ = find_thresholds();
    has_thresholds_ = true;
    refine();
    for (;;) {
      const Floats wanted = find_thresholds();
      const bool stricter = lane_mask(wanted < thresholds_) != 0;
      thresholds_ = wanted;
      if (!stricter || !reopen()) return;
      refine();
    }
  }

  std::size_t size() const { return kept_.size(); }
  std::uint64_t rays() const { return rays_; }

  // shape: level x channel
  std::array<std::array<double, 3>, kLanes> sum_light() const {
    std::array<std::array<double, 3>, kLanes> sums{};
    for (std::size_t first = 0; first < kept_.size(); first += kBlockOfSums) {
      Floats3 block{};
      const std::size_t last = std::min(kept_.size(), first + kBlockOfSums);
      for (std::size_t i = first; i < last; ++i) {
        const Floats transfer = min(job_.clamps, broadcast(kept_[i].peak_light));
        block.x += kept_[i].light.x * transfer;
        block.y += kept_[i].light.y * transfer;
        block.z += kept_[i].light.z * transfer;
      }
      for (std::size_t level = 0; level < job_.levels; ++level) {
        sums[level][0] += block.x[level];
        sums[level][1] += block.y[level];
        sums[level][2] += block.z[level];
      }
    }
    return sums;
  }

 private:
  void set_base(std::size_t index) {
    base_ = Floats{};
    const ShadedPoints* base = job_.params.base;
    for (std::size_t level = 0; base && level < job_.levels; ++level)
      base_[level] = luminance(base->radiance[base->index(job_.base_material, level, index)]);
  }

  Floats find_thresholds() const {
    Floats total = base_;
    for (const auto* part : {&kept_, &open_}) {
      for (const Member& member : *part)
        total += luminance(member.light) * min(job_.clamps, broadcast(member.peak_light));
    }
    return static_cast<float>(job_.params.error_ratio) *
           max(total, broadcast(static_cast<float>(job_.params.floor)));
  }

  bool keeps_rule(const Member& member) const {
    if (member.node == Member::kSingle) return true;
    const Floats bound = member.emission * min(job_.clamps, broadcast(member.peak_bound));
    return lane_mask(bound > thresholds_) == 0;
  }

  // Clusters that break the rule are looked at again; true if there are any.
  bool reopen() {
    const auto breaks =
        std::partition(kept_.begin(), kept_.end(), [&](const Member& member) { return keeps_rule(member); });
    open_.assign(breaks, kept_.end());
    kept_.erase(breaks, kept_.end());
    return !open_.empty();
  }

  void refine() {
    std::array<Member, kLanes> batch;
    while (!open_.empty()) {
      std::size_t count = 0;
      while (!open_.empty() && count < kLanes) {
        const Member member = open_.back();
        open_.pop_back();
        if (keeps_rule(member)) {
          kept_.push_back(member);
        } else {
          batch[count++] = member;
        }
      }
      if (count > 0) split(batch.data(), count);
    }
  }

  // Children that have their parent's representative have its light, by their share of the weight.
  void split(const Member* batch, std::size_t count) {
    const auto& nodes = job_.tree.nodes;
    nodes_.clear();
    vpls_.clear();
    for (std::size_t i = 0; i < count; ++i) {
      const LightNode& node = nodes[batch[i].node];
      const float per_weight = node.weight > 0 ? 1 / node.weight : 0;
      if (node.leaf_count > 0) {
        split_leaf(batch[i], node, per_weight);
        continue;
      }
      for (std::uint32_t child : {batch[i].node + 1, node.next}) {
        Member member{child, 0, 0, 0, {}};
        if (nodes[child].representative == node.representative) {
          member.peak_light = batch[i].peak_light;
          member.light = batch[i].light * (nodes[child].weight * per_weight);
        } else {
          vpls_.push_back({nodes[child].representative, open_.size(), true});
        }
        nodes_.push_back(child);
        open_.push_back(member);
      }
    }
    bound_last();
    shade_last();
  }

  void split_leaf(const Member& member, const LightNode& node, float per_weight) {
    for (std::uint32_t i = node.next; i < node.next + node.leaf_count; ++i) {
      Member single{Member::kSingle, 0, 0, 0, {}};
      if (i == node.representative) {
        single.peak_light = member.peak_light;
        single.light = member.light * (weigh_vpl(job_.tree.vpls, i) * per_weight);
      } else {
        vpls_.push_back({i, kept_.size(), false});
      }
      kept_.push_back(single);
    }
  }

  void add_nodes(const std::vector<std::uint32_t>& ids) {
    nodes_ = ids;
    vpls_.clear();
    for (std::uint32_t id : ids) {
      vpls_.push_back({job_.tree.nodes[id].representative, open_.size(), true});
      open_.push_back({id, 0, 0, 0, {}});
    }
    bound_last();
    shade_last();
  }

  // The members that were opened last are those of nodes_.
  void bound_last() {
    const std::size_t start = open_.size() - nodes_.size();
    for (std::size_t first = 0; first < nodes_.size(); first += kLanes) {
      const std::size_t count = std::min(kLanes, nodes_.size() - first);
      const NodeBounds bounds = bound_nodes(job_.tree, job_.material, *frame_, &nodes_[first], count);
      for (std::size_t lane = 0; lane < count; ++lane) {
        open_[start + first + lane].emission = bounds.emission[lane];
        open_[start + first + lane].peak_bound = bounds.peak[lane];
      }
    }
  }

  void shade_last() {
    std::array<std::uint32_t, kLanes> ids;
    for (std::size_t first = 0; first < vpls_.size(); first += kLanes) {
      const std::size_t count = std::min(kLanes, vpls_.size() - first);
      for (std::size_t lane = 0; lane < count; ++lane) ids[lane] = vpls_[first + lane].vpl;
      const LightLanes lanes = shade_vpls(job_, *point_, *frame_, ids.data(), count, rays_);
      for (std::size_t lane = 0; lane < count; ++lane) {
        const Pending& pending = vpls_[first + lane];
        Member& member = pending.is_open ? open_[pending.place] : kept_[pending.place];
        const float scale = pending.is_open ? scale_to(member.node, pending.vpl) : 1;
        member.peak_light = lanes.peak[lane];
        member.light = Vec3{lanes.light.x[lane], lanes.light.y[lane], lanes.light.z[lane]} * scale;
      }
    }
  }

  // How many times its representative's light a cluster's is.
  float scale_to(std::uint32_t node, std::uint32_t vpl) const {
    const float weight = weigh_vpl(job_.tree.vpls, vpl);
    return weight > 0 ? job_.tree.nodes[node].weight / weight : 0;
  }

  // A VPL whose light a member waits for.
  struct Pending {
    std::uint32_t vpl;
    std::size_t place;
    bool is_open;  // among open_, else among kept_
  };

  const CutJob& job_;
  const ShadingPoint* point_ = nullptr;
  std::optional<BoundPoint> frame_;
  Floats base_{}, thresholds_{};
  bool has_thresholds_ = false;
  std::vector<Member> kept_, open_;
  std::vector<std::uint32_t> nodes_;
  std::vector<Pending> vpls_;
  std::uint64_t rays_ = 0;
};

// Some hundred clusters from level by level.
std::vector<std::uint32_t> find_top(const LightTree& tree) {
  constexpr std::size_t kEnough = 256;
  std::vector<std::uint32_t> top{0};
  for (std::size_t before = 0; before < top.size() && top.size() < kEnough;) {
    before = top.size();
    std::vector<std::uint32_t> next;
    for (std::uint32_t index : top) {
      const LightNode& node = tree.nodes[index];
      next.push_back(node.leaf_count == 0 ? index + 1 : index);
      if (node.leaf_count == 0) next.push_back(node.next);
    }
    top = std::move(next);
  }
  return top;
}

void cut_block(const CutJob& job, const std::vector<ShadingPoint>& points, std::size_t first,
               std::size_t last, std::size_t material, ShadedPoints& shaded,
               std::vector<std::uint32_t>& sizes, std::atomic<std::uint64_t>& rays) {
  PointCut cut(job);
  for (std::size_t i = first; i < last; ++i) {
    cut.find(points[i], i);
    sizes[i] += static_cast<std::uint32_t>(cut.size());
    const auto sums = cut.sum_light();
    for (std::size_t level = 0; level < job.levels; ++level) {
      const auto& sum = sums[level];
      shaded.radiance[shaded.index(material, level, i)] = {
          static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
    }
  }
  rays += cut.rays();
  if (job.params.progress) job.params.progress(static_cast<double>(last - first));
}

}  // namespace

ShadedPoints shade_lightcut(const World& world, const std::vector<ShadingPoint>& points,
                            const LightTree& tree, const std::vector<Material>& materials,
                            const std::vector<double>& clamps_per_m2, const LightcutParams& params,
                            CutRecord* record) {
  EQ_CHECK(params.error_ratio >= 0 && params.floor >= 0, params.error_ratio, params.floor);
  EQ_CHECK(clamps_per_m2.size() <= kLanes, clamps_per_m2.size());
  ShadedPoints shaded{clamps_per_m2.size(), points.size(), {}, 0};
  shaded.radiance.resize(materials.size() * shaded.levels * shaded.points);
  std::vector<std::uint32_t> sizes(points.size());
  std::atomic<std::uint64_t> rays = 0;
  const std::vector<std::uint32_t> top = tree.empty() ? std::vector<std::uint32_t>{} : find_top(tree);
  Floats clamps{};
  for (std::size_t level = 0; level < clamps_per_m2.size(); ++level)
    clamps[level] = static_cast<float>(clamps_per_m2[level]);
  for (std::size_t m = 0; m < materials.size() && !tree.empty(); ++m) {
    const CutJob job{world, tree, materials[m], clamps, clamps_per_m2.size(), params, m, top};
    for_each_parallel((points.size() + kCutBlock - 1) / kCutBlock, [&](std::size_t block) {
      const std::size_t first = block * kCutBlock, last = std::min(points.size(), first + kCutBlock);
      cut_block(job, points, first, last, m, shaded, sizes, rays);
    });
  }
  check_finite(shaded);
  if (record) *record = {std::move(sizes), rays};
  return shaded;
}

}  // namespace equilux
