// The light that points see of the members of their cuts.
#pragma once

#include "renderer/cut_job.h"
#include "renderer/cut_members.h"
#include "renderer/cut_roulette.h"
#include "renderer/lane_rays.h"

// After all other headers.
// clang-format off
#include "renderer/isa_begin.h"
// clang-format on

namespace equilux::EQ_ISA {

// Writes peaks and light of members, kLanes / S at a time; rays of many packets are traced together.
template <std::size_t S>
class MemberLight {
 public:
  static constexpr std::size_t kSlots = kLanes / S;

  explicit MemberLight(const CutJob& job)
      : job_(job),
        list_(job.tree.vpls),
        queue_(job.world, S > 1, job.params.watch_rays),
        with_roulette_(job.params.roulette.share > 0),
        roulette_(job.params.roulette.share, job.params.floor) {}

  // For the points from `first` on, where there is roulette. As RayRoulette::start; `totals`: of each
  // material and level
  void start(const std::vector<Floats>& totals, std::size_t first) {
    roulette_.start(totals, draw_starts<S>(job_.params.roulette.key, first));
  }

  // Of those from `first` on. What lies behind the last one is overwritten.
  void shade(const GroupPoints& points, Members<S>& members, std::size_t first) {
    constexpr std::size_t kTogether = RayQueue::kMostPackets * kSlots;
    for (std::size_t i = first; i < std::min(first + kAhead, members.size()); ++i) prefetch(members.vpl(i));
    for (; first < members.size(); first += kTogether)
      shade_together(points, members, first, std::min(members.size(), first + kTogether));
  }

  std::uint64_t rays() const { return queue_.rays(); }

 private:
  static constexpr std::size_t kAhead = 2 * kLanes;

  void shade_together(const GroupPoints& points, Members<S>& members, std::size_t first, std::size_t last) {
    queue_.restart();
    for (std::size_t i = first; i < last; i += kSlots) {
      for (std::size_t ahead = i + kAhead; ahead < std::min(i + kAhead + kSlots, members.size()); ++ahead)
        prefetch(members.vpl(ahead));
      face(points, members, i, std::min(kSlots, last - i), sights_[(i - first) / kSlots]);
    }
    queue_.finish();
    for (std::size_t i = first; i < last; i += kSlots)
      light(points, members, i, std::min(kSlots, last - i), sights_[(i - first) / kSlots]);
  }

  EQ_INLINE void prefetch(std::uint32_t vpl) const { __builtin_prefetch(&list_.vpls[vpl]); }

  // All but whether there is something between.
  void face(const GroupPoints& points, Members<S>& members, std::size_t first, std::size_t count,
            Sight& sight) {
    std::array<const float*, kSlots> places, lights;
    for (std::size_t slot = 0; slot < kSlots; ++slot) {
      const Vpl& vpl = list_.vpls[members.vpl(first + std::min(slot, count - 1))];
      places[slot] = &vpl.p.x;
      lights[slot] = &vpl.intensity.x;
    }
    const Columns4 place = load_columns<S>(places), light = load_columns<S>(lights);
    const Floats3 intensity{light[0], light[1], light[2]};
    // How many times its representative's light a member's is.
    const Floats whole = load(members.at(first, Members<S>::kWeight)), y = luminance(intensity);
    const Floats scale = select(whole < 0.0f, broadcast(1), select(y > 0.0f, whole / y, zeros()));
    const Floats3 p{place[0], place[1], place[2]}, ng = decode_octahedral(bits_of(place[3]));
    constexpr int kBias = 127 + Vpl::kLeastExponent;
    const Floats epsilon =
        bits_as_floats(shift_left<23>(shift_right<Vpl::kGlossBits>(bits_of(light[3])) + kBias));
    const Floats3 d = p - points.lanes.p;
    sight.r2 = dot(d, d);
    const Floats3 l = d * (1.0f / sqrt(sight.r2));
    const Floats cos_vpl = -dot(ng, l);
    sight.cos_l = dot(points.lanes.shading.n, l);
    const Mask faced =
        (sight.r2 > 0.0f) & (sight.cos_l > 0.0f) & (dot(points.ng, l) > 0.0f) & (cos_vpl > 0.0f);
    const std::uint32_t slots = count < kSlots ? (1u << (count * S)) - 1u : 0xffffu;
    sight.faced = lane_mask(faced & ((whole > 0.0f) | (whole < 0.0f))) & slots;
    sight.l = l;
    const Floats3 h = to_local(points.lanes.shading, l) + points.lanes.v;
    sight.half = make_half_vector(h.x, h.y, h.z);
    sight.light = intensity * (scale * cos_vpl);
    if (with_roulette_) {
      show(points, members, first, count, sight, sight.faced);
      sight.faced = draw(members, first, sight.faced);
    }
    queue_.push(points.origins, p + ng * epsilon, sight.faced);
  }

  void light(const GroupPoints& points, Members<S>& members, std::size_t first, std::size_t count,
             Sight& sight) {
    const std::uint32_t visible = queue_.take(sight.faced);
    if (!with_roulette_) return show(points, members, first, count, sight, visible);
    for (std::size_t m = 0; m < job_.materials.size(); ++m) {
      float* peak = members.at(first, members.peak_of(m));
      store(peak, select(from_lane_mask(visible), load(peak), zeros()));
    }
  }

  // Of `lanes` those whose rays are traced; their light then stands for that of others.
  std::uint32_t draw(Members<S>& members, std::size_t first, std::uint32_t lanes) {
    Floats share = zeros();
    for (std::size_t m = 0; m < job_.materials.size(); ++m) {
      const Floats peak = load(members.at(first, members.peak_of(m)));
      const Floats y = luminance({load(members.at(first, members.light_of(m, 0))),
                                  load(members.at(first, members.light_of(m, 1))),
                                  load(members.at(first, members.light_of(m, 2)))});
      for (std::size_t level = 0; level < job_.levels; ++level)
        share = max(share, roulette_.find_share(m * job_.levels + level,
                                                y * min(broadcast(job_.clamps_per_m2[level]), peak)));
    }
    const Floats weight = roulette_.draw(select(from_lane_mask(lanes), share, zeros()));
    for (std::size_t m = 0; m < (job_.grey ? 1 : job_.materials.size()); ++m) {
      for (std::size_t channel = 0; channel < 3; ++channel) {
        float* light = members.at(first, members.light_of(m, channel));
        store(light, load(light) * weight);
      }
    }
    return lane_mask(weight > 0.0f);
  }

  // As if nothing stood between `visible` lanes and their VPLs, and something between the others'.
  void show(const GroupPoints& points, Members<S>& members, std::size_t first, std::size_t count,
            Sight& sight, std::uint32_t visible) const {
    sight.seen = from_lane_mask(visible);
    sight.light = select(sight.seen, sight.light, splat({}));
    if (visible != 0 && !list_.gloss.empty()) add_gloss(members, first, count, sight);
    std::array<Floats, kMostMaterials> lobes;
    lobes[0] = zeros();
    for (std::size_t i = 0; i < job_.lobes.size() && visible != 0; ++i) {
      const Floats lobe =
          eval_lobe(job_.lobes[i].model, job_.lobes[i].alpha, points.lanes.v.z, sight.cos_l, sight.half);
      lobes[i] = select(points.lanes.v.z > 0.0f, lobe, zeros());
    }
    for (std::size_t m = 0; m < job_.materials.size(); ++m) {
      Reflected lanes{zeros(), sight.light};
      if (visible != 0) lanes = reflect(job_.materials[m], sight, lobes[job_.lobe_of[m]], job_.grey);
      store(members.at(first, members.peak_of(m)), lanes.peak);
      if (job_.grey && m > 0) continue;
      store(members.at(first, members.light_of(m, 0)), lanes.light.x);
      store(members.at(first, members.light_of(m, 1)), lanes.light.y);
      store(members.at(first, members.light_of(m, 2)), lanes.light.z);
    }
  }

  void add_gloss(const Members<S>& members, std::size_t first, std::size_t count, Sight& sight) const {
    const auto x = to_array(sight.l.x), y = to_array(sight.l.y), z = to_array(sight.l.z);
    auto r = to_array(sight.light.x), g = to_array(sight.light.y), b = to_array(sight.light.z);
    const float* weights = members.at(first, Members<S>::kWeight);
    for (std::size_t lane = 0; lane < count * S; ++lane) {
      const std::uint32_t index = members.vpl(first + lane / S);
      const Vpl& vpl = list_.vpls[index];
      if (vpl.gloss() < 0) continue;
      const Vec3 emitted =
          emit_vpl(list_, vpl, {-x[lane], -y[lane], -z[lane]}) * find_scale(weights[lane], index);
      r[lane] = emitted.x;
      g[lane] = emitted.y;
      b[lane] = emitted.z;
    }
    sight.light = select(sight.seen, {load(r.data()), load(g.data()), load(b.data())}, splat({}));
  }

  // As the scale of `face`, also of a VPL with gloss.
  float find_scale(float whole, std::uint32_t vpl) const {
    if (whole < 0) return 1;
    const float weight = weigh_vpl(list_, vpl);
    return weight > 0 ? whole / weight : 0;
  }

  const CutJob& job_;
  const VplList& list_;
  std::array<Sight, RayQueue::kMostPackets> sights_;
  RayQueue queue_;
  bool with_roulette_;
  RayRoulette roulette_;
};

}  // namespace equilux::EQ_ISA

#include "renderer/isa_end.h"
