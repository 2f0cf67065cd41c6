// Sixteen floats at a time: the kernels' arithmetic, in two registers of x86-64-v3 or one of v4. Vectors stay
// within one file, and each instruction set has its own namespace.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <immintrin.h>

#include "renderer/octahedral.h"
#include "stimuli/vec.h"

#ifdef EQUILUX_ISA_V4
#define EQ_ISA v4
#else
#define EQ_ISA v3
#endif
#define EQ_INLINE inline __attribute__((always_inline))

#include "renderer/isa_begin.h"

namespace equilux::EQ_ISA {

inline constexpr std::size_t kLanes = 16;

#ifdef EQUILUX_ISA_V4

struct Mask {
  __mmask16 bits;
};
EQ_INLINE Mask operator&(Mask a, Mask b) { return {static_cast<__mmask16>(a.bits & b.bits)}; }
EQ_INLINE Mask operator|(Mask a, Mask b) { return {static_cast<__mmask16>(a.bits | b.bits)}; }
EQ_INLINE std::uint32_t lane_mask(Mask mask) { return mask.bits; }
EQ_INLINE Mask from_lane_mask(std::uint32_t bits) { return {static_cast<__mmask16>(bits)}; }

// Aligned in so many words: std::vector takes its alignment from code for v3.
struct alignas(64) Floats {
  __m512 v;
};
EQ_INLINE Floats broadcast(float value) { return {_mm512_set1_ps(value)}; }
EQ_INLINE Floats load(const float* values) { return {_mm512_loadu_ps(values)}; }
EQ_INLINE void store(float* values, Floats a) { _mm512_storeu_ps(values, a.v); }
// Bits that are only moved.
EQ_INLINE Floats load_bits(const std::uint32_t* values) {
  return {_mm512_castsi512_ps(_mm512_loadu_si512(values))};
}
// Those of `lanes`, one after another; what follows them, up to kLanes in all, is overwritten.
EQ_INLINE void store_compressed(float* values, Floats a, std::uint32_t lanes) {
  _mm512_storeu_ps(values, _mm512_maskz_compress_ps(static_cast<__mmask16>(lanes), a.v));
}
EQ_INLINE void store_some(float* values, Floats a, std::uint32_t lanes) {
  _mm512_mask_storeu_ps(values, static_cast<__mmask16>(lanes), a.v);
}
EQ_INLINE Floats operator+(Floats a, Floats b) { return {_mm512_add_ps(a.v, b.v)}; }
EQ_INLINE Floats operator-(Floats a, Floats b) { return {_mm512_sub_ps(a.v, b.v)}; }
EQ_INLINE Floats operator*(Floats a, Floats b) { return {_mm512_mul_ps(a.v, b.v)}; }
EQ_INLINE Floats operator/(Floats a, Floats b) { return {_mm512_div_ps(a.v, b.v)}; }
EQ_INLINE Floats operator-(Floats a) { return {_mm512_xor_ps(a.v, _mm512_set1_ps(-0.0f))}; }
EQ_INLINE Floats abs(Floats a) { return {_mm512_abs_ps(a.v)}; }
EQ_INLINE Floats sqrt(Floats a) { return {_mm512_sqrt_ps(a.v)}; }
EQ_INLINE Floats min(Floats a, Floats b) { return {_mm512_min_ps(a.v, b.v)}; }
EQ_INLINE Floats max(Floats a, Floats b) { return {_mm512_max_ps(a.v, b.v)}; }
EQ_INLINE Mask operator>(Floats a, Floats b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_GT_OQ)}; }
EQ_INLINE Mask operator>=(Floats a, Floats b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_GE_OQ)}; }
EQ_INLINE Floats select(Mask mask, Floats yes, Floats no) {
  return {_mm512_mask_blend_ps(mask.bits, no.v, yes.v)};
}

struct Ints {
  __m512i v;
};
EQ_INLINE Ints bits_of(Floats a) { return {_mm512_castps_si512(a.v)}; }
EQ_INLINE Ints truncate(Floats a) { return {_mm512_cvttps_epi32(a.v)}; }
EQ_INLINE Floats to_floats(Ints a) { return {_mm512_cvtepi32_ps(a.v)}; }
EQ_INLINE Floats bits_as_floats(Ints a) { return {_mm512_castsi512_ps(a.v)}; }
EQ_INLINE Ints operator+(Ints a, int b) { return {_mm512_add_epi32(a.v, _mm512_set1_epi32(b))}; }
template <int kBits>
EQ_INLINE Ints shift_left(Ints a) {
  return {_mm512_slli_epi32(a.v, kBits)};
}
EQ_INLINE Ints low_unsigned(Ints a) { return {_mm512_and_si512(a.v, _mm512_set1_epi32(0xffff))}; }
EQ_INLINE Ints high_unsigned(Ints a) { return {_mm512_srli_epi32(a.v, 16)}; }
template <int kBits>
EQ_INLINE Ints shift_right(Ints a) {
  return {_mm512_srli_epi32(a.v, kBits)};
}
EQ_INLINE Ints low_signed(Ints a) { return {_mm512_srai_epi32(_mm512_slli_epi32(a.v, 16), 16)}; }
EQ_INLINE Ints high_signed(Ints a) { return {_mm512_srai_epi32(a.v, 16)}; }

#else

struct Mask {
  __m256 a, b;
};
EQ_INLINE Mask operator&(Mask x, Mask y) { return {_mm256_and_ps(x.a, y.a), _mm256_and_ps(x.b, y.b)}; }
EQ_INLINE Mask operator|(Mask x, Mask y) { return {_mm256_or_ps(x.a, y.a), _mm256_or_ps(x.b, y.b)}; }
EQ_INLINE std::uint32_t lane_mask(Mask mask) {
  return static_cast<std::uint32_t>(_mm256_movemask_ps(mask.a)) |
         static_cast<std::uint32_t>(_mm256_movemask_ps(mask.b)) << 8;
}
EQ_INLINE Mask from_lane_mask(std::uint32_t bits) {
  const __m256i spread = _mm256_set1_epi32(static_cast<int>(bits));
  const __m256i first = _mm256_setr_epi32(31, 30, 29, 28, 27, 26, 25, 24),
                second = _mm256_setr_epi32(23, 22, 21, 20, 19, 18, 17, 16);
  // Each lane's bit goes to the sign.
  const auto sign = [&](__m256i by) {
    return _mm256_castsi256_ps(_mm256_srai_epi32(_mm256_sllv_epi32(spread, by), 31));
  };
  return {sign(first), sign(second)};
}

struct Floats {
  __m256 a, b;
};
EQ_INLINE Floats broadcast(float value) { return {_mm256_set1_ps(value), _mm256_set1_ps(value)}; }
EQ_INLINE Floats load(const float* values) { return {_mm256_loadu_ps(values), _mm256_loadu_ps(values + 8)}; }
EQ_INLINE void store(float* values, Floats x) {
  _mm256_storeu_ps(values, x.a);
  _mm256_storeu_ps(values + 8, x.b);
}
// Bits that are only moved.
EQ_INLINE Floats load_bits(const std::uint32_t* values) {
  const auto eight = [](const std::uint32_t* from) {
    return _mm256_castsi256_ps(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from)));
  };
  return {eight(values), eight(values + 8)};
}
// Those of eight lanes in front.
EQ_INLINE __m256 compress_eight(__m256 x, std::uint32_t lanes) {
  const std::uint64_t bytes = _pdep_u64(lanes, 0x0101010101010101ULL) * 0xff;
  const std::uint64_t order = _pext_u64(0x0706050403020100ULL, bytes);
  return _mm256_permutevar8x32_ps(x, _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(order))));
}
// Those of `lanes`, one after another; what follows them, up to kLanes in all, is overwritten.
EQ_INLINE void store_compressed(float* values, Floats x, std::uint32_t lanes) {
  _mm256_storeu_ps(values, compress_eight(x.a, lanes & 0xffu));
  _mm256_storeu_ps(values + std::popcount(lanes & 0xffu), compress_eight(x.b, lanes >> 8));
}
EQ_INLINE void store_some(float* values, Floats x, std::uint32_t lanes) {
  const Mask mask = from_lane_mask(lanes);
  _mm256_maskstore_ps(values, _mm256_castps_si256(mask.a), x.a);
  _mm256_maskstore_ps(values + 8, _mm256_castps_si256(mask.b), x.b);
}
EQ_INLINE Floats operator+(Floats x, Floats y) { return {_mm256_add_ps(x.a, y.a), _mm256_add_ps(x.b, y.b)}; }
EQ_INLINE Floats operator-(Floats x, Floats y) { return {_mm256_sub_ps(x.a, y.a), _mm256_sub_ps(x.b, y.b)}; }
EQ_INLINE Floats operator*(Floats x, Floats y) { return {_mm256_mul_ps(x.a, y.a), _mm256_mul_ps(x.b, y.b)}; }
EQ_INLINE Floats operator/(Floats x, Floats y) { return {_mm256_div_ps(x.a, y.a), _mm256_div_ps(x.b, y.b)}; }
EQ_INLINE Floats operator-(Floats x) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  return {_mm256_xor_ps(x.a, sign), _mm256_xor_ps(x.b, sign)};
}
EQ_INLINE Floats abs(Floats x) {
  const __m256 sign = _mm256_set1_ps(-0.0f);
  return {_mm256_andnot_ps(sign, x.a), _mm256_andnot_ps(sign, x.b)};
}
EQ_INLINE Floats sqrt(Floats x) { return {_mm256_sqrt_ps(x.a), _mm256_sqrt_ps(x.b)}; }
EQ_INLINE Floats min(Floats x, Floats y) { return {_mm256_min_ps(x.a, y.a), _mm256_min_ps(x.b, y.b)}; }
EQ_INLINE Floats max(Floats x, Floats y) { return {_mm256_max_ps(x.a, y.a), _mm256_max_ps(x.b, y.b)}; }
EQ_INLINE Mask operator>(Floats x, Floats y) {
  return {_mm256_cmp_ps(x.a, y.a, _CMP_GT_OQ), _mm256_cmp_ps(x.b, y.b, _CMP_GT_OQ)};
}
EQ_INLINE Mask operator>=(Floats x, Floats y) {
  return {_mm256_cmp_ps(x.a, y.a, _CMP_GE_OQ), _mm256_cmp_ps(x.b, y.b, _CMP_GE_OQ)};
}
EQ_INLINE Floats select(Mask mask, Floats yes, Floats no) {
  return {_mm256_blendv_ps(no.a, yes.a, mask.a), _mm256_blendv_ps(no.b, yes.b, mask.b)};
}

struct Ints {
  __m256i a, b;
};
EQ_INLINE Ints bits_of(Floats x) { return {_mm256_castps_si256(x.a), _mm256_castps_si256(x.b)}; }
EQ_INLINE Ints truncate(Floats x) { return {_mm256_cvttps_epi32(x.a), _mm256_cvttps_epi32(x.b)}; }
EQ_INLINE Floats to_floats(Ints x) { return {_mm256_cvtepi32_ps(x.a), _mm256_cvtepi32_ps(x.b)}; }
EQ_INLINE Floats bits_as_floats(Ints x) { return {_mm256_castsi256_ps(x.a), _mm256_castsi256_ps(x.b)}; }
EQ_INLINE Ints operator+(Ints x, int y) {
  const __m256i more = _mm256_set1_epi32(y);
  return {_mm256_add_epi32(x.a, more), _mm256_add_epi32(x.b, more)};
}
template <int kBits>
EQ_INLINE Ints shift_left(Ints x) {
  return {_mm256_slli_epi32(x.a, kBits), _mm256_slli_epi32(x.b, kBits)};
}
template <int kBits>
EQ_INLINE Ints shift_right(Ints x) {
  return {_mm256_srli_epi32(x.a, kBits), _mm256_srli_epi32(x.b, kBits)};
}
EQ_INLINE Ints low_unsigned(Ints x) {
  const __m256i low = _mm256_set1_epi32(0xffff);
  return {_mm256_and_si256(x.a, low), _mm256_and_si256(x.b, low)};
}
EQ_INLINE Ints high_unsigned(Ints x) { return {_mm256_srli_epi32(x.a, 16), _mm256_srli_epi32(x.b, 16)}; }
EQ_INLINE Ints high_signed(Ints x) { return {_mm256_srai_epi32(x.a, 16), _mm256_srai_epi32(x.b, 16)}; }
EQ_INLINE Ints low_signed(Ints x) { return high_signed(shift_left<16>(x)); }

#endif

EQ_INLINE Floats zeros() { return broadcast(0); }
EQ_INLINE Floats operator+(Floats a, float b) { return a + broadcast(b); }
EQ_INLINE Floats operator+(float a, Floats b) { return broadcast(a) + b; }
EQ_INLINE Floats operator-(Floats a, float b) { return a - broadcast(b); }
EQ_INLINE Floats operator-(float a, Floats b) { return broadcast(a) - b; }
EQ_INLINE Floats operator*(Floats a, float b) { return a * broadcast(b); }
EQ_INLINE Floats operator*(float a, Floats b) { return broadcast(a) * b; }
EQ_INLINE Floats operator/(Floats a, float b) { return a / broadcast(b); }
EQ_INLINE Floats operator/(float a, Floats b) { return broadcast(a) / b; }
EQ_INLINE Floats& operator+=(Floats& a, Floats b) { return a = a + b; }
EQ_INLINE Floats& operator*=(Floats& a, float b) { return a = a * b; }
EQ_INLINE Mask operator<(Floats a, Floats b) { return b > a; }
EQ_INLINE Mask operator>(Floats a, float b) { return a > broadcast(b); }
EQ_INLINE Mask operator<(Floats a, float b) { return broadcast(b) > a; }
EQ_INLINE bool any(Mask mask) { return lane_mask(mask) != 0; }

EQ_INLINE std::array<float, kLanes> to_array(Floats a) {
  std::array<float, kLanes> values;
  store(values.data(), a);
  return values;
}

// S values, time and again.
template <std::size_t S>
EQ_INLINE Floats tile(const float* values) {
#ifdef EQUILUX_ISA_V4
  if constexpr (S == 1) return broadcast(*values);
  if constexpr (S == 2) {
    double pair;
    std::memcpy(&pair, values, sizeof(pair));
    return {_mm512_castpd_ps(_mm512_set1_pd(pair))};
  }
  if constexpr (S == 4) return {_mm512_broadcast_f32x4(_mm_loadu_ps(values))};
  if constexpr (S == 8) return {_mm512_broadcast_f32x8(_mm256_loadu_ps(values))};
#else
  if constexpr (S == 1) return broadcast(*values);
  if constexpr (S == 2) {
    double pair;
    std::memcpy(&pair, values, sizeof(pair));
    const __m256 half = _mm256_castpd_ps(_mm256_set1_pd(pair));
    return {half, half};
  }
  if constexpr (S == 4) {
    const __m128 quarter = _mm_loadu_ps(values);
    return {_mm256_set_m128(quarter, quarter), _mm256_set_m128(quarter, quarter)};
  }
  if constexpr (S == 8) return {_mm256_loadu_ps(values), _mm256_loadu_ps(values)};
#endif
  return load(values);
}

// Of the values in S-th parts of the lanes those of one part, S times each: lane i is value part x kLanes / S
// + i / S.
template <std::size_t S>
EQ_INLINE Floats spread(Floats values, std::size_t part) {
  if constexpr (S == 1) return values;
  const auto first = static_cast<int>(part * (kLanes / S));
  constexpr auto from = [](int lane) { return lane / static_cast<int>(S); };
#ifdef EQUILUX_ISA_V4
  const __m512i lanes =
      _mm512_setr_epi32(from(0), from(1), from(2), from(3), from(4), from(5), from(6), from(7), from(8),
                        from(9), from(10), from(11), from(12), from(13), from(14), from(15));
  return {_mm512_permutexvar_ps(_mm512_add_epi32(lanes, _mm512_set1_epi32(first)), values.v)};
#else
  const __m256 source = first < 8 ? values.a : values.b;
  const __m256i place = _mm256_set1_epi32(first % 8);
  const __m256i low =
                    _mm256_setr_epi32(from(0), from(1), from(2), from(3), from(4), from(5), from(6), from(7)),
                high = _mm256_setr_epi32(from(8), from(9), from(10), from(11), from(12), from(13), from(14),
                                         from(15));
  return {_mm256_permutevar8x32_ps(source, _mm256_add_epi32(low, place)),
          _mm256_permutevar8x32_ps(source, _mm256_add_epi32(high, place))};
#endif
}

// Four columns of kLanes / S rows of four floats, each value in S lanes.
using Columns4 = std::array<Floats, 4>;

// Of whatever lies there.
EQ_INLINE float read_float(const float* place) {
  float value;
  std::memcpy(&value, place, sizeof(value));
  return value;
}

// The rows' columns in quarters: quarter k holds rows 4 k to 4 k + 3.
EQ_INLINE void transpose4(std::array<__m128, 4>& rows) {
  _MM_TRANSPOSE4_PS(rows[0], rows[1], rows[2], rows[3]);
}

#ifdef EQUILUX_ISA_V4

template <std::size_t S>
EQ_INLINE Columns4 load_columns(const std::array<const float*, kLanes / S>& rows) {
  Columns4 columns;
  if constexpr (S == 1) {
    std::array<__m512, 4> r;
    for (std::size_t i = 0; i < 4; ++i) {
      r[i] = _mm512_castps128_ps512(_mm_loadu_ps(rows[i]));
      r[i] = _mm512_insertf32x4(r[i], _mm_loadu_ps(rows[i + 4]), 1);
      r[i] = _mm512_insertf32x4(r[i], _mm_loadu_ps(rows[i + 8]), 2);
      r[i] = _mm512_insertf32x4(r[i], _mm_loadu_ps(rows[i + 12]), 3);
    }
    const __m512 a = _mm512_unpacklo_ps(r[0], r[1]), b = _mm512_unpackhi_ps(r[0], r[1]),
                 c = _mm512_unpacklo_ps(r[2], r[3]), d = _mm512_unpackhi_ps(r[2], r[3]);
    columns[0].v = _mm512_shuffle_ps(a, c, _MM_SHUFFLE(1, 0, 1, 0));
    columns[1].v = _mm512_shuffle_ps(a, c, _MM_SHUFFLE(3, 2, 3, 2));
    columns[2].v = _mm512_shuffle_ps(b, d, _MM_SHUFFLE(1, 0, 1, 0));
    columns[3].v = _mm512_shuffle_ps(b, d, _MM_SHUFFLE(3, 2, 3, 2));
  } else if constexpr (S == 2 || S == 4) {
    const __m512i spread = S == 2 ? _mm512_setr_epi32(0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6, 7, 7)
                                  : _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3);
    std::array<__m128, 4> first{_mm_loadu_ps(rows[0]), _mm_loadu_ps(rows[1]), _mm_loadu_ps(rows[2]),
                                _mm_loadu_ps(rows[3])},
        second = first;
    transpose4(first);
    if constexpr (S == 2) {
      second = {_mm_loadu_ps(rows[4]), _mm_loadu_ps(rows[5]), _mm_loadu_ps(rows[6]), _mm_loadu_ps(rows[7])};
      transpose4(second);
    }
    for (std::size_t i = 0; i < 4; ++i)
      columns[i].v =
          _mm512_permutexvar_ps(spread, _mm512_castps256_ps512(_mm256_set_m128(second[i], first[i])));
  } else if constexpr (S == 8) {
    for (std::size_t i = 0; i < 4; ++i)
      columns[i].v = _mm512_mask_blend_ps(0xff00, _mm512_set1_ps(read_float(rows[0] + i)),
                                          _mm512_set1_ps(read_float(rows[1] + i)));
  } else {
    for (std::size_t i = 0; i < 4; ++i) columns[i] = broadcast(read_float(rows[0] + i));
  }
  return columns;
}

#else

EQ_INLINE std::array<__m256, 4> load_eight_rows(const float* const* rows) {
  std::array<__m128, 4> first{_mm_loadu_ps(rows[0]), _mm_loadu_ps(rows[1]), _mm_loadu_ps(rows[2]),
                              _mm_loadu_ps(rows[3])},
      second{_mm_loadu_ps(rows[4]), _mm_loadu_ps(rows[5]), _mm_loadu_ps(rows[6]), _mm_loadu_ps(rows[7])};
  transpose4(first);
  transpose4(second);
  std::array<__m256, 4> columns;
  for (std::size_t i = 0; i < 4; ++i) columns[i] = _mm256_set_m128(second[i], first[i]);
  return columns;
}

template <std::size_t S>
EQ_INLINE Columns4 load_columns(const std::array<const float*, kLanes / S>& rows) {
  Columns4 columns;
  if constexpr (S == 1) {
    const auto first = load_eight_rows(rows.data()), second = load_eight_rows(rows.data() + 8);
    for (std::size_t i = 0; i < 4; ++i) columns[i] = {first[i], second[i]};
  } else if constexpr (S == 2) {
    const auto eight = load_eight_rows(rows.data());
    const __m256i low = _mm256_setr_epi32(0, 0, 1, 1, 2, 2, 3, 3),
                  high = _mm256_setr_epi32(4, 4, 5, 5, 6, 6, 7, 7);
    for (std::size_t i = 0; i < 4; ++i)
      columns[i] = {_mm256_permutevar8x32_ps(eight[i], low), _mm256_permutevar8x32_ps(eight[i], high)};
  } else if constexpr (S == 4) {
    std::array<__m128, 4> four{_mm_loadu_ps(rows[0]), _mm_loadu_ps(rows[1]), _mm_loadu_ps(rows[2]),
                               _mm_loadu_ps(rows[3])};
    transpose4(four);
    const __m256i low = _mm256_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1),
                  high = _mm256_setr_epi32(2, 2, 2, 2, 3, 3, 3, 3);
    for (std::size_t i = 0; i < 4; ++i) {
      const __m256 both = _mm256_castps128_ps256(four[i]);
      columns[i] = {_mm256_permutevar8x32_ps(both, low), _mm256_permutevar8x32_ps(both, high)};
    }
  } else if constexpr (S == 8) {
    for (std::size_t i = 0; i < 4; ++i)
      columns[i] = {_mm256_set1_ps(read_float(rows[0] + i)), _mm256_set1_ps(read_float(rows[1] + i))};
  } else {
    for (std::size_t i = 0; i < 4; ++i) columns[i] = broadcast(read_float(rows[0] + i));
  }
  return columns;
}

#endif

// exp(x) for x <= 0, relative error under 3e-7; 0 below -87, where float has only denormals left.
EQ_INLINE Floats exp_of_negative(Floats x) {
  const Floats clamped = max(x, broadcast(-87.0f));
  const Ints n = truncate(clamped * 1.44269504f - 0.5f);
  const Floats nf = to_floats(n);
  const Floats f = (clamped - nf * 0.693359375f) - nf * -2.12194440e-4f;
  const Floats poly =
      1.0f + f * (1.0f + f * (0.5f + f * (1.6666667e-1f +
                                          f * (4.1666668e-2f + f * (8.3333333e-3f + f * 1.3888889e-3f)))));
  return select(x < -87.0f, zeros(), poly * bits_as_floats(shift_left<23>(n + 127)));
}

struct Floats3 {
  Floats x, y, z;
};
EQ_INLINE Floats dot(const Floats3& a, const Floats3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
EQ_INLINE Floats3 splat(Vec3 v) { return {broadcast(v.x), broadcast(v.y), broadcast(v.z)}; }
EQ_INLINE Floats3 operator-(const Floats3& a, const Floats3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
EQ_INLINE Floats3 operator+(const Floats3& a, const Floats3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
EQ_INLINE Floats3 operator*(const Floats3& a, Floats b) { return {a.x * b, a.y * b, a.z * b}; }
EQ_INLINE Floats3 select(Mask mask, const Floats3& yes, const Floats3& no) {
  return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z)};
}
EQ_INLINE Floats max_component(const Floats3& a) { return max(a.x, max(a.y, a.z)); }

// As decode_octahedral of Octahedral, whose two numbers share 32 bits.
EQ_INLINE Floats3 decode_octahedral(Ints pair) {
  constexpr float kStep = 1 / kOctahedralSteps;
  const Floats x = to_floats(low_signed(pair)) * kStep, y = to_floats(high_signed(pair)) * kStep;
  const Floats z = 1.0f - abs(x) - abs(y), fold = max(zeros(), -z);
  const Floats3 axis{select(x < 0.0f, x + fold, x - fold), select(y < 0.0f, y + fold, y - fold), z};
  return axis * (1.0f / sqrt(dot(axis, axis)));
}

// As luminance of Vec3.
EQ_INLINE Floats luminance(const Floats3& a) { return a.x * 0.2126f + a.y * 0.7152f + a.z * 0.0722f; }

// Vectors before they are lanes.
struct Lane3 {
  alignas(64) std::array<float, kLanes> x, y, z;

  void set(std::size_t lane, Vec3 v) {
    x[lane] = v.x;
    y[lane] = v.y;
    z[lane] = v.z;
  }
};
EQ_INLINE Floats3 load(const Lane3& lanes) {
  return {load(lanes.x.data()), load(lanes.y.data()), load(lanes.z.data())};
}

}  // namespace equilux::EQ_ISA

#include "renderer/isa_end.h"
