// The members of a cut as a table, and the light that points see of them.
#pragma once

#include <algorithm>
#include <vector>

#include "renderer/lane_lobe.h"

// After all other headers.
// clang-format off
#include "renderer/isa_begin.h"
// clang-format on

namespace equilux::EQ_ISA {

// Members of a cut, in columns of S floats a member: the bound of its emission; for each material the bound
// of M / r^2 and M / r^2 of its light; and the light in three channels, for all materials in one if they are
// grey. A member's light at a level is light x min{c, peak}, its bound there emission x min{c, bound}. Lanes
// beyond the last member are zero.
template <std::size_t S>
class Members {
 public:
  static constexpr std::size_t kSlots = kLanes / S;
  static constexpr std::uint32_t kSingle = ~0u;  // in place of a node: a VPL by itself
  static constexpr std::size_t kEmission = 0;

  Members(std::size_t materials, bool grey)
      : materials_(materials), grey_(grey), columns_(1 + 2 * materials + 3 * (grey ? 1 : materials)) {}

  std::size_t bound_of(std::size_t material) const { return 1 + material; }
  std::size_t peak_of(std::size_t material) const { return 1 + materials_ + material; }
  std::size_t light_of(std::size_t material, std::size_t channel) const {
    return 1 + 2 * materials_ + (grey_ ? 0 : 3 * material) + channel;
  }
  std::size_t columns() const { return columns_.size(); }

  std::size_t size() const { return nodes_.size(); }
  std::size_t blocks() const { return (size() + kSlots - 1) / kSlots; }
  std::uint32_t node(std::size_t member) const { return nodes_[member]; }
  std::uint32_t vpl(std::size_t member) const { return vpls_[member]; }
  // Of its VPLs; a single's is below zero. Four floats may be read there.
  const float* weight(std::size_t member) const { return &weights_[member]; }

  void clear() {
    for (auto& column : columns_)
      std::fill_n(column.begin(), std::min(column.size(), blocks() * kLanes), 0.0f);
    nodes_.clear();
    vpls_.clear();
    unused_.clear();
  }

  // In the place of one that was released, if there is one.
  std::uint32_t add(std::uint32_t node, std::uint32_t vpl, float weight) {
    if (!unused_.empty()) {
      const std::uint32_t member = unused_.back();
      unused_.pop_back();
      nodes_[member] = node;
      vpls_[member] = vpl;
      weights_[member] = weight;
      for (auto& column : columns_) std::fill_n(&column[member * S], S, 0.0f);
      return member;
    }
    const std::size_t member = nodes_.size();
    nodes_.push_back(node);
    vpls_.push_back(vpl);
    if (columns_[0].size() < blocks() * kLanes) {
      for (auto& column : columns_) column.resize(2 * blocks() * kLanes);
    }
    if (weights_.size() < member + 4) weights_.resize(2 * (member + 4));
    weights_[member] = weight;
    return static_cast<std::uint32_t>(member);
  }

  // Its columns stay until another takes its place.
  void release(std::uint32_t member) { unused_.push_back(member); }

  EQ_INLINE float* at(std::size_t member, std::size_t column) { return &columns_[column][member * S]; }
  EQ_INLINE Floats block(std::size_t index, std::size_t column) const {
    return load(&columns_[column][index * kLanes]);
  }

 private:
  std::size_t materials_;
  bool grey_;
  std::vector<std::vector<float>> columns_;
  std::vector<float> weights_;
  std::vector<std::uint32_t> nodes_, vpls_, unused_;
};

// What S points see of kLanes / S VPLs, but for the material.
struct Sight {
  Floats cos_l, r2;
  Floats3 l;
  HalfVector half;
  Floats3 light;
  std::uint32_t faced;  // lanes
  Mask seen;            // nothing stands between
};

// Largest M of any channel and, where channels differ, the light by M / largest M; black where it is not
// seen.
struct Reflected {
  Floats peak;
  Floats3 light;
};

EQ_INLINE Reflected reflect(const Material& material, const Sight& sight, Floats lobe, bool grey) {
  const Floats diffuse = sight.cos_l * kInvPi;
  if (grey) {
    Floats m = material.rho_d.x * diffuse;
    if (material.glossy_share > 0) m += material.rho_s.x * lobe;
    return {select(sight.seen & (m > 0.0f), m / sight.r2, zeros()), sight.light};
  }
  Floats3 m = splat(material.rho_d) * diffuse;
  if (material.glossy_share > 0) m = m + splat(material.rho_s) * lobe;
  const Floats largest = max_component(m);
  const Mask lit = sight.seen & (largest > 0.0f);
  const Floats share = 1.0f / largest;
  return {select(lit, largest / sight.r2, zeros()),
          select(lit, {m.x * share * sight.light.x, m.y * share * sight.light.y, m.z * share * sight.light.z},
                 splat({}))};
}

}  // namespace equilux::EQ_ISA

#include "renderer/isa_end.h"
