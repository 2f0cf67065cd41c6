// The members of a cut as a table, and the light that points see of them.
#pragma once

#include <algorithm>
#include <cstring>
#include <vector>

#include "renderer/lane_lobe.h"

// After all other headers.
// clang-format off
#include "renderer/isa_begin.h"
// clang-format on

namespace equilux::EQ_ISA {

// A list that room is made for beforehand.
template <typename T>
class Pile {
 public:
  void make_room(std::size_t more) {
    if (size_ + more > values_.size()) values_.resize(2 * (size_ + more));
  }
  EQ_INLINE void push(T value) { values_[size_++] = value; }
  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  EQ_INLINE T& operator[](std::size_t index) { return values_[index]; }
  EQ_INLINE const T& operator[](std::size_t index) const { return values_[index]; }

 private:
  std::vector<T> values_;
  std::size_t size_ = 0;
};

// Members of the cuts of S samples, each a VPL that stands for a cluster or for itself, in columns of S
// floats a member. At each sample: the weight of the cluster it stands for, below zero for itself alone and 0
// if it is not in that sample's cut; the cluster's node, as bits; the bound of its emission, for each
// material the bound of M / r^2; and of its light for each material M / r^2 and the light in three channels,
// for all materials in one if they are grey. A member's light at a level is light x min{c, peak}, its bound
// there emission x min{c, bound}.
template <std::size_t S>
class Members {
 public:
  static constexpr std::size_t kSlots = kLanes / S;
  static constexpr std::uint32_t kSingle = ~0u;  // in place of a node
  static constexpr std::size_t kWeight = 0, kNode = 1, kEmission = 2;

  Members(std::size_t materials, bool grey)
      : materials_(materials), grey_(grey), columns_(3 + 2 * materials + 3 * (grey ? 1 : materials)) {}

  std::size_t bound_of(std::size_t material) const { return 3 + material; }
  std::size_t peak_of(std::size_t material) const { return 3 + materials_ + material; }
  std::size_t light_of(std::size_t material, std::size_t channel) const {
    return 3 + 2 * materials_ + (grey_ ? 0 : 3 * material) + channel;
  }
  std::size_t first_of_light() const { return light_of(0, 0); }
  std::size_t columns() const { return columns_.size(); }

  std::size_t size() const { return size_; }
  std::size_t blocks() const { return (size() + kSlots - 1) / kSlots; }
  EQ_INLINE std::uint32_t vpl(std::size_t member) const { return vpls_[member]; }
  std::uint32_t node(std::size_t member, std::size_t sample) const {
    std::uint32_t node;
    std::memcpy(&node, at(member, kNode) + sample, sizeof(node));
    return node;
  }

  void clear() { size_ = 0; }

  // For so many more, and for what is written beyond them.
  void make_room(std::size_t more) {
    if (size_ + more <= vpls_.size()) return;
    const std::size_t room = 2 * (size_ + more);
    vpls_.resize(room);
    for (auto& column : columns_) column.resize(room / kSlots + 3);
  }

  // One more, whose columns are set or will be.
  EQ_INLINE void add(std::uint32_t vpl) { vpls_[size_++] = vpl; }

  // Zeros in the last block's lanes beyond the last member.
  void close() {
    for (std::size_t column = 0; column < columns_.size(); ++column)
      std::fill(at(size_, column), at(blocks() * kSlots, column), 0.0f);
  }

  // May be read and written kLanes before and behind.
  EQ_INLINE float* at(std::size_t member, std::size_t column) {
    return reinterpret_cast<float*>(columns_[column].data() + 1) + member * S;
  }
  EQ_INLINE const float* at(std::size_t member, std::size_t column) const {
    return reinterpret_cast<const float*>(columns_[column].data() + 1) + member * S;
  }
  EQ_INLINE Floats block(std::size_t index, std::size_t column) const { return columns_[column][index + 1]; }

 private:
  std::size_t materials_;
  bool grey_;
  std::size_t size_ = 0;
  std::vector<std::vector<Floats>> columns_;  // one empty block in front
  std::vector<std::uint32_t> vpls_;
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
