// The lattice.
#include "renderer/sampler.h"

#include "base/error.h"

namespace equilux {
namespace {

constexpr LatticePoint kGenerator = {1, 182667, 469891, 498753, 110745, 446247, 250185, 118627, 245333};

// 4,096 draws, far more than paths take among a few lamps: what one takes moves no other. Longer ones go on
// into the next one's, which moves no mean. The shift's own come before, and a stream ends at 2^22 paths.
constexpr std::uint64_t kBlocksOfAPath = 1024;

// Van der Corput's order: the bits of the index from behind.
std::uint64_t reverse_bits(std::uint64_t x) {
  x = __builtin_bswap64(x);
  x = (x & 0x0f0f0f0f0f0f0f0fULL) << 4 | (x >> 4 & 0x0f0f0f0f0f0f0f0fULL);
  x = (x & 0x3333333333333333ULL) << 2 | (x >> 2 & 0x3333333333333333ULL);
  return (x & 0x5555555555555555ULL) << 1 | (x >> 1 & 0x5555555555555555ULL);
}

}  // namespace

LatticePoint draw_shift(RandomStream& stream) {
  LatticePoint shift{};
  for (std::uint64_t& coordinate : shift) coordinate = stream.next_u64();
  return shift;
}

PathSampler::PathSampler(RandomStream stream, bool low_discrepancy)
    : stream_(stream), shift_(draw_shift(stream_)), low_discrepancy_(low_discrepancy) {}

PathSampler::PathSampler(const LatticePoint& shift, std::uint64_t path, const RandomStream& stream)
    : stream_(stream), shift_(shift), place_(reverse_bits(path)), path_(path) {}

void PathSampler::next_path() {
  place_ = reverse_bits(path_++);
  dimension_ = low_discrepancy_ ? 0 : kLatticeDimensions;
  EQ_CHECK(path_ * kBlocksOfAPath <= UINT32_MAX, path_);
  stream_.skip_to_block(static_cast<std::uint32_t>(path_ * kBlocksOfAPath));
}

float PathSampler::next() {
  if (dimension_ == kLatticeDimensions) return stream_.next_float();
  const std::uint64_t value = shift_[dimension_] + kGenerator[dimension_] * place_;
  ++dimension_;
  return static_cast<float>(value >> 40) * 0x1p-24f;
}

}  // namespace equilux
