// Philox on eight counters: a block in each lane of two vectors.
#include "base/random_run.h"

#include <cstring>
#include <immintrin.h>

namespace equilux {
namespace {

// Words of four blocks, each in the lower half of its lane; what stands in the upper half has no meaning.
using Four = std::uint64_t __attribute__((vector_size(32)));

constexpr std::uint64_t kLower = 0xffffffff;

Four fill(std::uint64_t word) { return Four{} + word; }

// Of the lower halves, which GCC 12 does in three times as many steps where it is written as a * b.
Four multiply(Four a, Four b) {
  return reinterpret_cast<Four>(_mm256_mul_epu32(reinterpret_cast<__m256i>(a), reinterpret_cast<__m256i>(b)));
}

// Four blocks of philox4x32.
struct Blocks {
  Four word0, word1, word2, word3;

  void mix(Four key0, Four key1) {
    const Four product0 = multiply(word0, fill(0xD2511F53u)), product1 = multiply(word2, fill(0xCD9E8D57u));
    word0 = (product1 >> 32) ^ word1 ^ key0;
    word1 = product1;
    word2 = (product0 >> 32) ^ word3 ^ key1;
    word3 = product0;
  }

  // One after another.
  void store(std::uint32_t* draws) const {
    const Four first = (word0 & kLower) | (word1 << 32), second = (word2 & kLower) | (word3 << 32);
    const std::array<std::uint64_t, 8> pairs{first[0], second[0], first[1], second[1],
                                             first[2], second[2], first[3], second[3]};
    std::memcpy(draws, pairs.data(), sizeof(pairs));
  }
};

}  // namespace

void RandomRun::refill() {
  const Four nonce = fill(key_.nonce), index = fill(index_ & kLower), index_high = fill(index_ >> 32);
  Blocks early{Four{0, 1, 2, 3} + block_, nonce, index, index_high};
  Blocks late{Four{4, 5, 6, 7} + block_, nonce, index, index_high};
  std::uint32_t key0 = key_.key[0], key1 = key_.key[1];
  for (int round = 0; round < 10; ++round) {
    const Four keys0 = fill(key0), keys1 = fill(key1);
    early.mix(keys0, keys1);
    late.mix(keys0, keys1);
    key0 += 0x9E3779B9u;
    key1 += 0xBB67AE85u;
  }
  early.store(draws_.data());
  late.store(draws_.data() + draws_.size() / 2);
  block_ += kBlocks;
  used_ = 0;
}

}  // namespace equilux
