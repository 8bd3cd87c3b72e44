// SPDX-License-Identifier: Apache-2.0
// Felt rows of a ball and a curved patch. docs/algorithms/runtime/rows.md#felt-row
#pragma once

#include "kernel/hull_felt_lanes.h"
#include "kernel/patch_newton_lanes.h"
#include "kernel/row_parts_lanes.h"

namespace spheretree::runtime {
namespace {

constexpr float kSeam = 1e-4f;          // in weights: a foot may be beyond a side by this, so that rounding leaves no slit between patches
constexpr float kClearOfPlane = 1e-3f;  // a ball beside a patch, and more than this above its plane, gets the plane as a row [mm]

// The foot of a ball: weights u and v and height h such that position + h normal = centre (the normal is not of unit
// length).
struct Foot {
  F8 u, v, h;
  I8 found;
};

// The lanes in `exactly` decide when to stop.
inline Foot findFoot(const Quadratic& position, const Quadratic& normal, const Vector8& centre, const I8& exactly) {
  const F8 one = splat(1), zero = splat(0);
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
    if (maskOf((stepOn(du, dv, last, foot.u, foot.v) > splat(kLastStep)) & exactly) == 0) break;
  }
  const Vector8 n = normal.at(foot.u, foot.v);
  const F8 square = dot(n, n);
  foot.h = dot(centre - position.at(foot.u, foot.v), n) / select(square > zero, square, one);
  foot.found = last < splat(kFootFound);
  return foot;
}

// Leaves those pairs out, in place, whose cone or slab cannot rest on the smooth patch. Returns how many are left.
std::uint32_t keepResting(const RowRequest& q, std::uint32_t* pairs) {
  std::uint32_t* end = pairs;
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    const ToolBalls balls(q, i);
    const Patches p(q, balls);
    const HullParts parts = partsOf(q, i, balls);
    const unsigned live = i + 8 <= q.count ? 0xffu : (1u << (q.count - i)) - 1,
                   kept = maskOf(~(parts.is_cone | parts.is_slab) | isSharp(p, parts.way) | mayRest(parts, p)) & live;
    for (unsigned lanes = kept; lanes; lanes &= lanes - 1) *end++ = pairs[i + static_cast<std::uint32_t>(__builtin_ctz(lanes))];
  }
  return static_cast<std::uint32_t>(end - pairs);
}

// The ball rests on the patch if its foot lies within it. If the foot lies beyond a sharp side, the ball rests on that
// side. If it lies beyond a smooth side, the ball rests on the neighbour. The plane of this patch is then a row if the
// ball is above it, as in a hollow, where the ball meets it next; over a ridge the ball is below it.
float feltRows(const RowRequest& q) {
  const F8 one = splat(1), zero = splat(0), seam = splat(-kSeam);
  F8 smallest = splat(__builtin_inff());
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    ToolBalls balls(q, i);
    const Patches p(q, balls);
    HullBalls hull = kOnlyBalls;
    const Quadratic position(p.position[0], p.position[1], p.position[2], p.position[3], p.position[4], p.position[5]),
        normal(p.normal(0), p.normal(1), p.normal(2), p.normal(3), p.normal(4), p.normal(5));
    HullParts parts;
    Vector8 middle = balls.centre;
    I8 is_ball = ~I8{};
    if (q.hulls.way) {
      parts = partsOf(q, i, balls);
      is_ball = ~(parts.is_cone | parts.is_slab);
      middle = middle + select(parts.is_slab, splat(1.0f / 3), splat(0.5f)) * (parts.span1 + parts.span2);
    }
    Foot foot = findFoot(position, normal, middle, is_ball);
    if (q.hulls.way) {
      hull = touchTriangles(parts, p, balls);
      const HullFoot rest = restOnPatches(hull.smooth, parts, feltTurns(q, i), position, normal, foot.u, foot.v, balls);
      foot.u = select(hull.smooth, rest.u, foot.u);
      foot.v = select(hull.smooth, rest.v, foot.v);
      foot.found = (hull.rests & foot.found) | rest.found;
    }
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
    I8 in = (within & (gap > -balls.radius)) |
            (hull.rests & ~within & (gap > splat(kClearOfPlane)) & (distance - balls.radius <= splat(q.max_gap)));
#pragma GCC unroll 1  // few patches are sharp
    for (unsigned k = 0; k < 3; ++k) {
      const I8 of_hull = hull.sharp & hull.within & ((I8)hull.way == (I8)splatU(k)),
               on_side = (hull.is_ball & beyond[k] & isSharp(p, splatU(k))) | of_hull;
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

}  // namespace
}  // namespace spheretree::runtime
