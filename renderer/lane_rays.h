// Shadow rays of packets with idle lanes, traced in packets without.
#pragma once

#include <bit>
#include <cstring>
#include <functional>

#include "renderer/lanes.h"
#include "renderer/world.h"

// After all other headers.
// clang-format off
#include "renderer/isa_begin.h"
// clang-format on

namespace equilux::EQ_ISA {

using WatchRays = std::function<void(const PointPacket& from, const PointPacket& to, std::uint32_t valid)>;

// Rays are traced as soon as there are enough for a packet; answers are taken in the order of the rays.
class RayQueue {
 public:
  static constexpr std::size_t kMostPackets = 16;  // between two calls of restart

  RayQueue(const World& world, bool coherent, const WatchRays& watch)
      : world_(world), coherent_(coherent), watch_(watch) {}

  void restart() { traced_ = waiting_ = taken_ = 0; }

  // Those of `lanes` alone.
  void push(const Floats3& from, const Floats3& to, std::uint32_t lanes) {
    if (lanes == 0) return;
    compress(from, lanes, from_);
    compress(to, lanes, to_);
    waiting_ += static_cast<std::size_t>(std::popcount(lanes));
    if (waiting_ < kLanes) return;
    trace(0xffffu);
    move_down(from_);
    move_down(to_);
    waiting_ -= kLanes;
  }

  void finish() {
    if (waiting_ > 0) trace((1u << waiting_) - 1u);
    waiting_ = 0;
  }

  // Of `lanes`, which were pushed together, those that are not occluded.
  std::uint32_t take(std::uint32_t lanes) {
    std::uint64_t answers;
    std::memcpy(&answers, &visible_[taken_ / kLanes], sizeof(answers));
    answers >>= taken_ % kLanes;
    taken_ += static_cast<std::size_t>(std::popcount(lanes));
    return _pdep_u32(static_cast<std::uint32_t>(answers), lanes);
  }

  std::uint64_t rays() const { return rays_; }

 private:
  // A packet and what may run over it.
  struct Ends {
    alignas(64) std::array<float, 2 * kLanes> x, y, z;
  };

  void compress(const Floats3& points, std::uint32_t lanes, Ends& ends) const {
    store_compressed(&ends.x[waiting_], points.x, lanes);
    store_compressed(&ends.y[waiting_], points.y, lanes);
    store_compressed(&ends.z[waiting_], points.z, lanes);
  }

  static void move_down(Ends& ends) {
    store(ends.x.data(), load(&ends.x[kLanes]));
    store(ends.y.data(), load(&ends.y[kLanes]));
    store(ends.z.data(), load(&ends.z[kLanes]));
  }

  static PointPacket take_packet(const Ends& ends) {
    PointPacket packet;
    store(packet.x.data(), load(ends.x.data()));
    store(packet.y.data(), load(ends.y.data()));
    store(packet.z.data(), load(ends.z.data()));
    return packet;
  }

  void trace(std::uint32_t lanes) {
    const PointPacket from = take_packet(from_), to = take_packet(to_);
    if (watch_) watch_(from, to, lanes);
    visible_[traced_++] = static_cast<std::uint16_t>(world_.find_visible(from, to, lanes, coherent_));
    rays_ += static_cast<std::uint64_t>(std::popcount(lanes));
  }

  const World& world_;
  bool coherent_;
  const WatchRays& watch_;
  Ends from_{}, to_{};
  std::array<std::uint16_t, kMostPackets + 4>
      visible_{};  // as many as take reads at once lie behind the last
  std::size_t traced_ = 0, waiting_ = 0, taken_ = 0;
  std::uint64_t rays_ = 0;
};

}  // namespace equilux::EQ_ISA

#include "renderer/isa_end.h"
