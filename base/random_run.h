// The draws of long streams, many made at once.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "base/random.h"

namespace equilux {

/// What RandomStream draws, from the start of the same stream, in a third of the time: for those who take
/// them by the hundred, since they are made eight blocks at a time.
class RandomRun {
 public:
  RandomRun(const StreamKey& key, std::uint64_t index) : key_(key), index_(index) {}
  RandomRun(std::uint64_t seed, std::string_view what, std::uint64_t index)
      : RandomRun(make_stream_key(seed, what), index) {}

  std::uint32_t next_u32() {
    if (used_ == draws_.size()) refill();
    return draws_[used_++];
  }
  std::uint64_t next_u64() {
    const std::uint64_t low = next_u32();
    return low | (std::uint64_t{next_u32()} << 32);
  }
  /// Uniform in [0, 1), 53 bits.
  double next_double() { return static_cast<double>(next_u64() >> 11) * 0x1p-53; }

 private:
  static constexpr std::size_t kBlocks = 8;

  void refill();

  StreamKey key_;
  std::uint64_t index_;
  std::uint32_t block_ = 0;  // the first of those to be made next
  std::size_t used_ = 4 * kBlocks;
  std::array<std::uint32_t, 4 * kBlocks> draws_;
};

}  // namespace equilux
