// Philox and the streams drawn from it.
#include "base/random.h"

#include "base/error.h"

namespace equilux {

std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                        std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t product0 = std::uint64_t{0xD2511F53u} * counter[0];
    const std::uint64_t product1 = std::uint64_t{0xCD9E8D57u} * counter[2];
    counter = {static_cast<std::uint32_t>(product1 >> 32) ^ counter[1] ^ key[0],
               static_cast<std::uint32_t>(product1),
               static_cast<std::uint32_t>(product0 >> 32) ^ counter[3] ^ key[1],
               static_cast<std::uint32_t>(product0)};
    key[0] += 0x9E3779B9u;
    key[1] += 0xBB67AE85u;
  }
  return counter;
}

// Mixed through the cipher itself, so that all bits of seed and name count; the counter is (block, nonce,
// index).
StreamKey make_stream_key(std::uint64_t seed, std::string_view name) {
  const std::uint64_t what = hash_name(name);
  const auto mixed =
      philox4x32({static_cast<std::uint32_t>(what), static_cast<std::uint32_t>(what >> 32), 0, 0},
                 {static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32)});
  return {{mixed[0], mixed[1]}, mixed[2]};
}

std::uint32_t RandomStream::next_u32() {
  if (used_ == 4) {
    block_ = philox4x32(counter_, key_);
    ++counter_[0];
    used_ = 0;
  }
  return block_[used_++];
}

std::uint64_t RandomStream::next_u64() {
  const std::uint64_t low = next_u32();
  return low | (std::uint64_t{next_u32()} << 32);
}

std::uint64_t RandomStream::next_below(std::uint64_t count) {
  EQ_CHECK(count > 0);
  const std::uint64_t limit = UINT64_MAX - (UINT64_MAX % count + 1) % count;
  for (;;) {
    const std::uint64_t value = next_u64();
    if (value <= limit) return value % count;
  }
}

}  // namespace equilux
