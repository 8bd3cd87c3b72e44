// SPDX-License-Identifier: Apache-2.0
// The body of the inner loops; included by one source for each instruction set. Everything here has internal linkage and calls no inline
// function of the standard library or Eigen: the linker keeps one copy of such a function, which may be the one for the newer machine.
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include "kernel.h"

namespace spheretree::runtime {
namespace {

typedef float F8 __attribute__((vector_size(32)));
typedef std::int32_t I8 __attribute__((vector_size(32)));
typedef std::uint32_t U8 __attribute__((vector_size(32)));
typedef float F4 __attribute__((vector_size(16)));

inline F8 splat(float v) { return F8{v, v, v, v, v, v, v, v}; }
inline U8 splatU(std::uint32_t v) { return U8{v, v, v, v, v, v, v, v}; }
inline F8 load(const float* p) {
  F8 v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}
inline void store(float* p, F8 v) { __builtin_memcpy(p, &v, sizeof v); }

inline unsigned maskOf(I8 m) {
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

inline F8 select(I8 mask, F8 yes, F8 no) { return (F8)(((I8)yes & mask) | ((I8)no & ~mask)); }

#if defined(__AVX2__)
// Byte k of entry m: the lane of the k-th set bit of m.
struct PackTable {
  std::uint64_t lanes[256];
  constexpr PackTable() : lanes() {
    for (unsigned m = 0; m < 256; ++m) {
      unsigned to = 0;
      for (std::uint64_t k = 0; k < 8; ++k)
        if (m >> k & 1) lanes[m] |= k << (8 * to++);
    }
  }
};
constexpr PackTable kPack;
#endif

// Appends the lanes of `names` that `mask` has, in order. Writes up to 8 values past the end.
inline std::uint32_t* append(std::uint32_t* to, U8 names, unsigned mask) {
#if defined(__AVX2__)
  const __m256i order = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(static_cast<long long>(kPack.lanes[mask])));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_permutevar8x32_epi32((__m256i)names, order));
  return to + __builtin_popcount(mask);
#else
  for (; mask; mask &= mask - 1) *to++ = names[__builtin_ctz(mask)];
  return to;
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
struct Turned {
  F8 x, y, z;
};
inline Turned turn(F8 x, F8 y, F8 z, const float* m) {
  return {splat(m[0]) * x + splat(m[1]) * y + splat(m[2]) * z, splat(m[3]) * x + splat(m[4]) * y + splat(m[5]) * z,
          splat(m[6]) * x + splat(m[7]) * y + splat(m[8]) * z};
}

inline const Block& toolBlock(const PairSearch& s, std::uint32_t b) {
  Block& out = s.turned_tool[b];
  if (s.turned_when[b] == s.now) return out;
  const Block& in = s.tool.bound[b];
  const Turned t = turn(load(in.x), load(in.y), load(in.z), s.rotation);
  store(out.x, t.x);
  store(out.y, t.y);
  store(out.z, t.z);
  store(out.r, load(in.r));
  s.turned_when[b] = s.now;
  return out;
}

struct Hits {
  F8 square, sum;  // squared distance of the centres, sum of the radii
};
// One sphere against the lanes of a block.
inline Hits measure(float x, float y, float z, float r, const Block& block) {
  const F8 dx = splat(x) - load(block.x), dy = splat(y) - load(block.y), dz = splat(z) - load(block.z);
  return {dx * dx + dy * dy + dz * dz, splat(r) + load(block.r)};
}
inline unsigned within(const Hits& h, float margin) {
  const F8 reach = h.sum + splat(margin);
  return maskOf(h.square <= reach * reach);
}

bool touchesExactly(const ExactTest& t, std::uint32_t tool, std::uint32_t object, double radius_sum) {
  const double x = t.tool[tool][0], y = t.tool[tool][1], z = t.tool[tool][2];
  const double* m = t.rotation;
  const double dx = (m[0] * x + m[1] * y + m[2] * z) + t.offset[0] - t.object[object][0];
  const double dy = (m[3] * x + m[4] * y + m[5] * z) + t.offset[1] - t.object[object][1];
  const double dz = (m[6] * x + m[7] * y + m[8] * z) + t.offset[2] - t.object[object][2];
  const double reach = radius_sum + t.margin;
  return dx * dx + dy * dy + dz * dz <= reach * reach;
}

// Of the leaf lanes `leaves` (tool_name and object_name give the slots of lane k), those that are in.
template <class Slots>
inline unsigned leafHits(const PairSearch& s, const Hits& h, unsigned leaves, float radius, const Block& block, Slots slots) {
  const unsigned sure = within(h, s.sure_margin) & leaves;
  if (!s.exact.tool) return sure;
  unsigned hits = sure;
  for (unsigned doubt = within(h, s.maybe_margin) & leaves & ~sure; doubt; doubt &= doubt - 1) {
    const unsigned lane = static_cast<unsigned>(__builtin_ctz(doubt));
    const std::uint32_t name = slots(lane);
    if (touchesExactly(s.exact, name >> 16, name & 0xffff, static_cast<double>(radius) + static_cast<double>(block.r[lane])))
      hits |= 1u << lane;
  }
  return hits;
}

constexpr U8 kLanes{0, 1, 2, 3, 4, 5, 6, 7};

PairSearchResult findPairs(const PairSearch& s) {
  const float ox = s.offset[0], oy = s.offset[1], oz = s.offset[2];
  std::uint32_t* leaf_end = s.pairs;
  std::uint32_t *now = s.lists[0], *now_end = now, *next = s.lists[1];
  std::uint32_t work = 1;
  {
    const Block& a = toolBlock(s, 0);
    const Hits h = measure(a.x[0] + ox, a.y[0] + oy, a.z[0] + oz, a.r[0], s.object.bound[0]);
    if (s.tool.child_block[0] == 0 && s.object.child_block[0] == 0) {
      const unsigned hit = leafHits(s, h, 1, a.r[0], s.object.bound[0], [](unsigned) { return 0u; });
      if (hit) *leaf_end++ = 0;
    } else if (within(h, s.inner_margin) & 1) {
      *now_end++ = 0;
    }
  }
  while (now_end != now) {
    std::uint32_t* const leaf_begin = leaf_end;  // of this level
    std::uint32_t* next_end = next;
    for (const std::uint32_t* item = now; item != now_end; ++item) {
      if (static_cast<std::size_t>(leaf_end - s.pairs) + static_cast<std::size_t>(next_end - next) + 64 > s.capacity ||
          work + 9 > s.max_work) {
        // The last whole level stands in: the leaf pairs of the levels before it and all its own pairs.
        leaf_end = leaf_begin;
        for (const std::uint32_t* k = now; k != now_end; ++k) *leaf_end++ = *k;
        return {static_cast<std::uint32_t>(leaf_end - s.pairs), work, true};
      }
      const std::uint32_t ts = *item >> 16, os = *item & 0xffff, tb = s.tool.child_block[ts], ob = s.object.child_block[os];
      if (ob) {
        const Block& object = s.object.bound[ob];
        const unsigned object_inner = (1u << s.object.inner_lanes[ob]) - 1;
        unsigned rows;
        std::uint32_t first;
        if (tb) {  // the object's node against the tool's lanes first
          const Block& b = s.object.bound[os >> 3];
          const unsigned k = os & 7;
          rows = within(measure(b.x[k] - ox, b.y[k] - oy, b.z[k] - oz, b.r[k], toolBlock(s, tb)), s.inner_margin);
          first = 8 * tb;
          ++work;
        } else {
          rows = 1;
          first = ts;
        }
        for (; rows; rows &= rows - 1) {
          const std::uint32_t slot = first + static_cast<std::uint32_t>(__builtin_ctz(rows));
          const Block& a = s.turned_tool[slot >> 3];  // turned when its node was met
          const unsigned k = slot & 7;
          const Hits h = measure(a.x[k] + ox, a.y[k] + oy, a.z[k] + oz, a.r[k], object);
          ++work;
          const std::uint32_t base = slot << 16 | ob << 3;
          const U8 names = splatU(base) + kLanes;
          if (s.tool.child_block[slot]) {
            next_end = append(next_end, names, within(h, s.inner_margin));
          } else {
            leaf_end =
                append(leaf_end, names, leafHits(s, h, 0xffu & ~object_inner, a.r[k], object, [&](unsigned lane) { return base + lane; }));
            if (object_inner) next_end = append(next_end, names, within(h, s.inner_margin) & object_inner);
          }
        }
      } else {  // an object's leaf against the children of a tool node
        const Block& b = s.object.bound[os >> 3];
        const Block& tool = toolBlock(s, tb);
        const unsigned k = os & 7, tool_inner = (1u << s.tool.inner_lanes[tb]) - 1;
        const Hits h = measure(b.x[k] - ox, b.y[k] - oy, b.z[k] - oz, b.r[k], tool);
        ++work;
        const std::uint32_t base = tb << 19 | os;
        const U8 names = splatU(base) + (kLanes << 16);
        leaf_end =
            append(leaf_end, names, leafHits(s, h, 0xffu & ~tool_inner, b.r[k], tool, [&](unsigned lane) { return base + (lane << 16); }));
        if (tool_inner) next_end = append(next_end, names, within(h, s.inner_margin) & tool_inner);
      }
    }
    std::uint32_t* const done = now;
    now = next;
    now_end = next_end;
    next = done;
  }
  return {static_cast<std::uint32_t>(leaf_end - s.pairs), work, false};
}

float makeRows(const RowRequest& q) {
  const F8 ox = splat(q.offset[0]), oy = splat(q.offset[1]), oz = splat(q.offset[2]), inverse = splat(q.inverse_angle_length),
           one = splat(1);
  F8 smallest = splat(__builtin_inff());
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    const std::uint32_t* pairs = q.pairs + i;
    std::uint32_t tail[8];
    if (i + 8 > q.count) {  // the last pair fills up: what stands beyond belongs to another object
      for (std::uint32_t k = 0; k < 8; ++k) tail[k] = q.pairs[i + k < q.count ? i + k : q.count - 1];
      pairs = tail;
    }
    const Sphere *tool[8], *object[8];
    for (unsigned k = 0; k < 8; ++k) {
      tool[k] = q.tool + (pairs[k] >> 16);
      object[k] = q.object + (pairs[k] & 0xffff);
    }
    F8 rx, ry, rz, tr, cx, cy, cz, cr;
    transpose(tool, rx, ry, rz, tr);
    transpose(object, cx, cy, cz, cr);
    const Turned arm = turn(rx, ry, rz, q.rotation);
    rx = arm.x;
    ry = arm.y;
    rz = arm.z;
    F8 nx = (rx + ox) - cx, ny = (ry + oy) - cy, nz = (rz + oz) - cz;
    const F8 square = nx * nx + ny * ny + nz * nz, sum = tr + cr;
    const I8 apart = square > splat(1e-20f);  // else the centres coincide and +z is as good as any normal
    const F8 d = squareRoot(square), scale = one / select(apart, d, one);
    nx = select(apart, nx * scale, splat(0));
    ny = select(apart, ny * scale, splat(0));
    nz = select(apart, nz * scale, one);
    F8 gap = d - sum;
    smallest = select(gap < smallest, gap, smallest);
    F8 ax = (ry * nz - rz * ny) * inverse, ay = (rz * nx - rx * nz) * inverse, az = (rx * ny - ry * nx) * inverse;
    if (q.squared) {
      gap = gap * (d + sum) * (splat(0.5f) * scale);
      const F8 wx = ax, wy = ay, wz = az;
      ax = splat(q.axes[0]) * wx + splat(q.axes[1]) * wy + splat(q.axes[2]) * wz;
      ay = splat(q.axes[3]) * wx + splat(q.axes[4]) * wy + splat(q.axes[5]) * wz;
      az = splat(q.axes[6]) * wx + splat(q.axes[7]) * wy + splat(q.axes[8]) * wz;
    }
    const F8 weight = one / squareRoot(one + (ax * ax + ay * ay + az * az));
    store(q.a[0] + i, nx * weight);
    store(q.a[1] + i, ny * weight);
    store(q.a[2] + i, nz * weight);
    store(q.a[3] + i, ax * weight);
    store(q.a[4] + i, ay * weight);
    store(q.a[5] + i, az * weight);
    store(q.b + i, -(gap * weight));
    store(q.weight + i, weight);
  }
  float least = smallest[0];
  for (unsigned k = 1; k < 8; ++k) least = smallest[k] < least ? smallest[k] : least;
  return least;
}

WorstRow worstRow(const float* const* a, const float* b, std::uint32_t count, const float* y) {
  const F8 y0 = splat(y[0]), y1 = splat(y[1]), y2 = splat(y[2]), y3 = splat(y[3]), y4 = splat(y[4]), y5 = splat(y[5]);
  F8 least = splat(__builtin_inff());
  U8 at = splatU(0), index = kLanes;
  for (std::uint32_t i = 0; i < count; i += 8, index += splatU(8)) {
    const F8 s = ((load(a[0] + i) * y0 + load(a[1] + i) * y1) + (load(a[2] + i) * y2 + load(a[3] + i) * y3)) +
                 ((load(a[4] + i) * y4 + load(a[5] + i) * y5) - load(b + i));
    const I8 less = s < least;
    least = select(less, s, least);
    at = (U8)(((I8)index & less) | ((I8)at & ~less));
  }
  WorstRow worst{at[0], least[0]};
  for (unsigned k = 1; k < 8; ++k)
    if (least[k] < worst.slack || (least[k] == worst.slack && at[k] < worst.row)) worst = {at[k], least[k]};
  return worst;
}

constexpr KernelTable kTable{findPairs, makeRows, worstRow};

}  // namespace
}  // namespace spheretree::runtime
