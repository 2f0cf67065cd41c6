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

// A list that room is made for beforehand.
template <typename T>
class Pile {
 public:
  void make_room(std::size_t more) {
    if (size_ + more > values_.size()) values_.resize(2 * (size_ + more));
  }
  EQ_INLINE void push(T value) { values_[size_++] = value; }
  EQ_INLINE T pop() { return values_[--size_]; }
  void clear() { size_ = 0; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  EQ_INLINE T& operator[](std::size_t index) { return values_[index]; }
  EQ_INLINE const T& operator[](std::size_t index) const { return values_[index]; }

 private:
  std::vector<T> values_;
  std::size_t size_ = 0;
};

// Members of a cut, in columns of S floats a member: the bound of its emission; for each material the bound
// of M / r^2 and M / r^2 of its light; and the light in three channels, for all materials in one if they are
// grey. A member's light at a level is light x min{c, peak}, its bound there emission x min{c, bound}.
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

  std::size_t size() const { return size_; }
  std::size_t blocks() const { return (size() + kSlots - 1) / kSlots; }
  EQ_INLINE std::uint32_t node(std::size_t member) const { return nodes_[member]; }
  EQ_INLINE std::uint32_t vpl(std::size_t member) const { return vpls_[member]; }
  // Of its VPLs; a single's is below zero. Four floats may be read there.
  EQ_INLINE const float* weight(std::size_t member) const { return &weights_[member]; }

  void clear() {
    size_ = 0;
    unused_.clear();
  }

  // For so many more.
  void make_room(std::size_t more) {
    if (size_ + more <= nodes_.size()) return;
    const std::size_t room = 2 * (size_ + more);
    nodes_.resize(room);
    vpls_.resize(room);
    weights_.resize(room + 3);
    for (auto& column : columns_) column.resize((room + kSlots) * S);
  }

  // In the place of one that was released, if there is one. Its columns are not set.
  EQ_INLINE std::uint32_t add(std::uint32_t node, std::uint32_t vpl, float weight) {
    const auto member = unused_.empty() ? static_cast<std::uint32_t>(size_++) : unused_.pop();
    nodes_[member] = node;
    vpls_[member] = vpl;
    weights_[member] = weight;
    return member;
  }

  // Its columns stay until another takes its place.
  void release(std::uint32_t member) {
    unused_.make_room(1);
    unused_.push(member);
  }

  EQ_INLINE void darken(std::size_t member, std::size_t first, std::size_t last) {
    for (std::size_t column = first; column < last; ++column) std::fill_n(at(member, column), S, 0.0f);
  }

  // Zeros in the last block's lanes beyond the last member.
  void close() {
    for (auto& column : columns_)
      std::fill(column.begin() + static_cast<std::ptrdiff_t>(size_ * S),
                column.begin() + static_cast<std::ptrdiff_t>(blocks() * kLanes), 0.0f);
  }

  EQ_INLINE float* at(std::size_t member, std::size_t column) { return &columns_[column][member * S]; }
  EQ_INLINE Floats block(std::size_t index, std::size_t column) const {
    return load(&columns_[column][index * kLanes]);
  }

 private:
  std::size_t materials_;
  bool grey_;
  std::size_t size_ = 0;
  std::vector<std::vector<float>> columns_;
  std::vector<float> weights_;
  std::vector<std::uint32_t> nodes_, vpls_;
  Pile<std::uint32_t> unused_;
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
