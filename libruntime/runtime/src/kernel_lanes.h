// SPDX-License-Identifier: Apache-2.0
// The code of the inner loops, included by one source for each instruction set. Everything here has internal linkage
// and calls no inline function of the standard library or Eigen: of such a function the linker keeps one copy, which
// may have been compiled for the newer machine.
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
inline Turned turn(const F8& x, const F8& y, const F8& z, const float* m) {
  return {splat(m[0]) * x + splat(m[1]) * y + splat(m[2]) * z, splat(m[3]) * x + splat(m[4]) * y + splat(m[5]) * z,
          splat(m[6]) * x + splat(m[7]) * y + splat(m[8]) * z};
}

// 8 balls, or one ball 8 times.
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

struct Vector8 {
  F8 x, y, z;
};
inline Vector8 operator+(const Vector8& a, const Vector8& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector8 operator-(const Vector8& a, const Vector8& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector8 operator*(const F8& f, const Vector8& a) { return {f * a.x, f * a.y, f * a.z}; }
inline F8 dot(const Vector8& a, const Vector8& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector8 cross(const Vector8& a, const Vector8& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline Vector8 select(const I8& mask, const Vector8& yes, const Vector8& no) {
  return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z)};
}
inline Vector8 splat(float x, float y, float z) { return {splat(x), splat(y), splat(z)}; }
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

// Squared distances from 8 points to 8 triangles.
inline F8 squareToTriangle(const Vector8& p0, const Vector8& p1, const Vector8& p2, const Vector8& point) {
  const F8 one = splat(1), zero = splat(0);
  const Vector8 corner[3] = {p0, p1, p2}, side[3] = {p1 - p0, p2 - p1, p0 - p2}, across = cross(side[0], p2 - p0);
  const F8 area2 = dot(across, across);
  I8 over = area2 > splat(1e-30f);
  F8 nearest = splat(__builtin_inff());
#pragma GCC unroll 1  // smaller, and no slower
  for (unsigned k = 0; k < 3; ++k) {
    const Vector8 from = point - corner[k];
    over = over & (dot(cross(across, side[k]), from) >= zero);
    const F8 length2 = dot(side[k], side[k]);
    const Vector8 to = from - clamp01(dot(from, side[k]) / select(length2 > zero, length2, one)) * side[k];
    nearest = minOf(nearest, dot(to, to));
  }
  const F8 height = dot(across, point - p0);
  return select(over, height * height / select(over, area2, one), nearest);
}

// One search, object by object, breadth first in loops without recursion. Of two nodes that touch, the one with the
// higher open_priority is opened, and all its children are tested against the other node at once; hits are only
// appended to a list.
class PairFinder {
 public:
  explicit PairFinder(const PairSearch& s) : s_(s), pairs_end_(s.pairs), work_((s.object_count + 7) / 8), live_(s.near_count) {}

  PairSearchResult run() {
    bool full = false;
    for (std::uint32_t n = 0; n < s_.near_count; ++n) {
      const std::uint32_t* const from = pairs_end_;
      full = searchObject(s_.objects[s_.near_objects[n]], s_.turn_count + n + 1, full) || full;
      s_.near_counts[n] = static_cast<std::uint32_t>(pairs_end_ - from);
    }
    return {static_cast<std::uint32_t>(pairs_end_ - s_.pairs), work_, full};
  }

 private:
  // Appends the pairs of one object. Returns true if memory or work ran out; from then on, or if `full` was set, the
  // nodes that are not opened yet replace everything below them.
  bool searchObject(const ObjectView& view, std::uint32_t turn, bool full) {
    view_ = &view;
    turn_ = turn;
    pose_ = relativePose(view, s_.rotation, s_.position);
    leaf_end_ = s_.leaves;
    open_tool_end_ = s_.open_tool;
    open_object_end_ = s_.open_object;
    *open_object_end_++ = {0, 0, 1, 0};  // the roots
    turnedTool(0);
    HitGroup *tool = s_.open_tool, *object = s_.open_object;
    // A group is at most 8 tests, and each adds at most one group to a list and 8 pairs in place of one.
    const HitGroup *const tool_limit = s_.open_tool + s_.list_capacity - 8, *const object_limit = s_.open_object + s_.list_capacity - 8;
    const auto goesOn = [&] {
      full = full || live_ + 64 > s_.capacity || work_ + 8 > s_.max_work || open_tool_end_ > tool_limit || open_object_end_ > object_limit;
      return !full;
    };
    while (!full && (tool != open_tool_end_ || object != open_object_end_)) {
      for (; tool != open_tool_end_ && goesOn(); ++tool) open<false>(*tool);
      if (tool == open_tool_end_) tool = open_tool_end_ = s_.open_tool;
      for (; object != open_object_end_ && goesOn(); ++object) open<true>(*object);
      if (object == open_object_end_) object = open_object_end_ = s_.open_object;
    }
    for (const HitGroup* g = s_.leaves; g != leaf_end_; ++g) appendPairs(*g);
    for (; tool != open_tool_end_; ++tool) appendPairs(*tool);
    for (; object != open_object_end_; ++object) appendPairs(*object);
    return full;
  }

  void appendPairs(const HitGroup& g) { pairs_end_ = append(pairs_end_, splatU(g.pair) + (kLanes << splatU(16 * g.tool_varies)), g.lanes); }

  const Block& turnedTool(std::uint32_t b) {
    Block& out = s_.turned_tool[b];
    if (s_.turned_when[b] == turn_) return out;
    const Block& in = s_.tool[b];
    const Turned t = turn(load(in.x), load(in.y), load(in.z), pose_.rotation);
    store(out.x, t.x);
    store(out.y, t.y);
    store(out.z, t.z);
    store(out.r, load(in.r));
    s_.turned_when[b] = turn_;
    return out;
  }

  // Makes the tests of a group. With `kToolIsOne` a single node of the tool is tested against 8 nodes of the object,
  // otherwise the other way round.
  template <bool kToolIsOne>
  void open(const HitGroup& g) {
    const ObjectView& view = *view_;
    const F8 ox = splat(pose_.offset[0]), oy = splat(pose_.offset[1]), oz = splat(pose_.offset[2]);
    const auto moved = [&](Balls b) { return Balls{b.x + ox, b.y + oy, b.z + oz, b.r}; };
    const auto one = [&](std::uint32_t slot) {
      return kToolIsOne ? moved(ballOf(s_.turned_tool[slot >> 3], slot & 7)) : ballOf(view.bound[slot >> 3], slot & 7);
    };
    const auto many = [&](std::uint32_t b) { return kToolIsOne ? ballsOf(view.bound[b]) : moved(ballsOf(turnedTool(b))); };
    const std::uint32_t slot = kToolIsOne ? g.pair >> 16 : g.pair & 0xffff, b = g.open_block;
    const auto count = static_cast<std::uint32_t>(__builtin_popcount(g.lanes));
    live_ -= count;
    work_ += count;
    if (g.tool_varies == kToolIsOne) {
      const Balls fixed = many(b);
      for (unsigned lanes = g.lanes; lanes; lanes &= lanes - 1) {
        const auto k = static_cast<std::uint32_t>(__builtin_ctz(lanes));
        meet<kToolIsOne>(view, slot + k, one(slot + k), b, fixed);
      }
    } else {
      const Balls fixed = one(slot);
      for (unsigned lanes = g.lanes; lanes; lanes &= lanes - 1) {
        const auto k = static_cast<std::uint32_t>(__builtin_ctz(lanes));
        meet<kToolIsOne>(view, slot, fixed, b + k, many(b + k));
      }
    }
  }

  // Tests one node against the 8 nodes of a block, and appends the hits to the list of what is opened next. Of a leaf
  // and an inner node, the inner node is opened.
  template <bool kToolIsOne>
  void meet(const ObjectView& view, std::uint32_t slot, const Balls& one, std::uint32_t b, const Balls& many) {
    const Hits h = measure(one, many);
    unsigned hits = within(h, s_.inner_margin + view.motion);
    if (hits == 0) return;
    const BlockLinks &links = (kToolIsOne ? view.links : s_.tool_links)[b],
                     &one_links = (kToolIsOne ? s_.tool_links : view.links)[slot >> 3];
    if (!kToolIsOne && view.still_patches && (slot & 7) >= one_links.inner) hits &= nearTriangle(view, slot, many);
    if (hits == 0) return;
    const std::uint32_t name = kToolIsOne ? slot << 16 | b << 3 : b << 19 | slot;
    const unsigned more = hits & ((1u << links.inner) - 1) & maskOf(load(links.open_priority) >= splat(one_links.open_priority[slot & 7]));
    const unsigned others = hits & ~more;
    live_ += static_cast<std::uint32_t>(__builtin_popcount(hits));
    const auto add = [&](HitGroup*& end, unsigned lanes, std::uint32_t next) {
      *end = {name, next & 0xffff, lanes & 0xff, !kToolIsOne};
      end += lanes != 0;  // branchless, since the lists to which a test adds are unpredictable
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

  // The balls of the tool within the margin of a patch. A large triangle fills only a small part of its sphere.
  [[gnu::noinline]] unsigned nearTriangle(const ObjectView& view, std::uint32_t slot, const Balls& balls) const {
    const auto& p = view.still_patches[view.items[slot]].position;
    const F8 square = squareToTriangle(splat(p[0][0], p[0][1], p[0][2]), splat(p[1][0], p[1][1], p[1][2]), splat(p[2][0], p[2][1], p[2][2]),
                                       {balls.x, balls.y, balls.z});
    const F8 reach = balls.r + splat(s_.inner_margin + view.allowance);
    return maskOf(square <= reach * reach);
  }

  // The pairs that are apart in double arithmetic.
  [[gnu::noinline]] unsigned apartExactly(std::uint32_t name, std::uint32_t step, const ObjectView& view, unsigned doubt) const {
    unsigned apart = 0;
    for (unsigned lane = 0; lane < 8; ++lane) {
      const std::uint32_t pair = name + lane * step;
      if (doubt >> lane & 1 && !touchesExactly(pair >> 16, pair & 0xffff, view)) apart |= 1u << lane;
    }
    return apart;
  }
  bool touchesExactly(std::uint32_t tool, std::uint32_t object, const ObjectView& view) const {
    const double *a = &s_.exact_tool[tool][0], *b = &view.exact[object][0], *m = s_.rotation, *w = view.to_world;
    double d[3], square = 0;  // from the anchor to the tool's centre, world axes
    for (int k = 0; k < 3; ++k) d[k] = (m[3 * k] * a[0] + m[3 * k + 1] * a[1] + m[3 * k + 2] * a[2]) + (s_.position[k] - view.anchor[k]);
    for (int k = 0; k < 3; ++k) {
      const double along = (w[k] * d[0] + w[3 + k] * d[1] + w[6 + k] * d[2]) - b[k];
      square += along * along;
    }
    const double reach =
        static_cast<double>(s_.tool[tool >> 3].r[tool & 7]) + static_cast<double>(view.bound[object >> 3].r[object & 7]) + s_.margin;
    return square <= reach * reach;
  }

  const PairSearch& s_;
  std::uint32_t* pairs_end_;
  const ObjectView* view_ = nullptr;
  RelativePose pose_{};
  std::uint32_t turn_ = 0;
  HitGroup *leaf_end_ = nullptr, *open_tool_end_ = nullptr, *open_object_end_ = nullptr;
  std::uint32_t work_, live_;  // live: pairs in the lists that are not opened yet, and pairs of leaves
};

std::uint32_t findNear(const PairSearch& s) {
  const Balls root{splat(s.root[0]), splat(s.root[1]), splat(s.root[2]), splat(s.root[3])};
  std::uint32_t* end = s.near_objects;
  for (std::uint32_t i = 0; i < s.object_count; i += 8)
    end = append(end, splatU(i) + kLanes, within(measure(root, ballsOf(s.object_roots[i / 8])), 0));
  return static_cast<std::uint32_t>(end - s.near_objects);
}

PairSearchResult findPairs(const PairSearch& s) { return PairFinder(s).run(); }

// 8 balls of the tool, in the axes of the object.
struct ToolBalls {
  std::uint32_t slot[8];  // of the object, for each pair
  Vector8 arm, centre;    // from the reference point; from the anchor
  F8 radius;

  ToolBalls(const RowRequest& q, std::uint32_t first) {
    const Sphere* tool[8];
    for (std::uint32_t k = 0; k < 8; ++k) {  // the last pair is repeated, since the following ones belong to another object
      const std::uint32_t pair = q.pairs[first + k < q.count ? first + k : q.count - 1];
      tool[k] = q.tool + (pair >> 16);
      slot[k] = pair & 0xffff;
    }
    F8 x, y, z;
    transpose(tool, x, y, z, radius);
    const Turned t = turn(x, y, z, q.pose.rotation);
    arm = {t.x, t.y, t.z};
    centre = arm + splat(q.pose.offset[0], q.pose.offset[1], q.pose.offset[2]);
  }
};

// Stores rows of 8 pairs with these normals and gaps, in the axes of the object; rows that are not `in` are always
// satisfied.
inline void storeRows(const RowRequest& q, std::uint32_t i, const ToolBalls& balls, const Vector8& normal, F8 gap, I8 in) {
  const F8 one = splat(1), zero = splat(0);
  const Vector8 lever = splat(q.inverse_angle_length) * cross(balls.arm, normal);
  const Turned n = turn(normal.x, normal.y, normal.z, q.to_world);
  Turned a = turn(lever.x, lever.y, lever.z, q.to_world);
  if (q.squared) a = turn(a.x, a.y, a.z, q.axes);
  const F8 weight = one / squareRoot(one + (a.x * a.x + a.y * a.y + a.z * a.z));
  storeScaled(q.a, i, {n.x, n.y, n.z, a.x, a.y, a.z}, select(in, weight, zero));
  store(q.b + i, select(in, -(gap * weight), splat(-1e30f)));
  store(q.weight + i, weight);
}

float sphereRows(const RowRequest& q) {
  const F8 one = splat(1);
  F8 smallest = splat(__builtin_inff());
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    const ToolBalls balls(q, i);
    const Sphere* object[8];
    Sphere kept[8];
    for (unsigned k = 0; k < 8; ++k) {
      const std::uint32_t slot = balls.slot[k], lane = slot & 7;
      object[k] = q.object + slot;
      if (q.object) continue;
      const Block& b = q.bound[slot >> 3];
      kept[k] = {b.x[lane], b.y[lane], b.z[lane], b.r[lane]};
      object[k] = kept + k;
    }
    Vector8 c;
    F8 radius;
    transpose(object, c.x, c.y, c.z, radius);
    const Vector8 way = balls.centre - c;
    const F8 square = dot(way, way), sum = balls.radius + radius;
    const I8 apart = square > splat(1e-20f);  // otherwise the centres coincide, and the normal is +z
    const F8 d = squareRoot(square), scale = one / select(apart, d, one);
    F8 gap = d - sum;
    smallest = minOf(smallest, gap);
    if (q.squared) gap = gap * (d + sum) * (splat(0.5f) * scale);
    storeRows(q, i, balls, select(apart, scale * way, splat(0, 0, 1)), gap, apart | ~apart);
  }
  return minLane(smallest);
}

// 8 patches: the content of eight CompiledPatch, transposed.
struct Patches {
  Vector8 position[6];
  U8 packed[9];  // normals, two components in each
  U8 flags;

  Patches(const RowRequest& q, const ToolBalls& balls) {
    const CompiledPatch* patch[8];
    for (unsigned k = 0; k < 8; ++k) patch[k] = q.patches + q.items[balls.slot[k]];
    F8 column[28];
    for (unsigned part = 0; part < 7; ++part) {
      const Sphere* four[8];  // four floats each
      for (unsigned k = 0; k < 8; ++k) four[k] = reinterpret_cast<const Sphere*>(patch[k]) + part;
      transpose(four, column[4 * part], column[4 * part + 1], column[4 * part + 2], column[4 * part + 3]);
    }
    for (unsigned i = 0; i < 6; ++i) position[i] = {column[3 * i], column[3 * i + 1], column[3 * i + 2]};
    for (unsigned i = 0; i < 9; ++i) packed[i] = (U8)column[18 + i];
    flags = (U8)column[27];
  }

  // Component `c` (0 .. 17) of the six normals.
  F8 component(unsigned c) const {
    const I8 bits = (I8)packed[c / 2], whole = c % 2 == 0 ? (bits << 16) >> 16 : bits >> 16;
    return __builtin_convertvector(whole, F8) * splat(1 / kNormalScale);
  }
  Vector8 normal(unsigned i) const { return {component(3 * i), component(3 * i + 1), component(3 * i + 2)}; }
};

// Lower bound of the way on which balls touch curved patches. No point of a patch is farther than `swing` from the flat
// triangle, and the sine of the angle between its normals and that of the triangle is bounded by `lean`. If a ball
// rests on the patch, its centre is therefore beside the triangle by at most swing + lean * radius. A patch with a
// sharp side can also be touched at that side from any direction, so only the distance counts.
inline F8 wayToPatch(const U8& flags, const F8& allowance, const ToolBalls& balls, const F8& distance, const F8& beside) {
  const F8 swing = allowance * __builtin_convertvector((I8)(flags >> kSwingShift & splatU(kSwingMask)), F8) * splat(1.0f / kSwingMask),
           lean = __builtin_convertvector((I8)(flags >> kLeanShift), F8) * splat(1.0f / kLeanMask);
  const I8 is_smooth = (I8)(flags & splatU(7)) == 0, is_curved = (I8)(flags & splatU(kCurved)) != 0;
  const F8 way = distance - balls.radius - swing;
  return select(is_curved, select(is_smooth, maxOf(way, beside - swing - lean * balls.radius), way), splat(__builtin_inff()));
}

// Keeps the ball, reduced by the allowance, out of the flat triangle, from either side. The triangle is convex, so the
// row holds along the whole piece of the motion.
float flatRows(const RowRequest& q) {
  const F8 one = splat(1), zero = splat(0), allowance = splat(q.allowance);
  F8 smallest = splat(__builtin_inff());
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    const ToolBalls balls(q, i);
    const Patches p(q, balls);
    const Vector8 side[3] = {p.position[1] - p.position[0], p.position[2] - p.position[1], p.position[0] - p.position[2]};
    const Vector8 across = cross(side[0], p.position[2] - p.position[0]);
    const F8 area2 = dot(across, across);
    const I8 is_flat = area2 > splat(1e-30f);
    const Vector8 upright = (one / squareRoot(select(is_flat, area2, one))) * across;
    // The centre is above the triangle if it is on the inner side of all three sides.
    I8 over = is_flat;
    F8 nearest = splat(__builtin_inff()), beside2 = zero;
    Vector8 way{zero, zero, zero};
#pragma GCC unroll 1  // smaller, and no slower
    for (unsigned k = 0; k < 3; ++k) {
      const Vector8 from = balls.centre - p.position[k];
      const F8 inward = dot(cross(upright, side[k]), from), length2 = dot(side[k], side[k]),
               inverse = one / select(length2 > zero, length2, one);
      over = over & (inward >= zero);
      beside2 = select(inward < zero, maxOf(beside2, inward * inward * inverse), beside2);
      const Vector8 to = from - clamp01(dot(from, side[k]) * inverse) * side[k];
      const F8 square = dot(to, to);
      way = select(square < nearest, to, way);
      nearest = minOf(nearest, square);
    }
    const F8 height = dot(upright, balls.centre - p.position[0]);
    const I8 apart = nearest > splat(1e-20f);
    const F8 edge_distance = squareRoot(select(apart, nearest, one));
    // Tissue has an outside, and its surface may move past the centre of a small ball in a step.
    const I8 is_below = height < splat(-q.behind);
    const Vector8 to_side = select(is_below, zero - one, one) * upright;
    const Vector8 from_edge = select(apart, (one / edge_distance) * way, to_side);
    const F8 distance = select(over, select(is_below, zero - height, height), select(apart, edge_distance, zero));
    const F8 gap =
        distance - maxOf(balls.radius - select((I8)(p.flags & splatU(kCurved)) != 0, allowance, zero), splat(0.5f) * balls.radius);
    smallest = minOf(smallest, gap);
    storeRows(q, i, balls, select(over, to_side, from_edge), gap, is_flat | ~is_flat);
    store(q.felt_way + i, wayToPatch(p.flags, allowance, balls, distance, squareRoot(beside2)));
  }
  return minLane(smallest);
}

// A quadratic field over a triangle with six nodes: value = f + u a + v b + u^2 c + u v d + v^2 e, where u and v are
// the weights of corners 1 and 2.
struct Quadratic {
  Vector8 f, a, b, c, d, e;
  Quadratic(const Vector8& p0, const Vector8& p1, const Vector8& p2, const Vector8& p01, const Vector8& p12, const Vector8& p20) {
    const F8 two = splat(2), four = splat(4);
    // For the sides from corner 0: twice the vector to the middle minus the vector to the end gives the bend.
    const Vector8 m1 = p01 - p0, m2 = p20 - p0, e1 = p1 - p0, e2 = p2 - p0, m12 = p12 - p0;
    f = p0;
    a = four * m1 - e1;
    b = four * m2 - e2;
    c = two * e1 - four * m1;
    d = four * (m12 - m1 - m2);
    e = two * e2 - four * m2;
  }
  Vector8 at(const F8& u, const F8& v) const { return f + (u * (a + u * c + v * d) + v * (b + v * e)); }
  Vector8 alongU(const F8& u, const F8& v) const { return a + (splat(2) * u) * c + v * d; }
  Vector8 alongV(const F8& u, const F8& v) const { return b + u * d + (splat(2) * v) * e; }
};

constexpr int kNewtonSteps = 6;         // to the foot of a ball on a patch; usually 2 or 3
constexpr float kLastStep = 3e-4f;      // in weights: convergence is quadratic, and the next step would be below 1e-6
constexpr float kLongestStep = 0.35f;   // in weights: beyond this the quadratic model is unreliable
constexpr float kOutside = 0.1f;        // in weights: how far an iterate may leave the patch
constexpr float kFootFound = 1e-3f;     // in weights: largest last step of an accepted foot; convergence is quadratic
constexpr float kSeam = 1e-4f;          // in weights: a foot may be beyond a side by this, so that rounding leaves no slit between patches
constexpr float kClearOfPlane = 1e-3f;  // a ball beside a patch, and more than this above its plane, gets the plane as a row [mm]

// The foot of a ball: weights u and v and height h such that position + h normal = centre (the normal is not of unit
// length).
struct Foot {
  F8 u, v, h;
  I8 found;
};

inline Foot findFoot(const Quadratic& position, const Quadratic& normal, const Vector8& centre) {
  const F8 one = splat(1), zero = splat(0), low = splat(-kOutside), high = splat(1 + kOutside), half = splat(0.5f);
  Foot foot{splat(1.0f / 3), splat(1.0f / 3), zero, {}};
  F8 last = one;
  for (int step = 0; step < kNewtonSteps; ++step) {
    const Vector8 p = position.at(foot.u, foot.v), n = normal.at(foot.u, foot.v), way = centre - p;
    const F8 square = dot(n, n);
    foot.h = dot(way, n) / select(square > zero, square, one);
    const Vector8 rest = way - foot.h * n;
    const Vector8 pu = position.alongU(foot.u, foot.v) + foot.h * normal.alongU(foot.u, foot.v),
                  pv = position.alongV(foot.u, foot.v) + foot.h * normal.alongV(foot.u, foot.v);
    const Vector8 pv_n = cross(pv, n), n_pu = cross(n, pu);
    const F8 det = dot(pu, pv_n);
    const I8 regular = det * det > splat(1e-24f);
    const F8 inverse = one / select(regular, det, one);
    F8 du = select(regular, dot(rest, pv_n) * inverse, zero), dv = select(regular, dot(rest, n_pu) * inverse, zero);
    last = select(regular, maxOf(size(du), size(dv)), one);
    const F8 shorter = minOf(one, splat(kLongestStep) / maxOf(last, splat(1e-9f)));
    F8 u = foot.u + shorter * du, v = foot.v + shorter * dv;
    const F8 excess = half * maxOf(zero, u + v - high);
    u = maxOf(low, minOf(u - excess, high));
    v = maxOf(low, minOf(v - excess, high));
    const F8 moved = maxOf(size(u - foot.u), size(v - foot.v));
    foot.u = u;
    foot.v = v;
    if (maskOf(moved > splat(kLastStep)) == 0) break;
  }
  const Vector8 n = normal.at(foot.u, foot.v);
  const F8 square = dot(n, n);
  foot.h = dot(centre - position.at(foot.u, foot.v), n) / select(square > zero, square, one);
  foot.found = last < splat(kFootFound);
  return foot;
}

// The ball rests on the patch if its foot lies within it. If the foot lies beyond a sharp side, the ball rests on that
// side. If it lies beyond a smooth side, the ball rests on the neighbour. The plane of this patch is then a row if the
// ball is above it, as in a hollow, where the ball meets it next; over a ridge the ball is below it.
float feltRows(const RowRequest& q) {
  const F8 one = splat(1), zero = splat(0), seam = splat(-kSeam);
  F8 smallest = splat(__builtin_inff());
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    const ToolBalls balls(q, i);
    const Patches p(q, balls);
    const Quadratic position(p.position[0], p.position[1], p.position[2], p.position[3], p.position[4], p.position[5]),
        normal(p.normal(0), p.normal(1), p.normal(2), p.normal(3), p.normal(4), p.normal(5));
    const Foot foot = findFoot(position, normal, balls.centre);
    const F8 w[3] = {one - foot.u - foot.v, foot.u, foot.v};
    const I8 beyond[3] = {w[2] < seam, w[0] < seam, w[1] < seam};  // sides 01, 12, 20
    const I8 within = ~(beyond[0] | beyond[1] | beyond[2]) & foot.found;
    // The nearest point on the patch's border in weights, or the foot.
    const F8 u0 = maxOf(zero, foot.u), v0 = maxOf(zero, foot.v), sum = u0 + v0, shrink = one / maxOf(one, sum);
    const F8 u = select(within, foot.u, u0 * shrink), v = select(within, foot.v, v0 * shrink);
    const Vector8 at = position.at(u, v), n = normal.at(u, v), way = balls.centre - at;
    const F8 square = dot(n, n);
    Vector8 unit = (one / squareRoot(select(square > zero, square, one))) * n;
    F8 gap = dot(way, unit) - balls.radius;
    const F8 distance = squareRoot(dot(way, way));
    // The centre must be outside; otherwise the flat triangle holds the ball.
    I8 in = (within & (gap > -balls.radius)) | (~within & (gap > splat(kClearOfPlane)) & (distance - balls.radius <= splat(q.max_gap)));
#pragma GCC unroll 1  // few patches are sharp
    for (unsigned k = 0; k < 3; ++k) {
      const I8 is_sharp = (I8)((p.flags >> splatU(k)) & splatU(1)) != 0, on_side = beyond[k] & is_sharp;
      if (maskOf(on_side) == 0) continue;
      const Vector8 side = p.position[(k + 1) % 3] - p.position[k], from = balls.centre - p.position[k];
      const F8 length2 = dot(side, side);
      const Vector8 to = from - clamp01(dot(from, side) / select(length2 > zero, length2, one)) * side;
      const F8 square_to = dot(to, to), off = squareRoot(square_to);
      const I8 apart = on_side & (square_to > splat(1e-20f));
      unit = select(apart, (one / select(apart, off, one)) * to, unit);
      gap = select(apart, off - balls.radius, gap);
      in = (in & ~on_side) | (apart & (gap > splat(-0.5f) * balls.radius));
    }
    smallest = minOf(smallest, select(in, gap, splat(__builtin_inff())));
    storeRows(q, i, balls, unit, gap, in);
  }
  return minLane(smallest);
}

WorstRow worstRow(const float* const* a, const float* b, std::uint32_t count, const float* y) {
  const F8 y0 = splat(y[0]), y1 = splat(y[1]), y2 = splat(y[2]), y3 = splat(y[3]), y4 = splat(y[4]), y5 = splat(y[5]);
  F8 smallest = splat(__builtin_inff());
  U8 at = splatU(0), index = kLanes;
  for (std::uint32_t i = 0; i < count; i += 8, index += splatU(8)) {
    const F8 s = ((load(a[0] + i) * y0 + load(a[1] + i) * y1) + (load(a[2] + i) * y2 + load(a[3] + i) * y3)) +
                 ((load(a[4] + i) * y4 + load(a[5] + i) * y5) - load(b + i));
    const I8 less = s < smallest;
    smallest = select(less, s, smallest);
    at = (U8)(((I8)index & less) | ((I8)at & ~less));
  }
  WorstRow worst{~0u, minLane(smallest)};
  for (unsigned lanes = maskOf(smallest == splat(worst.slack)); lanes; lanes &= lanes - 1) {
    const std::uint32_t row = at[__builtin_ctz(lanes)];
    worst.row = row < worst.row ? row : worst.row;
  }
  return worst;
}

constexpr KernelTable kTable{findNear, findPairs, sphereRows, flatRows, feltRows, worstRow};

}  // namespace
}  // namespace spheretree::runtime
