// SPDX-License-Identifier: Apache-2.0
// Vectors of eight floats or integers, and what every kernel does with them: load and store, compare and select, square
// roots, transposing. Included by one source for each instruction set, as are the headers NAME_lanes.h that are built
// on it. Everything in them has internal linkage and calls no inline function of the standard library or Eigen: of such
// a function the linker keeps one copy, which may have been compiled for the newer machine.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <cstdint>

#include "spheretree/core/sphere.h"

namespace spheretree::runtime {
namespace {

typedef float F8 __attribute__((vector_size(32)));
typedef std::int32_t I8 __attribute__((vector_size(32)));
typedef std::uint32_t U8 __attribute__((vector_size(32)));
typedef float F4 __attribute__((vector_size(16)));

// Most functions take vectors by reference: the kernel for the base instruction set is not inlined, and copies of
// arguments would make it larger.
inline F8 splat(float v) { return F8{v, v, v, v, v, v, v, v}; }
inline U8 splatU(std::uint32_t v) { return U8{v, v, v, v, v, v, v, v}; }
inline F8 load(const float* p) {
  F8 v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}
inline void store(float* p, const F8& v) { __builtin_memcpy(p, &v, sizeof v); }

inline unsigned maskOf(const I8& m) {
#if defined(__AVX2__)
  return static_cast<unsigned>(_mm256_movemask_ps((__m256)m));
#elif defined(__SSE2__)
  typedef std::int32_t I4 __attribute__((vector_size(16)));
  const I4 low = __builtin_shufflevector(m, m, 0, 1, 2, 3), high = __builtin_shufflevector(m, m, 4, 5, 6, 7);
  return static_cast<unsigned>(_mm_movemask_ps((__m128)low) | (_mm_movemask_ps((__m128)high) << 4));
#else
  unsigned bits = 0;
  for (unsigned k = 0; k < 8; ++k) bits |= (m[k] != 0 ? 1u : 0u) << k;
  return bits;
#endif
}

inline F8 squareRoot(F8 v) {
#if defined(__AVX2__)
  return (F8)_mm256_sqrt_ps((__m256)v);
#elif defined(__SSE2__)
  const F4 low = __builtin_shufflevector(v, v, 0, 1, 2, 3), high = __builtin_shufflevector(v, v, 4, 5, 6, 7);
  return __builtin_shufflevector((F4)_mm_sqrt_ps((__m128)low), (F4)_mm_sqrt_ps((__m128)high), 0, 1, 2, 3, 4, 5, 6, 7);
#else
  for (unsigned k = 0; k < 8; ++k) v[k] = __builtin_sqrtf(v[k]);
  return v;
#endif
}

inline F8 select(const I8& mask, const F8& yes, const F8& no) { return (F8)(((I8)yes & mask) | ((I8)no & ~mask)); }

#if defined(__AVX2__)
// Bits 3k to 3k + 2 of entry m: the lane of the k-th set bit of m.
struct PackTable {
  std::uint32_t lanes[256];
  constexpr PackTable() : lanes() {
    for (unsigned m = 0; m < 256; ++m) {
      unsigned to = 0;
      for (std::uint32_t k = 0; k < 8; ++k)
        if (m >> k & 1) lanes[m] |= k << (3 * to++);
    }
  }
};
constexpr PackTable kPack;
#endif

// Appends the lanes of `names` that are set in `mask`, in order. Writes up to 8 values past the end.
inline std::uint32_t* append(std::uint32_t* to, const U8& names, unsigned mask) {
#if defined(__AVX2__)
  const __m256i order =
      _mm256_srlv_epi32(_mm256_set1_epi32(static_cast<int>(kPack.lanes[mask])), _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_permutevar8x32_epi32((__m256i)names, order));
  return to + __builtin_popcount(mask);
#else
  for (; mask; mask &= mask - 1) *to++ = names[__builtin_ctz(mask)];
  return to;
#endif
}

// The number of each lane.
constexpr U8 kLanes{0, 1, 2, 3, 4, 5, 6, 7};

inline F8 minOf(const F8& a, const F8& b) { return select(a < b, a, b); }
inline F8 maxOf(const F8& a, const F8& b) { return select(a > b, a, b); }
inline F8 size(F8 a) { return maxOf(a, -a); }
inline F8 clamp01(const F8& a) { return maxOf(splat(0), minOf(a, splat(1))); }
inline float minLane(const F8& w) {
  F8 v = w;
#if defined(__AVX2__)
  v = minOf(v, __builtin_shufflevector(v, v, 4, 5, 6, 7, 0, 1, 2, 3));
  v = minOf(v, __builtin_shufflevector(v, v, 2, 3, 0, 1, 6, 7, 4, 5));
  return minOf(v, __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6))[0];
#else
  float out = v[0];
  for (unsigned k = 1; k < 8; ++k) out = v[k] < out ? v[k] : out;
  return out;
#endif
}

// 8 records to x, y, z, r.
inline void transpose(const Sphere* const s[8], F8& x, F8& y, F8& z, F8& r) {
  const auto pair = [&](unsigned k) {
    F4 low, high;
    __builtin_memcpy(&low, s[k], sizeof low);
    __builtin_memcpy(&high, s[k + 4], sizeof high);
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
  };
  const F8 p0 = pair(0), p1 = pair(1), p2 = pair(2), p3 = pair(3);
  const F8 xy01 = __builtin_shufflevector(p0, p1, 0, 8, 1, 9, 4, 12, 5, 13),
           zr01 = __builtin_shufflevector(p0, p1, 2, 10, 3, 11, 6, 14, 7, 15);
  const F8 xy23 = __builtin_shufflevector(p2, p3, 0, 8, 1, 9, 4, 12, 5, 13),
           zr23 = __builtin_shufflevector(p2, p3, 2, 10, 3, 11, 6, 14, 7, 15);
  x = __builtin_shufflevector(xy01, xy23, 0, 1, 8, 9, 4, 5, 12, 13);
  y = __builtin_shufflevector(xy01, xy23, 2, 3, 10, 11, 6, 7, 14, 15);
  z = __builtin_shufflevector(zr01, zr23, 0, 1, 8, 9, 4, 5, 12, 13);
  r = __builtin_shufflevector(zr01, zr23, 2, 3, 10, 11, 6, 7, 14, 15);
}

}  // namespace
}  // namespace spheretree::runtime
