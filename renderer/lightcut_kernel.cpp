// The fast lightcut: one cut for the samples of a pixel. Sixteen lanes are S samples by 16 / S nodes or
// lights; lane = slot x S + sample.
#include <algorithm>
#include <atomic>
#include <bit>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>

#include "base/error.h"
#include "renderer/cut_groups.h"
#include "renderer/cut_members.h"
#include "renderer/kernels.h"
#include "renderer/lane_bounds.h"
#include "renderer/lane_rays.h"
#include "renderer/parallel.h"

// After all other headers.
// clang-format off
#include "renderer/isa_begin.h"
// clang-format on

namespace equilux::EQ_ISA {
namespace {

constexpr std::size_t kBlocksOfSums = 32;  // blocks of members summed in float before they go to double

struct CutJob {
  const World& world;
  const std::vector<ShadingPoint>& points;
  const LightTree& tree;
  const std::vector<Material>& materials;
  std::vector<Lobe> lobes;           // of all glossy materials, each once
  std::vector<std::size_t> lobe_of;  // each material's, if it is glossy
  bool grey;                         // all materials are: their light differs by one factor
  std::vector<float> clamps_per_m2;
  std::size_t levels;
  const LightcutParams& params;
  const std::vector<std::uint32_t>& top;
};

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
        queue_(job.world, S > 1, job.params.watch_rays) {
    bounds_.reserve(kLanes);
  }

  // From the top of the tree, which most cuts lie below: cuts of few clusters err by too much. Thresholds
  // stay from the group before; none yet: they come from the top. Rounds follow until the rule holds with the
  // group's own totals. Within a round thresholds stand, so that light is asked for of what is left alone.
  void find(PointRange range, Totals& before) {
    set_points(range);
    set_base(range);
    members_.clear();
    const auto& top = job_.params.adaptive ? job_.top : kRoot;
    open_.make_room(top.size());
    for (std::uint32_t node : top) open_.push({node, kNone});
    if (!job_.params.adaptive) {
      set_thresholds(base_);
    } else if (before.known) {
      expand_totals(before);
    } else {
      thresholds_.assign(thresholds_.size(), broadcast(std::numeric_limits<float>::infinity()));
      find_least_thresholds();
    }
    for (;;) {
      refine();
      members_.close();
      shade();
      if (!job_.params.adaptive) return;
      const std::vector<Floats> totals = sum_luminance();
      const std::vector<Floats> old = thresholds_;
      set_thresholds(totals);
      keep_totals(totals, before);
      bool stricter = false;
      for (std::size_t i = 0; i < old.size(); ++i) stricter |= any(thresholds_[i] < old[i]);
      if (!stricter || !reopen()) return;
    }
  }

  std::size_t size() const { return members_.size(); }
  std::uint64_t rays() const { return queue_.rays(); }

  // Into the places of the group's points.
  void write_light(PointRange range, ShadedPoints& shaded) const {
    constexpr std::size_t kAtOnce = 4;
    for (std::size_t m = 0; m < job_.materials.size(); ++m) {
      std::size_t level = 0;
      for (; level + kAtOnce <= job_.levels; level += kAtOnce) write_levels<kAtOnce>(m, level, range, shaded);
      for (; level < job_.levels; ++level) write_levels<1>(m, level, range, shaded);
    }
  }

 private:
  using Table = Members<S>;
  static constexpr std::uint32_t kNone = ~0u;
  // The first lane of each slot.
  static constexpr std::uint32_t kFirstLanes = S == 1   ? 0xffffu
                                               : S == 2 ? 0x5555u
                                               : S == 4 ? 0x1111u
                                               : S == 8 ? 0x0101u
                                                        : 1u;
  static inline const std::vector<std::uint32_t> kRoot{0};

  // A node to look at; `heir`: a released member of the same representative, or kNone.
  struct Open {
    std::uint32_t node, heir;
  };

  // The last point stands for those beyond; its rays are not traced.
  void set_points(PointRange range) {
    Lane3 ng, origins;
    valid_ = 0;
    bounds_.clear();
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::size_t sample = std::min(lane % S, range.count - 1);
      const ShadingPoint& point = job_.points[range.first + sample];
      bounds_.push_back(lane < S ? make_bound_point(point) : BoundPoint(bounds_[lane % S]));
      ng.set(lane, point.surface.ng);
      origins.set(lane, point.surface.origin());
      if (lane % S < range.count) valid_ |= 1u << lane;
    }
    lanes_ = load_points(bounds_);
    ng_ = load(ng);
    origins_ = load(origins);
  }

  template <std::size_t kLevels>
  void write_levels(std::size_t m, std::size_t first, PointRange range, ShadedPoints& shaded) const {
    const auto sums = sum_light<kLevels>(m, first);
    for (std::size_t i = 0; i < kLevels; ++i) {
      for (std::size_t sample = 0; sample < range.count; ++sample)
        shaded.radiance[shaded.index(m, first + i, range.first + sample)] = {
            static_cast<float>(sums[i][0][sample]), static_cast<float>(sums[i][1][sample]),
            static_cast<float>(sums[i][2][sample])};
    }
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

  void keep_totals(const std::vector<Floats>& totals, Totals& kept) const {
    kept.known = true;
    kept.luminance.clear();
    for (const Floats& total : totals) {
      const auto lanes = to_array(total);
      kept.luminance.push_back(std::accumulate(lanes.begin(), lanes.begin() + S, 0.0f) /
                               static_cast<float>(S));
    }
  }

  // Looks at all open nodes, level by level of the tree: those that keep the rule at every sample, material
  // and level become members, the others give way to their children.
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
      open_.make_room(2 * count);
      const NodeLanes nodes = load_nodes(job_.tree, ids.data(), count);
      for (std::size_t slot = 0; slot < count; slot += kSlots)
        look_at(first + slot, spread<S>(nodes, slot / kSlots), &ids[slot], std::min(kSlots, count - slot));
    }
    open_.clear();
  }

  void look_at(std::size_t first, const NodeLanes& nodes, const std::uint32_t* ids, std::size_t count) {
    LaneBound bound = bound_lanes(nodes, lanes_, !job_.lobes.empty());
    if (!job_.tree.gloss.empty()) bound.emission = bound_glossy_emission(ids, count);
    const std::uint32_t asked = count < kSlots ? (1u << (count * S)) - 1u : 0xffffu;
    const std::uint32_t emits = lane_mask(bound.emission > 0.0f) & asked;
    std::uint32_t breaks = 0, lit = 0;
    std::array<Floats, kMostMaterials> peaks;
    std::array<Floats, kMostMaterials> lobes;
    lobes[0] = zeros();
    for (std::size_t i = 0; i < job_.lobes.size(); ++i) lobes[i] = bound_lobe(job_.lobes[i], lanes_, bound);
    // Zero by infinite is not a number, which breaks no rule.
    for (std::size_t m = 0; m < job_.materials.size() && breaks != asked; ++m) {
      peaks[m] = bound_peak(job_.materials[m], bound, lobes[job_.lobe_of[m]]);
      lit |= lane_mask(peaks[m] > 0.0f) & emits;
      breaks |= find_breaks(m, bound.emission, peaks[m], emits);
    }
    if (breaks == asked) {
      for (std::size_t i = first; i < first + count; ++i) {
        const Open open = open_[i];
        split(open, job_.tree.nodes[open.node]);
      }
      return;
    }
    make_room(0);
    const auto emission = to_array(bound.emission);
    std::array<std::array<float, kLanes>, kMostMaterials> peak_lanes;
    for (std::size_t m = 0; m < job_.materials.size(); ++m) peak_lanes[m] = to_array(peaks[m]);
    for (std::size_t slot = 0; slot < count; ++slot) {
      const Open open = open_[first + slot];
      const LightNode& node = job_.tree.nodes[open.node];
      if ((breaks & lanes_of(slot)) != 0) {
        split(open, node);
        continue;
      }
      const std::uint32_t member =
          add_member(open.node, node.representative, open.heir, node.weight, node.weight);
      if ((lit & lanes_of(slot)) == 0) {
        members_.darken(member, 0, open.heir == kNone ? members_.columns() : members_.peak_of(0));
        continue;
      }
      if (open.heir == kNone) unlit_.push(member);
      std::memcpy(members_.at(member, Table::kEmission), &emission[slot * S], S * sizeof(float));
      for (std::size_t m = 0; m < job_.materials.size(); ++m)
        std::memcpy(members_.at(member, members_.bound_of(m)), &peak_lanes[m][slot * S], S * sizeof(float));
    }
  }

  // A slot's lanes: S ones.
  static constexpr std::uint32_t kSlot = S == kLanes ? 0xffffu : (1u << S) - 1u;
  static std::uint32_t lanes_of(std::size_t slot) { return kSlot << (slot * S); }

  // Of slots in which any lane does, all lanes.
  static std::uint32_t fill_slots(std::uint32_t lanes) {
    for (std::size_t step = 1; step < S; step *= 2) lanes |= lanes >> step;
    lanes &= kFirstLanes;
    for (std::size_t step = 1; step < S; step *= 2) lanes |= lanes << step;
    return lanes;
  }

  // Slots whose bound is above the threshold at any sample and level, of those in `asked`. Most bounds are
  // under all levels' thresholds even without a clamp.
  EQ_INLINE std::uint32_t find_breaks(std::size_t material, Floats emission, Floats bound,
                                      std::uint32_t asked) const {
    const std::uint32_t unclear = lane_mask(emission * bound > least_thresholds_[material]) & asked;
    if (unclear == 0) return 0;
    std::uint32_t breaks = 0;
    for (std::size_t level = job_.levels; level-- > 0 && (unclear & ~breaks) != 0;) {
      breaks |= lane_mask(emission * min(broadcast(job_.clamps_per_m2[level]), bound) >
                          thresholds_[index_of(material, level)]);
      breaks = fill_slots(breaks & unclear);
    }
    return breaks;
  }

  // For members of a leaf, and always for those of one look besides.
  void make_room(std::size_t singles) {
    members_.make_room(singles + kSlots);
    unlit_.make_room(singles + kSlots);
  }

  void split(const Open& open, const LightNode& node) {
    if (node.leaf_count == 0) {
      const auto heir = [&](std::uint32_t child) {
        return open.heir != kNone && job_.tree.nodes[child].representative == node.representative ? open.heir
                                                                                                  : kNone;
      };
      open_.push({node.next, heir(node.next)});
      open_.push({node.next + 1, heir(node.next + 1)});
      return;
    }
    make_room(node.leaf_count);
    for (std::uint32_t vpl = node.next; vpl < node.next + node.leaf_count; ++vpl) {
      const std::uint32_t heir = vpl == node.representative ? open.heir : kNone;
      const std::uint32_t member =
          add_member(Table::kSingle, vpl, heir, -1, heir == kNone ? 0 : weigh_vpl(job_.tree.vpls, vpl));
      members_.darken(member, 0, members_.peak_of(0));
      if (heir == kNone) unlit_.push(member);
    }
  }

  // One that has a released member's representative has its light, by its share of the weight.
  std::uint32_t add_member(std::uint32_t node, std::uint32_t vpl, std::uint32_t heir, float table_weight,
                           float weight) {
    const std::uint32_t member = members_.add(node, vpl, table_weight);
    if (heir == kNone) return member;
    const float whole = job_.tree.nodes[released_[heir]].weight;
    const float share = whole > 0 ? weight / whole : 0;
    const std::size_t first = members_.peak_of(0), columns = members_.columns() - first;
    const float* light = &released_light_[heir * columns * S];
    for (std::size_t column = first; column < members_.columns(); ++column) {
      float* target = members_.at(member, column);
      const float scale = column < members_.light_of(0, 0) ? 1 : share;
      for (std::size_t i = 0; i < S; ++i) target[i] = *light++ * scale;
    }
    return member;
  }

  // Members that break the rule are released, and their nodes looked at again; true if there are any.
  bool reopen() {
    released_.clear();
    released_light_.clear();
    for (std::size_t block = 0; block < members_.blocks(); ++block) {
      const Floats emission = members_.block(block, Table::kEmission);
      std::uint32_t breaks = 0;
      for (std::size_t m = 0; m < job_.materials.size(); ++m)
        breaks |= find_breaks(m, emission, members_.block(block, members_.bound_of(m)), 0xffffu);
      for (std::size_t slot = 0; breaks >> (slot * S); ++slot) {
        if ((breaks & lanes_of(slot)) != 0) release(static_cast<std::uint32_t>(block * kSlots + slot));
      }
    }
    return !open_.empty();
  }

  void release(std::uint32_t member) {
    open_.make_room(1);
    open_.push({members_.node(member), static_cast<std::uint32_t>(released_.size())});
    released_.push_back(members_.node(member));
    for (std::size_t column = members_.peak_of(0); column < members_.columns(); ++column) {
      const float* source = members_.at(member, column);
      released_light_.insert(released_light_.end(), source, source + S);
    }
    members_.release(member);
  }

  // VPLs with gloss are few, and their bounds long.
  Floats bound_glossy_emission(const std::uint32_t* ids, std::size_t count) const {
    std::array<float, kLanes> emission{};
    for (std::size_t lane = 0; lane < count * S; ++lane) {
      const Cluster cluster = unpack_cluster(job_.tree, job_.tree.nodes[ids[lane / S]]);
      emission[lane] = bound_emission(bounds_[lane].p, cluster, &job_.tree.gloss[ids[lane / S]]);
    }
    return load(emission.data());
  }

  // The light of all members that wait for it. Rays of many packets are traced together.
  void shade() {
    constexpr std::size_t kTogether = RayQueue::kMostPackets * kSlots;
    for (std::size_t first = 0; first < unlit_.size(); first += kTogether)
      shade_together(first, std::min(unlit_.size(), first + kTogether));
    unlit_.clear();
  }

  void shade_together(std::size_t first, std::size_t last) {
    constexpr std::size_t kAhead = 2 * kLanes;
    if (first == 0) {
      for (std::size_t i = 0; i < std::min(kAhead, last); ++i) prefetch_vpl(unlit_[i]);
    }
    queue_.restart();
    for (std::size_t i = first; i < last; i += kSlots) {
      for (std::size_t ahead = i + kAhead; ahead < std::min(i + kAhead + kSlots, unlit_.size()); ++ahead)
        prefetch_vpl(unlit_[ahead]);
      face_members(&unlit_[i], std::min(kSlots, last - i), sights_[(i - first) / kSlots]);
    }
    queue_.finish();
    for (std::size_t i = first; i < last; i += kSlots)
      light_members(&unlit_[i], std::min(kSlots, last - i), sights_[(i - first) / kSlots]);
  }

  EQ_INLINE void prefetch_vpl(std::uint32_t member) const {
    __builtin_prefetch(&job_.tree.vpls.vpls[members_.vpl(member)]);
  }

  void light_members(const std::uint32_t* members, std::size_t count, Sight& sight) {
    const std::uint32_t visible = queue_.take(sight.faced);
    if (visible == 0) {
      for (std::size_t i = 0; i < count; ++i)
        members_.darken(members[i], members_.peak_of(0), members_.columns());
      return;
    }
    sight.seen = from_lane_mask(visible);
    sight.light = select(sight.seen, sight.light, splat({}));
    if (!job_.tree.vpls.gloss.empty()) add_gloss(members, count, sight);
    std::array<Floats, kMostMaterials> lobes;
    lobes[0] = zeros();
    for (std::size_t i = 0; i < job_.lobes.size(); ++i) {
      const Floats lobe =
          eval_lobe(job_.lobes[i].model, job_.lobes[i].alpha, lanes_.v.z, sight.cos_l, sight.half);
      lobes[i] = select(lanes_.v.z > 0.0f, lobe, zeros());
    }
    for (std::size_t m = 0; m < job_.materials.size(); ++m) {
      const Reflected lanes = reflect(job_.materials[m], sight, lobes[job_.lobe_of[m]], job_.grey);
      write_column(lanes.peak, members, count, members_.peak_of(m));
      if (!job_.grey || m == 0) write_light_columns(lanes.light, members, count, m);
    }
  }

  void write_light_columns(const Floats3& light, const std::uint32_t* members, std::size_t count,
                           std::size_t m) {
    write_column(light.x, members, count, members_.light_of(m, 0));
    write_column(light.y, members, count, members_.light_of(m, 1));
    write_column(light.z, members, count, members_.light_of(m, 2));
  }

  EQ_INLINE void write_column(Floats lanes, const std::uint32_t* members, std::size_t count,
                              std::size_t column) {
    const auto values = to_array(lanes);
    for (std::size_t slot = 0; slot < count; ++slot)
      std::memcpy(members_.at(members[slot], column), &values[slot * S], S * sizeof(float));
  }

  // All but whether there is something between.
  void face_members(const std::uint32_t* members, std::size_t count, Sight& sight) {
    const VplList& list = job_.tree.vpls;
    std::array<const float*, kSlots> places, lights, weights;
    for (std::size_t slot = 0; slot < kSlots; ++slot) {
      const std::uint32_t member = members[std::min(slot, count - 1)];
      const Vpl& vpl = list.vpls[members_.vpl(member)];
      places[slot] = &vpl.p.x;
      lights[slot] = &vpl.intensity.x;
      weights[slot] = members_.weight(member);
    }
    const Columns4 place = load_columns<S>(places), light = load_columns<S>(lights);
    const Floats3 intensity{light[0], light[1], light[2]};
    // How many times its representative's light a member's is.
    const Floats whole = load_columns<S>(weights)[0], y = luminance(intensity);
    const Floats scale = select(whole < 0.0f, broadcast(1), select(y > 0.0f, whole / y, zeros()));
    const Floats3 p{place[0], place[1], place[2]}, ng = decode_octahedral(bits_of(place[3]));
    constexpr int kBias = 127 + Vpl::kLeastExponent;
    const Floats epsilon =
        bits_as_floats(shift_left<23>(shift_right<Vpl::kGlossBits>(bits_of(light[3])) + kBias));
    const Floats3 d = p - lanes_.p;
    sight.r2 = dot(d, d);
    const Floats3 l = d * (1.0f / sqrt(sight.r2));
    const Floats cos_vpl = -dot(ng, l);
    sight.cos_l = dot(lanes_.shading.n, l);
    const Mask faced = (sight.r2 > 0.0f) & (sight.cos_l > 0.0f) & (dot(ng_, l) > 0.0f) & (cos_vpl > 0.0f);
    const std::uint32_t slots = count < kSlots ? (1u << (count * S)) - 1u : 0xffffu;
    sight.faced = lane_mask(faced) & valid_ & slots;
    queue_.push(origins_, p + ng * epsilon, sight.faced);
    sight.l = l;
    const Floats3 h = to_local(lanes_.shading, l) + lanes_.v;
    sight.half = make_half_vector(h.x, h.y, h.z);
    sight.light = intensity * (scale * cos_vpl);
  }

  void add_gloss(const std::uint32_t* members, std::size_t count, Sight& sight) const {
    const VplList& list = job_.tree.vpls;
    const auto x = to_array(sight.l.x), y = to_array(sight.l.y), z = to_array(sight.l.z);
    auto r = to_array(sight.light.x), g = to_array(sight.light.y), b = to_array(sight.light.z);
    for (std::size_t lane = 0; lane < count * S; ++lane) {
      const std::uint32_t member = members[lane / S];
      const Vpl& vpl = list.vpls[members_.vpl(member)];
      if (vpl.gloss() < 0) continue;
      const Vec3 emitted = emit_vpl(list, vpl, {-x[lane], -y[lane], -z[lane]}) * find_scale(member);
      r[lane] = emitted.x;
      g[lane] = emitted.y;
      b[lane] = emitted.z;
    }
    sight.light = select(sight.seen, {load(r.data()), load(g.data()), load(b.data())}, splat({}));
  }

  // As the scale of face_members, also of a VPL with gloss.
  float find_scale(std::uint32_t member) const {
    const std::uint32_t node = members_.node(member);
    if (node == Table::kSingle) return 1;
    const float weight = weigh_vpl(job_.tree.vpls, members_.vpl(member));
    return weight > 0 ? job_.tree.nodes[node].weight / weight : 0;
  }

  // Of each sample, in every slot. shape: material x level
  std::vector<Floats> sum_luminance() {
    std::vector<Floats> totals;
    for (std::size_t m = 0; m < job_.materials.size(); ++m) {
      if (!job_.grey || m == 0) find_luminances(m);
      std::array<Floats, kLanes> sums;
      sums.fill(zeros());
      for (std::size_t block = 0; block < members_.blocks(); ++block) {
        const Floats peak = members_.block(block, members_.peak_of(m)), y = luminances_[block];
        for (std::size_t level = 0; level < job_.levels; ++level)
          sums[level] += y * min(broadcast(job_.clamps_per_m2[level]), peak);
      }
      for (std::size_t level = 0; level < job_.levels; ++level) {
        const auto lanes = to_array(sums[level]);
        std::array<float, S> samples{};
        for (std::size_t lane = 0; lane < kLanes; ++lane) samples[lane % S] += lanes[lane];
        totals.push_back(base_[index_of(m, level)] + tile<S>(samples.data()));
      }
    }
    return totals;
  }

  void find_luminances(std::size_t m) {
    luminances_.resize(members_.blocks());
    for (std::size_t block = 0; block < members_.blocks(); ++block)
      luminances_[block] = luminance(light_block(block, m));
  }

  EQ_INLINE Floats3 light_block(std::size_t block, std::size_t m) const {
    return {members_.block(block, members_.light_of(m, 0)), members_.block(block, members_.light_of(m, 1)),
            members_.block(block, members_.light_of(m, 2))};
  }

  // Of some levels from `first` on. shape: level x channel x sample
  template <std::size_t kLevels>
  auto sum_light(std::size_t m, std::size_t first) const {
    std::array<std::array<std::array<double, S>, 3>, kLevels> sums{};
    for (std::size_t begin = 0; begin < members_.blocks(); begin += kBlocksOfSums) {
      std::array<Floats3, kLevels> parts;
      parts.fill(splat({}));
      for (std::size_t block = begin; block < std::min(members_.blocks(), begin + kBlocksOfSums); ++block) {
        const Floats peak = members_.block(block, members_.peak_of(m));
        const Floats3 light = light_block(block, m);
        for (std::size_t i = 0; i < kLevels; ++i)
          parts[i] = parts[i] + light * min(broadcast(job_.clamps_per_m2[first + i]), peak);
      }
      for (std::size_t i = 0; i < kLevels; ++i) add_lanes(parts[i], sums[i]);
    }
    return sums;
  }

  static void add_lanes(const Floats3& part, std::array<std::array<double, S>, 3>& sums) {
    const std::array<std::array<float, kLanes>, 3> lanes{to_array(part.x), to_array(part.y),
                                                         to_array(part.z)};
    for (std::size_t channel = 0; channel < 3; ++channel) {
      for (std::size_t lane = 0; lane < kLanes; ++lane) sums[channel][lane % S] += lanes[channel][lane];
    }
  }

  const CutJob& job_;
  Table members_;
  std::vector<Floats> least_thresholds_;   // over levels. shape: material
  std::vector<Floats> thresholds_, base_;  // of each sample, in every slot. shape: material x level
  std::vector<BoundPoint> bounds_;         // shape: kLanes
  LanePoint lanes_{};
  Floats3 ng_{}, origins_{};
  std::uint32_t valid_ = 0;
  Pile<Open> open_;
  std::vector<std::uint32_t> released_;  // nodes
  std::vector<float> released_light_;    // shape: released x column from the peaks on x S
  std::vector<Floats> luminances_;       // of blocks of members
  Pile<std::uint32_t> unlit_;
  std::array<Sight, RayQueue::kMostPackets> sights_;
  RayQueue queue_;
};

// The cuts of one thread, made as their widths are met.
class Cuts {
 public:
  explicit Cuts(const CutJob& job) : job_(job) {}

  // The cut's size.
  std::size_t shade(PointRange range, ShadedPoints& shaded) {
    if (range.count == 1) return shade_by(one_, range, shaded);
    if (range.count == 2) return shade_by(two_, range, shaded);
    if (range.count <= 4) return shade_by(four_, range, shaded);
    if (range.count <= 8) return shade_by(eight_, range, shaded);
    return shade_by(sixteen_, range, shaded);
  }

  std::uint64_t rays() const { return rays_; }

 private:
  template <std::size_t S>
  std::size_t shade_by(std::optional<GroupCut<S>>& cut, PointRange range, ShadedPoints& shaded) {
    if (!cut) cut.emplace(job_);
    const std::uint64_t before = cut->rays();
    cut->find(range, totals_);
    cut->write_light(range, shaded);
    rays_ += cut->rays() - before;
    return cut->size();
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

void add_material(const Material& material, CutJob& job) {
  const auto is_grey = [](Vec3 colour) { return colour.x == colour.y && colour.y == colour.z; };
  job.grey = job.grey && is_grey(material.rho_d) && is_grey(material.rho_s);
  if (material.glossy_share == 0) return job.lobe_of.push_back(0);
  const Lobe lobe{material.model, material.alpha};
  const auto found = std::find(job.lobes.begin(), job.lobes.end(), lobe);
  job.lobe_of.push_back(static_cast<std::size_t>(found - job.lobes.begin()));
  if (found == job.lobes.end()) job.lobes.push_back(lobe);
}

}  // namespace

ShadedPoints shade_lightcut(const World& world, const std::vector<ShadingPoint>& points,
                            const LightTree& tree, const std::vector<Material>& materials,
                            const std::vector<double>& clamps_per_m2, const LightcutParams& params,
                            CutRecord* record) {
  EQ_CHECK(params.error_ratio >= 0 && params.floor >= 0, params.error_ratio, params.floor);
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
    const std::vector<PointRange> groups = group_points(points, kLanes);
    for_each_parallel((groups.size() + kCutBlock - 1) / kCutBlock, [&](std::size_t block) {
      const std::size_t first = block * kCutBlock, last = std::min(groups.size(), first + kCutBlock);
      Cuts cuts(job);
      std::size_t done = 0;
      for (std::size_t i = first; i < last; ++i) {
        const std::size_t size = cuts.shade(groups[i], shaded);
        for (std::size_t k = 0; k < groups[i].count; ++k)
          sizes[groups[i].first + k] = static_cast<std::uint32_t>(size);
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

NodeBounds bound_nodes(const LightTree& tree, const Material& material, const BoundPoint& point,
                       const std::uint32_t* ids, std::size_t count) {
  const LanePoint lanes = load_points(std::vector<BoundPoint>(kLanes, point));
  const LaneBound bound = bound_lanes(load_nodes(tree, ids, count), lanes, material.glossy_share > 0);
  const Floats lobe =
      material.glossy_share > 0 ? bound_lobe({material.model, material.alpha}, lanes, bound) : zeros();
  const auto peaks = to_array(bound_peak(material, bound, lobe)), emissions = to_array(bound.emission);
  NodeBounds bounds;
  for (std::size_t lane = 0; lane < count; ++lane) {
    bounds.peak[lane] = peaks[lane];
    if (!(peaks[lane] > 0)) continue;
    bounds.emission[lane] = emissions[lane];
    if (tree.gloss.empty()) continue;
    const Cluster cluster = unpack_cluster(tree, tree.nodes[ids[lane]]);
    bounds.emission[lane] = bound_emission(point.p, cluster, &tree.gloss[ids[lane]]);
  }
  return bounds;
}

}  // namespace equilux::EQ_ISA

#include "renderer/isa_end.h"
