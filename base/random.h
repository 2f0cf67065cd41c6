// Counter-based random numbers: a function of (seed, what, index), never of thread or arrival.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

namespace equilux {

/// Philox4x32 with 10 rounds. source: Salmon, Moraes, Dror, Shaw, SC 2011, sections 3 and 4.
std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                        std::array<std::uint32_t, 2> key);

/// 64-bit FNV-1a of a name; the `what` of a stream.
constexpr std::uint64_t hash_name(std::string_view name) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (char character : name) hash = (hash ^ static_cast<unsigned char>(character)) * 0x100000001b3ULL;
  return hash;
}

/// The cipher key and nonce of one (seed, what): made once where many streams differ in their index only.
struct StreamKey {
  std::array<std::uint32_t, 2> key{};
  std::uint32_t nonce = 0;
};
StreamKey make_stream_key(std::uint64_t seed, std::string_view what);

/// A stream of independent draws for one (seed, what, index).
class RandomStream {
 public:
  RandomStream(const StreamKey& key, std::uint64_t index)
      : key_(key.key),
        counter_{0, key.nonce, static_cast<std::uint32_t>(index), static_cast<std::uint32_t>(index >> 32)} {}
  RandomStream(std::uint64_t seed, std::string_view what, std::uint64_t index)
      : RandomStream(make_stream_key(seed, what), index) {}

  /// Goes on at a place of the stream, four draws of 32 bits a block.
  void skip_to_block(std::uint32_t block) {
    counter_[0] = block;
    used_ = 4;
  }

  std::uint32_t next_u32();
  std::uint64_t next_u64();
  /// Uniform in [0, 1), 24 bits.
  float next_float() { return static_cast<float>(next_u32() >> 8) * 0x1p-24f; }
  /// Uniform in [0, 1), 53 bits.
  double next_double() { return static_cast<double>(next_u64() >> 11) * 0x1p-53; }
  /// Uniform in 0 .. count-1, exactly (by rejection). count must not be 0.
  std::uint64_t next_below(std::uint64_t count);

 private:
  std::array<std::uint32_t, 2> key_;
  std::array<std::uint32_t, 4> counter_;
  std::array<std::uint32_t, 4> block_{};
  unsigned used_ = 4;
};

/// Fisher-Yates, all orders equally likely.
template <typename T>
void shuffle(std::vector<T>& values, RandomStream& random) {
  for (std::size_t left = values.size(); left > 1; --left) {
    std::swap(values[left - 1], values[random.next_below(left)]);
  }
}

}  // namespace equilux
