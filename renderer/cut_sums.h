// Sums over the members of cuts.
#pragma once

#include "renderer/cut_groups.h"
#include "renderer/cut_job.h"
#include "renderer/cut_members.h"

// After all other headers.
// clang-format off
#include "renderer/isa_begin.h"
// clang-format on

namespace equilux::EQ_ISA {

template <std::size_t S>
class MemberSums {
 public:
  explicit MemberSums(const CutJob& job) : job_(job) {}

  // Into the places of the group's points.
  void write(const Members<S>& members, PointRange range, ShadedPoints& shaded) const {
    constexpr std::size_t kAtOnce = 4;
    for (std::size_t m = 0; m < job_.materials.size(); ++m) {
      std::size_t level = 0;
      for (; level + kAtOnce <= job_.levels; level += kAtOnce)
        write_levels<kAtOnce>(members, m, level, range, shaded);
      for (; level < job_.levels; ++level) write_levels<1>(members, m, level, range, shaded);
    }
  }

  // Of each sample, in every slot, with what is there already. shape: material x level
  std::vector<Floats> find_totals(const Members<S>& members, const std::vector<Floats>& base) {
    std::vector<Floats> totals;
    for (std::size_t m = 0; m < job_.materials.size(); ++m) {
      if (!job_.grey || m == 0) find_luminances(members, m);
      std::array<Floats, kLanes> sums;
      sums.fill(zeros());
      for (std::size_t block = 0; block < members.blocks(); ++block) {
        const Floats peak = members.block(block, members.peak_of(m)), y = luminances_[block];
        for (std::size_t level = 0; level < job_.levels; ++level)
          sums[level] += y * min(broadcast(job_.clamps_per_m2[level]), peak);
      }
      for (std::size_t level = 0; level < job_.levels; ++level) {
        const auto lanes = to_array(sums[level]);
        std::array<float, S> samples{};
        for (std::size_t lane = 0; lane < kLanes; ++lane) samples[lane % S] += lanes[lane];
        totals.push_back(base[m * job_.levels + level] + tile<S>(samples.data()));
      }
    }
    return totals;
  }

 private:
  static constexpr std::size_t kBlocksOfSums = 32;  // summed in float before they go to double

  template <std::size_t kLevels>
  void write_levels(const Members<S>& members, std::size_t m, std::size_t first, PointRange range,
                    ShadedPoints& shaded) const {
    const auto sums = sum_light<kLevels>(members, m, first);
    for (std::size_t i = 0; i < kLevels; ++i) {
      for (std::size_t sample = 0; sample < range.count; ++sample)
        shaded.radiance[shaded.index(m, first + i, range.first + sample)] = {
            static_cast<float>(sums[i][0][sample]), static_cast<float>(sums[i][1][sample]),
            static_cast<float>(sums[i][2][sample])};
    }
  }

  void find_luminances(const Members<S>& members, std::size_t m) {
    luminances_.resize(members.blocks());
    for (std::size_t block = 0; block < members.blocks(); ++block)
      luminances_[block] = luminance(light_block(members, block, m));
  }

  static EQ_INLINE Floats3 light_block(const Members<S>& members, std::size_t block, std::size_t m) {
    return {members.block(block, members.light_of(m, 0)), members.block(block, members.light_of(m, 1)),
            members.block(block, members.light_of(m, 2))};
  }

  // Of some levels from `first` on. shape: level x channel x sample
  template <std::size_t kLevels>
  auto sum_light(const Members<S>& members, std::size_t m, std::size_t first) const {
    std::array<std::array<std::array<double, S>, 3>, kLevels> sums{};
    for (std::size_t begin = 0; begin < members.blocks(); begin += kBlocksOfSums) {
      std::array<Floats3, kLevels> parts;
      parts.fill(splat({}));
      for (std::size_t block = begin; block < std::min(members.blocks(), begin + kBlocksOfSums); ++block) {
        const Floats peak = members.block(block, members.peak_of(m));
        const Floats3 light = light_block(members, block, m);
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
  std::vector<Floats> luminances_;  // of blocks of members
};

}  // namespace equilux::EQ_ISA

#include "renderer/isa_end.h"
