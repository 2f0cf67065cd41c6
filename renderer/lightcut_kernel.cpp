// The fast lightcut: the samples of a pixel, or neighbours, walk the tree together, each with a cut of its
// own. Sixteen lanes are S samples by 16 / S nodes or lights; lane = slot x S + sample. A sample at which a
// node keeps the rule stays behind where others go on: it goes down with the children that have the node's
// representative, to be lit by the ray that others ask for there, and asks for none itself.
#include <algorithm>
#include <atomic>
#include <bit>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>

#include "base/error.h"
#include "renderer/cut_groups.h"
#include "renderer/cut_light.h"
#include "renderer/cut_sums.h"
#include "renderer/kernels.h"
#include "renderer/parallel.h"

// After all other headers.
// clang-format off
#include "renderer/isa_begin.h"
// clang-format on

namespace equilux::EQ_ISA {
namespace {

// Luminance at each material and level, as the group before had it on average.
struct Totals {
  bool known = false;
  std::vector<float> luminance;
};

template <std::size_t S>
class GroupCut {
 public:
  static constexpr std::size_t kSlots = kLanes / S;

  explicit GroupCut(const CutJob& job)
      : job_(job),
        members_(job.materials.size(), job.grey),
        least_thresholds_(job.materials.size(), zeros()),
        thresholds_(job.materials.size() * job.levels, zeros()),
        base_(thresholds_),
        sums_(job),
        light_(job) {
    bounds_.reserve(kLanes);
  }

  // From the top of the tree, which most cuts lie below: cuts of few clusters err by too much. Thresholds
  // stay from the group before; none yet: they come from the top. Rounds follow until the rule holds with the
  // group's own totals. Within a round thresholds stand, so that light is asked for of what is left alone.
  void find(PointRange range, Totals& before) {
    set_points(range);
    set_base(range);
    members_.clear();
    lit_ = 0;
    dark_ = zeros();
    const auto& top = job_.params.adaptive ? job_.top : kRoot;
    open_.make_room(top.size());
    for (std::uint32_t node : top) open_.push({node, kNone, (1u << range.count) - 1u});
    if (!job_.params.adaptive) {
      set_thresholds(base_);
      if (job_.params.roulette.share > 0) light_.start(base_, range.first);
    } else if (before.known) {
      expand_totals(before);
    } else {
      thresholds_.assign(thresholds_.size(), broadcast(std::numeric_limits<float>::infinity()));
      find_least_thresholds();
    }
    for (;;) {
      refine();
      members_.close();
      light_.shade(points_, members_, lit_);
      lit_ = members_.size();
      if (!job_.params.adaptive) return;
      const std::vector<Floats> totals = sums_.find_totals(members_, base_);
      const std::vector<Floats> old = thresholds_;
      set_thresholds(totals);
      keep_totals(totals, range.count, before);
      bool stricter = false;
      for (std::size_t i = 0; i < old.size(); ++i) stricter |= any(thresholds_[i] < old[i]);
      if (!stricter || !reopen()) return;
    }
  }

  std::uint64_t rays() const { return light_.rays(); }

  // Of each sample's cut, those without light included.
  std::array<std::uint32_t, S> sizes() const {
    Floats counts = dark_;
    for (std::size_t block = 0; block < members_.blocks(); ++block) {
      const Floats weight = members_.block(block, Table::kWeight);
      counts += select((weight > 0.0f) | (weight < 0.0f), broadcast(1), zeros());
    }
    std::array<std::uint32_t, S> sizes{};
    const auto lanes = to_array(counts);
    for (std::size_t lane = 0; lane < kLanes; ++lane)
      sizes[lane % S] += static_cast<std::uint32_t>(lanes[lane]);
    return sizes;
  }

  // Into the places of the group's points.
  void write_light(PointRange range, ShadedPoints& shaded) const { sums_.write(members_, range, shaded); }

 private:
  using Table = Members<S>;
  static constexpr std::uint32_t kNone = ~0u;
  // A slot's lanes: S ones.
  static constexpr std::uint32_t kSlot = S == kLanes ? 0xffffu : (1u << S) - 1u;
  // The first lane of each slot.
  static constexpr std::uint32_t kFirstLanes = S == 1   ? 0xffffu
                                               : S == 2 ? 0x5555u
                                               : S == 4 ? 0x1111u
                                               : S == 8 ? 0x0101u
                                                        : 1u;
  static inline const std::vector<std::uint32_t> kRoot{0};

  // A node to look at for some samples; `member`: the one of its representative that stands for clusters
  // above it, or kNone.
  struct Open {
    std::uint32_t node, member, samples;
  };

  // The last point stands for those beyond, which have no cut.
  void set_points(PointRange range) {
    Lane3 ng, origins;
    bounds_.clear();
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::size_t sample = std::min(lane % S, range.count - 1);
      const ShadingPoint& point = job_.points[range.first + sample];
      bounds_.push_back(lane < S ? make_bound_point(point) : BoundPoint(bounds_[lane % S]));
      ng.set(lane, point.surface.ng);
      origins.set(lane, point.surface.origin());
    }
    points_ = {load_points(bounds_), load(ng), load(origins)};
  }

  std::size_t index_of(std::size_t material, std::size_t level) const {
    return material * job_.levels + level;
  }

  void set_base(PointRange range) {
    const ShadedPoints* base = job_.params.base;
    if (!base) return;
    for (std::size_t m = 0; m < job_.materials.size(); ++m) {
      for (std::size_t level = 0; level < job_.levels; ++level) {
        std::array<float, S> samples;
        for (std::size_t i = 0; i < S; ++i)
          samples[i] =
              luminance(base->radiance[base->index(m, level, range.first + std::min(i, range.count - 1))]);
        base_[index_of(m, level)] = tile<S>(samples.data());
      }
    }
  }

  void set_thresholds(const std::vector<Floats>& totals) {
    const Floats floor = broadcast(static_cast<float>(job_.params.floor));
    for (std::size_t i = 0; i < totals.size(); ++i)
      thresholds_[i] = static_cast<float>(job_.params.error_ratio) * max(totals[i], floor);
    find_least_thresholds();
  }

  void find_least_thresholds() {
    for (std::size_t m = 0; m < job_.materials.size(); ++m) {
      Floats& least = least_thresholds_[m] = thresholds_[index_of(m, 0)];
      for (std::size_t level = 1; level < job_.levels; ++level)
        least = min(least, thresholds_[index_of(m, level)]);
    }
  }

  void expand_totals(const Totals& before) {
    std::vector<Floats> totals;
    for (float luminance : before.luminance) totals.push_back(broadcast(luminance));
    set_thresholds(totals);
  }

  static void keep_totals(const std::vector<Floats>& totals, std::size_t count, Totals& kept) {
    kept.known = true;
    kept.luminance.clear();
    for (const Floats& total : totals) {
      const auto lanes = to_array(total);
      kept.luminance.push_back(std::accumulate(lanes.begin(), lanes.begin() + count, 0.0f) /
                               static_cast<float>(count));
    }
  }

  // Looks at all open nodes, level by level of the tree: samples at which a node keeps the rule at every
  // material and level have it in their cut, for the others it gives way to its children.
  void refine() {
    constexpr std::size_t kAhead = 4 * kLanes;
    std::array<std::uint32_t, kLanes> ids;
    for (std::size_t first = 0, count; first < open_.size(); first += count) {
      count = std::min(kLanes, open_.size() - first);
      for (std::size_t i = 0; i < count; ++i) {
        ids[i] = open_[first + i].node;
        if (first + i + kAhead < open_.size())
          __builtin_prefetch(&job_.tree.nodes[open_[first + i + kAhead].node]);
      }
      std::fill(ids.begin() + count, ids.end(), ids[count - 1]);
      open_.make_room(2 * count);
      const NodeLanes nodes = load_nodes(job_.tree, ids.data(), count);
      for (std::size_t slot = 0; slot < count; slot += kSlots)
        look_at(first + slot, spread<S>(nodes, slot / kSlots),
                spread<S>(load_bits(ids.data()), slot / kSlots), std::min(kSlots, count - slot));
    }
    open_.clear();
  }

  // What is known of nodes that were looked at.
  struct Looked {
    Floats weight, ids, emission;
    std::array<Floats, kMostMaterials> peaks;
  };

  void look_at(std::size_t first, const NodeLanes& nodes, Floats ids, std::size_t count) {
    std::uint32_t asked = 0, joins = 0;
    for (std::size_t slot = 0; slot < count; ++slot) {
      asked |= open_[first + slot].samples << (slot * S);
      if (open_[first + slot].member != kNone) joins |= kSlot << (slot * S);
    }
    LaneBound bound = bound_lanes(nodes, points_.lanes, !job_.lobes.empty());
    if (!job_.tree.gloss.empty()) bound.emission = bound_glossy_emission(first, count);
    const std::uint32_t emits = lane_mask(bound.emission > 0.0f) & asked;
    std::uint32_t breaks = 0, lit = 0;
    Looked looked;  // peaks are set as far as they are needed
    looked.weight = nodes.weight;
    looked.ids = ids;
    looked.emission = bound.emission;
    std::array<Floats, kMostMaterials> lobes;
    lobes[0] = zeros();
    for (std::size_t i = 0; i < job_.lobes.size(); ++i)
      lobes[i] = bound_lobe(job_.lobes[i], points_.lanes, bound);
    // Zero by infinite is not a number, which breaks no rule.
    for (std::size_t m = 0; m < job_.materials.size() && breaks != asked; ++m) {
      looked.peaks[m] = bound_peak(job_.materials[m], bound, lobes[job_.lobe_of[m]]);
      lit |= lane_mask(looked.peaks[m] > 0.0f) & emits;
      breaks |= find_breaks(m, bound.emission, looked.peaks[m], emits);
    }
    if (breaks == asked) {
      for (std::size_t i = first; i < first + count; ++i) split(Open(open_[i]));
      return;
    }
    make_room(0);
    dark_ += select(from_lane_mask(asked & ~breaks & ~lit), broadcast(1), zeros());
    const std::uint32_t kept = lit & ~breaks, added = fill_slots(kept & ~joins);
    join(first, looked, kept, asked & ~breaks & joins);
    const std::size_t next = members_.size();
    add_members(first, looked, kept, added);
    for (std::uint32_t left = fill_slots(breaks) & kFirstLanes; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      Open open = open_[first + lane / S];
      open.samples = (breaks >> lane) & kSlot;
      if ((added >> lane) & 1u) open.member = static_cast<std::uint32_t>(next + rank(added, lane));
      split(open);
    }
  }

  // Of the slot of a first lane among those of `slots`.
  static std::size_t rank(std::uint32_t slots, std::size_t lane) {
    return static_cast<std::size_t>(std::popcount(slots & kFirstLanes & ((1u << lane) - 1u)));
  }

  // Members for the slots of `added`, for the samples of `kept` among them.
  void add_members(std::size_t first, const Looked& looked, std::uint32_t kept, std::uint32_t added) {
    if (added == 0) return;
    const std::size_t next = members_.size();
    const Mask in = from_lane_mask(kept);
    const auto append = [&](std::size_t column, Floats values) {
      store_compressed(members_.at(next, column), values, added);
    };
    append(Table::kWeight, select(in, looked.weight, zeros()));
    append(Table::kNode, looked.ids);
    append(Table::kEmission, select(in, looked.emission, zeros()));
    for (std::size_t m = 0; m < job_.materials.size(); ++m) append(members_.bound_of(m), looked.peaks[m]);
    for (std::uint32_t left = added & kFirstLanes; left != 0; left &= left - 1) {
      const std::size_t slot = static_cast<std::size_t>(std::countr_zero(left)) / S;
      members_.add(job_.tree.nodes[open_[first + slot].node].representative);
    }
  }

  // Samples of `ends` come to the members that their nodes were opened with; those of `kept` have light.
  void join(std::size_t first, const Looked& looked, std::uint32_t kept, std::uint32_t ends) {
    if (ends == 0) return;
    const Mask in = from_lane_mask(kept);
    const Floats weight = select(in, looked.weight, zeros());
    const Floats emission = select(in, looked.emission, zeros());
    for (std::uint32_t left = fill_slots(ends) & kFirstLanes; left != 0; left &= left - 1) {
      const std::size_t lane = static_cast<std::size_t>(std::countr_zero(left));
      const std::uint32_t lanes = ends & (kSlot << lane), member = open_[first + lane / S].member;
      if (member < lit_) scale_light(member, lane, lanes, weight);
      const auto put = [&](std::size_t column, Floats values) {
        store_some(members_.at(member, column) - lane, values, lanes);
      };
      put(Table::kWeight, weight);
      put(Table::kNode, looked.ids);
      put(Table::kEmission, emission);
      for (std::size_t m = 0; m < job_.materials.size(); ++m) put(members_.bound_of(m), looked.peaks[m]);
    }
  }

  // Light that a member has already, for another cluster of the same representative. The member's first
  // sample is at `lane`.
  void scale_light(std::size_t member, std::size_t lane, std::uint32_t lanes, Floats weight) {
    const Floats before = load(members_.at(member, Table::kWeight) - lane);
    const Floats share = select(before > 0.0f, weight / before, zeros());
    for (std::size_t column = members_.first_of_light(); column < members_.columns(); ++column) {
      float* light = members_.at(member, column) - lane;
      store_some(light, load(light) * share, lanes);
    }
  }

  // Of slots in which any lane does, all lanes.
  static std::uint32_t fill_slots(std::uint32_t lanes) {
    for (std::size_t step = 1; step < S; step *= 2) lanes |= lanes >> step;
    lanes &= kFirstLanes;
    for (std::size_t step = 1; step < S; step *= 2) lanes |= lanes << step;
    return lanes;
  }

  // Lanes whose bound is above the threshold at any level, of those in `asked`. Most bounds are under all
  // levels' thresholds even without a clamp.
  EQ_INLINE std::uint32_t find_breaks(std::size_t material, Floats emission, Floats bound,
                                      std::uint32_t asked) const {
    const std::uint32_t unclear = lane_mask(emission * bound > least_thresholds_[material]) & asked;
    std::uint32_t breaks = 0;
    for (std::size_t level = job_.levels; level-- > 0 && breaks != unclear;)
      breaks |= lane_mask(emission * min(broadcast(job_.clamps_per_m2[level]), bound) >
                          thresholds_[index_of(material, level)]) &
                unclear;
    return breaks;
  }

  // For members of a leaf, and always for those of one look besides.
  void make_room(std::size_t singles) { members_.make_room(singles + kSlots); }

  void split(const Open& open) {
    const LightNode& node = job_.tree.nodes[open.node];
    if (node.leaf_count == 0) {
      open_.push({node.next, open.member, open.samples});
      open_.push({node.next + 1, kNone, open.samples});
      return;
    }
    make_room(node.leaf_count);
    for (std::uint32_t vpl = node.next; vpl < node.next + node.leaf_count; ++vpl) {
      std::size_t member = open.member;
      if (member == kNone || vpl != node.representative) {
        member = members_.size();
        members_.add(vpl);
        store(members_.at(member, Table::kWeight), zeros());
        store(members_.at(member, Table::kEmission), zeros());
      }
      if (member < lit_) scale_light(member, 0, open.samples, broadcast(weigh_vpl(job_.tree.vpls, vpl)));
      store_some(members_.at(member, Table::kWeight), broadcast(-1), open.samples);
      store_some(members_.at(member, Table::kEmission), zeros(), open.samples);
    }
  }

  // Samples at which a member breaks the rule look at its node again; true if there are any.
  bool reopen() {
    for (std::size_t block = 0; block < members_.blocks(); ++block) {
      const Floats emission = members_.block(block, Table::kEmission);
      std::uint32_t breaks = 0;
      for (std::size_t m = 0; m < job_.materials.size(); ++m)
        breaks |= find_breaks(m, emission, members_.block(block, members_.bound_of(m)), 0xffffu);
      for (std::uint32_t left = fill_slots(breaks) & kFirstLanes; left != 0; left &= left - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(left));
        reopen(static_cast<std::uint32_t>(block * kSlots + lane / S), (breaks >> lane) & kSlot);
      }
    }
    return !open_.empty();
  }

  // Samples may have it for different nodes.
  void reopen(std::uint32_t member, std::uint32_t samples) {
    open_.make_room(S);
    while (samples != 0) {
      const std::uint32_t node = members_.node(member, static_cast<std::size_t>(std::countr_zero(samples)));
      std::uint32_t same = 0;
      for (std::uint32_t left = samples; left != 0; left &= left - 1) {
        const auto sample = static_cast<std::size_t>(std::countr_zero(left));
        if (members_.node(member, sample) == node) same |= 1u << sample;
      }
      open_.push({node, member, same});
      samples &= ~same;
    }
  }

  // VPLs with gloss are few, and their bounds long.
  Floats bound_glossy_emission(std::size_t first, std::size_t count) const {
    std::array<float, kLanes> emission{};
    for (std::size_t lane = 0; lane < count * S; ++lane) {
      const std::uint32_t node = open_[first + lane / S].node;
      const Cluster cluster = unpack_cluster(job_.tree, job_.tree.nodes[node]);
      emission[lane] = bound_emission(bounds_[lane].p, cluster, &job_.tree.gloss[node]);
    }
    return load(emission.data());
  }

  const CutJob& job_;
  Table members_;
  std::vector<Floats> least_thresholds_;   // over levels. shape: material
  std::vector<Floats> thresholds_, base_;  // of each sample, in every slot. shape: material x level
  std::vector<BoundPoint> bounds_;         // shape: kLanes
  GroupPoints points_;
  Pile<Open> open_;
  Floats dark_ = zeros();  // clusters without light in each lane's cut
  std::size_t lit_ = 0;    // members that have their light
  MemberSums<S> sums_;
  MemberLight<S> light_;
};

// The cuts of one thread, made as their widths are met.
class Cuts {
 public:
  explicit Cuts(const CutJob& job) : job_(job) {}

  // `sizes`: of all points' cuts.
  void shade(PointRange range, ShadedPoints& shaded, std::vector<std::uint32_t>& sizes) {
    if (range.count == 1) return shade_by(one_, range, shaded, sizes);
    if (range.count == 2) return shade_by(two_, range, shaded, sizes);
    if (range.count <= 4) return shade_by(four_, range, shaded, sizes);
    if (range.count <= 8) return shade_by(eight_, range, shaded, sizes);
    return shade_by(sixteen_, range, shaded, sizes);
  }

  std::uint64_t rays() const { return rays_; }

 private:
  template <std::size_t S>
  void shade_by(std::optional<GroupCut<S>>& cut, PointRange range, ShadedPoints& shaded,
                std::vector<std::uint32_t>& sizes) {
    if (!cut) cut.emplace(job_);
    const std::uint64_t before = cut->rays();
    cut->find(range, totals_);
    cut->write_light(range, shaded);
    rays_ += cut->rays() - before;
    std::copy_n(cut->sizes().begin(), range.count, sizes.begin() + static_cast<std::ptrdiff_t>(range.first));
  }

  const CutJob& job_;
  Totals totals_;
  std::optional<GroupCut<1>> one_;
  std::optional<GroupCut<2>> two_;
  std::optional<GroupCut<4>> four_;
  std::optional<GroupCut<8>> eight_;
  std::optional<GroupCut<16>> sixteen_;
  std::uint64_t rays_ = 0;
};

}  // namespace

ShadedPoints shade_lightcut(const World& world, const std::vector<ShadingPoint>& points,
                            const LightTree& tree, const std::vector<Material>& materials,
                            const std::vector<double>& clamps_per_m2, const LightcutParams& params,
                            CutRecord* record) {
  EQ_CHECK(params.error_ratio >= 0 && params.floor >= 0, params.error_ratio, params.floor);
  EQ_CHECK(params.roulette.share == 0 || (params.roulette.share > 0 && params.base && !params.adaptive),
           params.roulette.share);
  EQ_CHECK(!clamps_per_m2.empty() && clamps_per_m2.size() <= kLanes, clamps_per_m2.size());
  EQ_CHECK(materials.size() <= kMostMaterials, materials.size());
  ShadedPoints shaded{clamps_per_m2.size(), points.size(), {}, 0};
  shaded.radiance.resize(materials.size() * shaded.levels * shaded.points);
  std::vector<std::uint32_t> sizes(points.size());
  std::atomic<std::uint64_t> rays = 0;
  if (!tree.empty()) {
    const std::vector<std::uint32_t> top = find_top(tree);
    std::vector<float> clamps(clamps_per_m2.begin(), clamps_per_m2.end());
    CutJob job{world, points, tree, materials, {}, {}, true, clamps, clamps_per_m2.size(), params, top};
    for (const Material& material : materials) add_material(material, job);
    const std::vector<PointRange> groups = group_points(points, kLanes, params.neighbours);
    for_each_parallel((groups.size() + kCutBlock - 1) / kCutBlock, [&](std::size_t block) {
      const std::size_t first = block * kCutBlock, last = std::min(groups.size(), first + kCutBlock);
      Cuts cuts(job);
      std::size_t done = 0;
      for (std::size_t i = first; i < last; ++i) {
        cuts.shade(groups[i], shaded, sizes);
        done += groups[i].count;
      }
      rays += cuts.rays();
      if (params.progress) params.progress(static_cast<double>(done));
    });
  }
  check_finite(shaded);
  if (record) *record = {std::move(sizes), rays};
  return shaded;
}

}  // namespace equilux::EQ_ISA

#include "renderer/isa_end.h"
