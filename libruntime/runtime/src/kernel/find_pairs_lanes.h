// SPDX-License-Identifier: Apache-2.0
// The search for pairs (find_pairs.h), eight sphere tests at a time. Steps: docs/algorithms/runtime/find_pairs.md
#pragma once

#include "kernel/kernel.h"
#include "kernel/vector_lanes.h"

namespace spheretree::runtime {
namespace {

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
    const Vector8 t = turn(load(in.x), load(in.y), load(in.z), pose_.rotation);
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
    if (kToolIsOne && (slot & 7) >= one_links.inner && s_.hulls.way) hits &= nearHull(slot, many, view.motion);
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

  // The balls of the object within the margin of a hull, as if its balls were all as large as the largest. It fills
  // only a small part of its sphere.
  [[gnu::noinline]] unsigned nearHull(std::uint32_t slot, const Balls& balls, float motion) const {
    const Sphere &first = s_.hull_balls[slot], &one = s_.hulls.span1[slot], &two = s_.hulls.span2[slot];
    const float* const m = pose_.rotation;
    const float back[9] = {m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]};
    const Vector8 point = turn(balls.x - splat(pose_.offset[0]), balls.y - splat(pose_.offset[1]), balls.z - splat(pose_.offset[2]), back),
                  a = splat(first.x, first.y, first.z), b = splat(one.x, one.y, one.z);
    const F8 square = two == Sphere{} ? squareToSegment(a, b, point) : squareToTriangle(a, a + b, a + splat(two.x, two.y, two.z), point);
    const float radius = first.radius + __builtin_fmaxf(0, __builtin_fmaxf(one.radius, two.radius));
    const F8 reach = balls.r + splat(radius + s_.inner_margin + motion);
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

}  // namespace
}  // namespace spheretree::runtime
