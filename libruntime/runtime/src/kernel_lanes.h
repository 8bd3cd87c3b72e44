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

// 8 rows of a QP: six coefficients of each, times `scale`.
inline void storeScaled(float* const a[6], std::uint32_t i, const F8 (&row)[6], F8 scale) {
  for (unsigned k = 0; k < 6; ++k) store(a[k] + i, row[k] * scale);
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

// 8 balls, or one 8 times.
struct Balls {
  F8 x, y, z, r;
};
inline Balls ballsOf(const Block& b) { return {load(b.x), load(b.y), load(b.z), load(b.r)}; }
inline Balls ballOf(const Block& b, unsigned k) { return {splat(b.x[k]), splat(b.y[k]), splat(b.z[k]), splat(b.r[k])}; }

struct Hits {
  F8 square, sum;  // squared distance of the centres, sum of the radii
};
inline Hits measure(const Balls& a, const Balls& b) {
  const F8 dx = a.x - b.x, dy = a.y - b.y, dz = a.z - b.z;
  return {dx * dx + dy * dy + dz * dz, a.r + b.r};
}
inline unsigned within(const Hits& h, float margin) {
  const F8 reach = h.sum + splat(margin);
  return maskOf(h.square <= reach * reach);
}

constexpr U8 kLanes{0, 1, 2, 3, 4, 5, 6, 7};

// One search. Breadth first over all near objects together, in straight loops: of two nodes that touch the one that promises more is
// opened, and its children meet the other one all at once; what they hit is only appended to a list.
class PairFinder {
 public:
  explicit PairFinder(const PairSearch& s) : s_(s), leaf_end_(s.leaves), open_tool_end_(s.open_tool), open_object_end_(s.open_object) {
    for (int k = 0; k < 9; ++k) rotation_[k] = static_cast<float>(s.rotation[k]);
  }

  PairSearchResult run() {
    const std::uint32_t near_count = findNear();
    live_ = near_count;
    for (std::uint32_t n = 0; n < near_count; ++n)  // the roots
      open<true>({0, n & 0xffff, 0, 1, 0});
    HitGroup *tool = s_.open_tool, *object = s_.open_object;
    bool full = false;
    // A group is at most 8 tests, and each adds at most one group to a list and 8 pairs in place of one.
    const HitGroup *const tool_limit = s_.open_tool + s_.list_capacity - 8, *const object_limit = s_.open_object + s_.list_capacity - 8;
    const auto goesOn = [&] {
      full = live_ + 64 > s_.capacity || work_ + 8 > s_.max_work || open_tool_end_ > tool_limit || open_object_end_ > object_limit;
      return !full;
    };
    while (!full && (tool != open_tool_end_ || object != open_object_end_)) {
      for (; tool != open_tool_end_ && goesOn(); ++tool) open<false>(*tool);
      if (tool == open_tool_end_) tool = open_tool_end_ = s_.open_tool;
      for (; object != open_object_end_ && goesOn(); ++object) open<true>(*object);
      if (object == open_object_end_) object = open_object_end_ = s_.open_object;
    }
    // Out of room or work: what is still to open stands for the leaves below it.
    for (; tool != open_tool_end_; ++tool) *leaf_end_++ = *tool;
    for (; object != open_object_end_; ++object) *leaf_end_++ = *object;
    return {gather(near_count), near_count, work_, full};
  }

 private:
  // The pairs, by object.
  std::uint32_t gather(std::uint32_t near_count) {
    for (std::uint32_t n = 0; n < near_count; ++n) s_.near_counts[n] = 0;
    for (const HitGroup* g = s_.leaves; g != leaf_end_; ++g) ++s_.near_counts[g->near];
    std::uint32_t begin = 0;
    for (std::uint32_t n = 0; n < near_count; ++n) {
      const std::uint32_t count = s_.near_counts[n];
      s_.near_counts[n] = begin;
      begin += count;
    }
    for (const HitGroup* g = s_.leaves; g != leaf_end_; ++g) s_.open_tool[s_.near_counts[g->near]++] = *g;
    std::uint32_t* end = s_.pairs;
    const HitGroup* g = s_.open_tool;
    for (std::uint32_t n = 0; n < near_count; ++n) {
      const std::uint32_t* const from = end;
      for (const HitGroup* const last = s_.open_tool + s_.near_counts[n]; g != last; ++g)
        end = append(end, splatU(g->name) + (kLanes << splatU(16 * g->tool_varies)), g->lanes);
      s_.near_counts[n] = static_cast<std::uint32_t>(end - from);
    }
    return static_cast<std::uint32_t>(end - s_.pairs);
  }

  // The objects whose bounding spheres the tool's meets.
  std::uint32_t findNear() {
    const Balls root{splat(s_.root[0]), splat(s_.root[1]), splat(s_.root[2]), splat(s_.root[3])};
    std::uint32_t* end = s_.near_objects;
    for (std::uint32_t i = 0; i < s_.object_count; i += 8, ++work_)
      end = append(end, splatU(i) + kLanes, within(measure(root, ballsOf(s_.object_roots[i / 8])), 0));
    const auto count = static_cast<std::uint32_t>(end - s_.near_objects);
    if (count > 0) turnedTool(0);
    for (std::uint32_t n = 0; n < count; ++n) {
      ObjectView& view = s_.near_views[n];
      view = s_.objects[s_.near_objects[n]];
      for (int k = 0; k < 3; ++k) view.offset[k] = static_cast<float>(s_.position[k] - view.anchor[k]);
    }
    return count;
  }

  const Block& turnedTool(std::uint32_t b) {
    Block& out = s_.turned_tool[b];
    if (s_.turned_when[b] == s_.now) return out;
    const Block& in = s_.tool[b];
    const Turned t = turn(load(in.x), load(in.y), load(in.z), rotation_);
    store(out.x, t.x);
    store(out.y, t.y);
    store(out.z, t.z);
    store(out.r, load(in.r));
    s_.turned_when[b] = s_.now;
    return out;
  }

  // The tests that a group asks for. Of tool and object one is the one node (`kToolIsOne`), the other has the many.
  template <bool kToolIsOne>
  void open(const HitGroup& g) {
    const ObjectView& view = s_.near_views[g.near];
    const F8 ox = splat(view.offset[0]), oy = splat(view.offset[1]), oz = splat(view.offset[2]);
    const auto moved = [&](Balls b) { return Balls{b.x + ox, b.y + oy, b.z + oz, b.r}; };
    const auto one = [&](std::uint32_t slot) {
      return kToolIsOne ? moved(ballOf(s_.turned_tool[slot >> 3], slot & 7)) : ballOf(view.bound[slot >> 3], slot & 7);
    };
    const auto many = [&](std::uint32_t b) { return kToolIsOne ? ballsOf(view.bound[b]) : moved(ballsOf(turnedTool(b))); };
    const std::uint32_t slot = kToolIsOne ? g.name >> 16 : g.name & 0xffff, b = g.many;
    const auto count = static_cast<std::uint32_t>(__builtin_popcount(g.lanes));
    live_ -= count;
    work_ += count;
    if (g.tool_varies == kToolIsOne) {
      const Balls fixed = many(b);
      for (unsigned lanes = g.lanes; lanes; lanes &= lanes - 1) {
        const auto k = static_cast<std::uint32_t>(__builtin_ctz(lanes));
        meet<kToolIsOne>(view, g, slot + k, one(slot + k), b, fixed);
      }
    } else {
      const Balls fixed = one(slot);
      for (unsigned lanes = g.lanes; lanes; lanes &= lanes - 1) {
        const auto k = static_cast<std::uint32_t>(__builtin_ctz(lanes));
        meet<kToolIsOne>(view, g, slot, fixed, b + k, many(b + k));
      }
    }
  }

  // One node against the 8 of a block: what it meets, to where it goes on. Of a leaf and another node the other is opened.
  template <bool kToolIsOne>
  void meet(const ObjectView& view, const HitGroup& g, std::uint32_t slot, const Balls& one, std::uint32_t b, const Balls& many) {
    const Hits h = measure(one, many);
    const unsigned hits = within(h, s_.inner_margin);
    if (hits == 0) return;
    const BlockLinks &links = (kToolIsOne ? view.links : s_.tool_links)[b],
                     &one_links = (kToolIsOne ? s_.tool_links : view.links)[slot >> 3];
    const std::uint32_t name = kToolIsOne ? slot << 16 | b << 3 : b << 19 | slot;
    const unsigned more = hits & ((1u << links.inner) - 1) & maskOf(load(links.open_priority) >= splat(one_links.open_priority[slot & 7]));
    const unsigned others = hits & ~more;
    live_ += static_cast<std::uint32_t>(__builtin_popcount(hits));
    const auto add = [&](HitGroup*& end, unsigned lanes, std::uint32_t next) {
      *end = {name, g.near, next & 0xffff, lanes & 0xff, !kToolIsOne};
      end += lanes != 0;  // no jump: which lists a test adds to cannot be predicted
    };
    add(kToolIsOne ? open_object_end_ : open_tool_end_, more, links.first_child);
    if ((slot & 7) < one_links.inner) {
      add(kToolIsOne ? open_tool_end_ : open_object_end_, others, one_links.first_child + (slot & 7));
    } else {
      const unsigned doubt = others & ~within(h, s_.sure_margin);
      const unsigned apart = doubt ? apartExactly(name, kToolIsOne ? 1 : 1u << 16, view, doubt) : 0;
      live_ -= static_cast<std::uint32_t>(__builtin_popcount(apart));
      add(leaf_end_, others & ~apart, 0);
    }
  }

  // Those of the pairs that double arithmetic finds apart.
  [[gnu::noinline]] unsigned apartExactly(std::uint32_t name, std::uint32_t step, const ObjectView& view, unsigned doubt) const {
    unsigned apart = 0;
    for (unsigned lane = 0; lane < 8; ++lane) {
      const std::uint32_t pair = name + lane * step;
      if (doubt >> lane & 1 && !touchesExactly(pair >> 16, pair & 0xffff, view)) apart |= 1u << lane;
    }
    return apart;
  }
  bool touchesExactly(std::uint32_t tool, std::uint32_t object, const ObjectView& view) const {
    const double *a = &s_.exact_tool[tool][0], *b = &view.exact[object][0], *m = s_.rotation;
    double square = 0;
    for (int k = 0; k < 3; ++k) {
      const double d = (m[3 * k] * a[0] + m[3 * k + 1] * a[1] + m[3 * k + 2] * a[2]) + (s_.position[k] - view.anchor[k]) - b[k];
      square += d * d;
    }
    const double reach =
        static_cast<double>(s_.tool[tool >> 3].r[tool & 7]) + static_cast<double>(view.bound[object >> 3].r[object & 7]) + s_.margin;
    return square <= reach * reach;
  }

  const PairSearch& s_;
  HitGroup *leaf_end_, *open_tool_end_, *open_object_end_;
  float rotation_[9];
  std::uint32_t work_ = 0, live_ = 0;  // live: pairs in the lists that are not opened yet, and those of leaves
};

PairSearchResult findPairs(const PairSearch& s) { return PairFinder(s).run(); }

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
    storeScaled(q.a, i, {nx, ny, nz, ax, ay, az}, weight);
    store(q.b + i, -(gap * weight));
    store(q.weight + i, weight);
  }
  float least = smallest[0];
  for (unsigned k = 1; k < 8; ++k) least = smallest[k] < least ? smallest[k] : least;
  return least;
}

struct Vector8 {
  F8 x, y, z;
};
inline F8 dot(const Vector8& a, const Vector8& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// 8 balls of the tool, each with a bridge.
struct BallsAtBridges {
  Turned arm;  // from the reference point to the centres
  F8 tool_radius, radius, length, u_extra, v_extra;
  Vector8 axis, u, v, across;
  F8 along, ut, vt, off2;  // of the centre from the first leaf: along and across the axis, and what u and v say
  I8 is_cone;

  BallsAtBridges(const BridgeRequest& q, const std::uint32_t* pairs, std::uint32_t count) {
    const Sphere *tool[8], *part[4][8];
    for (std::uint32_t k = 0; k < 8; ++k) {
      const std::uint32_t pair = pairs[k < count ? k : count - 1];
      tool[k] = q.tool + (pair >> 16);
      const Bridge* const bridge = q.bridges + (pair & 0xffff);
      for (int p = 0; p < 4; ++p) part[p][k] = reinterpret_cast<const Sphere*>(bridge) + p;  // four floats each
    }
    F8 rx, ry, rz, ax, ay, az;
    transpose(tool, rx, ry, rz, tool_radius);
    transpose(part[0], ax, ay, az, radius);
    transpose(part[1], axis.x, axis.y, axis.z, length);
    transpose(part[2], u.x, u.y, u.z, u_extra);
    transpose(part[3], v.x, v.y, v.z, v_extra);
    arm = turn(rx, ry, rz, q.rotation);
    const Vector8 t{(arm.x + splat(q.offset[0])) - ax, (arm.y + splat(q.offset[1])) - ay, (arm.z + splat(q.offset[2])) - az};
    along = dot(axis, t);
    ut = dot(u, t);
    vt = dot(v, t);
    is_cone = length > splat(0);
    across = {t.x - along * axis.x, t.y - along * axis.y, t.z - along * axis.z};
    off2 = dot(across, across);
  }
  F8 flatGap() const { return along - radius; }
  F8 coneGap(F8 off) const { return along * (u_extra * v_extra) + off * v_extra - radius; }
  F8 foot(F8 off) const { return along - off * u_extra; }
};

std::uint32_t nearBridges(const BridgeRequest& q, std::uint32_t* to) {
  std::uint32_t* const first = to;
  const F8 one = splat(1), slack = splat(kBridgeSlack), margin = splat(q.most_gap), deepest = splat(-kDeepestDip - q.most_gap);
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    const std::uint32_t left = q.count - i;
    const BallsAtBridges at(q, q.pairs + i, left);
    const F8 du = slack + margin * squareRoot(dot(at.u, at.u)), dv = slack + margin * squareRoot(dot(at.v, at.v));
    const F8 off = squareRoot(at.off2), foot = at.foot(off);
    const F8 lean = select(at.u_extra < splat(0), -at.u_extra, at.u_extra), beyond = slack * at.length + margin * (one + lean);
    const F8 gap = select(at.is_cone, at.coneGap(off), at.flatGap()) - at.tool_radius;
    const I8 at_facet = (at.ut > -du) & (at.vt > -dv) & (at.ut + at.vt < one + du + dv);
    const I8 at_cone = (foot > -beyond) & (foot < at.length + beyond) & (at.ut <= du) & (at.vt <= dv);
    U8 names;
    __builtin_memcpy(&names, q.pairs + i, sizeof names);
    unsigned kept = maskOf(((at_cone & at.is_cone) | (at_facet & ~at.is_cone)) & (gap >= deepest) & (gap <= margin));
    if (left >= 8) {
      to = append(to, names, kept);
    } else {  // one by one: past the last of them the pairs of the next object begin, which are still to be read
      for (kept &= (1u << left) - 1; kept; kept &= kept - 1) *to++ = names[__builtin_ctz(kept)];
    }
  }
  return static_cast<std::uint32_t>(to - first);
}

void makeBridgeRows(const BridgeRequest& q, const RowMemory& out) {
  const F8 one = splat(1), zero = splat(0), slack = splat(kBridgeSlack), inverse = splat(q.inverse_angle_length);
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    const BallsAtBridges at(q, q.pairs + i, q.count - i);
    // Facet: between its leaves, and on this side of their centres.
    const F8 flat_gap = at.flatGap(), here = at.radius + at.ut * at.u_extra + at.vt * at.v_extra;
    const I8 on_facet = (at.ut > -slack) & (at.vt > -slack) & (at.ut + at.vt < one + slack) & (flat_gap + here > zero);
    // Cone: the normal leans along the axis by its slope.
    const I8 beside = at.off2 > splat(1e-12f) * at.length * at.length;
    const F8 off = squareRoot(select(beside, at.off2, one)), foot = at.foot(off), slope = at.u_extra * at.v_extra,
             outward = at.v_extra / off;
    const I8 on_cone = (foot > -(slack * at.length)) & (foot < (one + slack) * at.length) & (at.ut <= slack) & (at.vt <= slack) & beside;
    const F8 nx = select(at.is_cone, at.axis.x * slope + at.across.x * outward, at.axis.x),
             ny = select(at.is_cone, at.axis.y * slope + at.across.y * outward, at.axis.y),
             nz = select(at.is_cone, at.axis.z * slope + at.across.z * outward, at.axis.z);
    const F8 gap = select(at.is_cone, at.coneGap(off), flat_gap) - at.tool_radius;
    // A facet that the ball is beside and clearly above counts too: across a valley it is what stops the ball next. Across a ridge the ball
    // is below its plane; and at the plane itself there is nothing to rest on, and rounding would say whether it counts.
    const I8 touches = ((on_cone & at.is_cone) | ((on_facet | (gap > splat(kClearOfFacet))) & ~at.is_cone)) & (gap >= splat(-kDeepestDip)) &
                       (gap <= splat(q.most_gap));
    const Turned& arm = at.arm;
    const F8 wx = (arm.y * nz - arm.z * ny) * inverse, wy = (arm.z * nx - arm.x * nz) * inverse, wz = (arm.x * ny - arm.y * nx) * inverse;
    const F8 weight = one / squareRoot(one + (wx * wx + wy * wy + wz * wz)), scale = select(touches, weight, zero);
    storeScaled(out.a, i, {nx, ny, nz, wx, wy, wz}, scale);
    store(out.b + i, select(touches, -(gap * weight), splat(-1e30f)));
    store(out.weight + i, weight);
  }
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

constexpr KernelTable kTable{findPairs, makeRows, nearBridges, makeBridgeRows, worstRow};

}  // namespace
}  // namespace spheretree::runtime
