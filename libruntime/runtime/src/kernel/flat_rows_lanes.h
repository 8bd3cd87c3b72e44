// SPDX-License-Identifier: Apache-2.0
// Guaranteed rows of a ball and a flat triangle. docs/algorithms/runtime/rows.md#guaranteed-row
#pragma once

#include "kernel/hull_balls_lanes.h"
#include "kernel/row_parts_lanes.h"

namespace spheretree::runtime {
namespace {

// Lower bound of the way on which balls touch curved patches. No point of a patch is farther than `swing` from the flat
// triangle, and the sine of the angle between its normals and that of the triangle is bounded by `lean`. If a ball
// rests on the patch, its centre is therefore beside the triangle by at most swing + lean * radius. A patch with a
// sharp side can also be touched at that side from any direction, so only the distance counts.
// Cones and slabs touch it with any of their balls, but in one row of their three.
inline F8 wayToPatch(const U8& flags, const F8& allowance, const ToolBalls& balls, const HullBalls& hull, const F8& distance,
                     const F8& beside) {
  const F8 swing = swingOf(flags, allowance), lean = leanOf(flags);
  const I8 is_smooth = (I8)(flags & splatU(7)) == 0, is_curved = (I8)(flags & splatU(kCurved)) != 0;
  const F8 way = distance - balls.radius - swing, never = splat(__builtin_inff());
  const F8 of_hull = select(hull.smooth, hull.nearest - swing, select(hull.sharp, way, never));
  const F8 of_ball = select(is_smooth, select(hull.rests, maxOf(way, beside - swing - lean * balls.radius), never), way);
  return select(is_curved, select(hull.is_ball, of_ball, of_hull), never);
}

// Keeps the ball, reduced by the allowance, out of the flat triangle, from either side. The triangle is convex, so the
// row holds along the whole piece of the motion.
float flatRows(const RowRequest& q) {
  const F8 one = splat(1), zero = splat(0), allowance = splat(q.allowance);
  const bool has_hulls = q.hulls.way != nullptr;
  F8 smallest = splat(__builtin_inff());
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    ToolBalls balls(q, i);
    const Patches p(q, balls);
    const HullBalls hull = has_hulls ? touchTriangles(partsOf(q, i, balls), p, balls) : kOnlyBalls;
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
    // Tissue has an outside, and its surface may move past the centre of a small ball in a step. Then this triangle is
    // the nearest one; behind a nearer one the ball is in front of, it sees the far side of thin tissue.
    F8 behind = splat(q.behind);
    if (q.in_front)
      for (unsigned k = 0; k < 8; ++k)
        behind[k] = __builtin_fminf(q.behind, q.in_front[q.pairs[i + k < q.count ? i + k : q.count - 1] >> 16]);
    const I8 is_below = height < zero - behind;
    const Vector8 to_side = select(is_below, zero - one, one) * upright;
    const Vector8 from_edge = select(apart, (one / edge_distance) * way, to_side);
    const F8 distance = select(over, select(is_below, zero - height, height), select(apart, edge_distance, zero));
    const F8 gap =
        distance - maxOf(balls.radius - select((I8)(p.flags & splatU(kCurved)) != 0, allowance, zero), splat(0.5f) * balls.radius);
    smallest = minOf(smallest, select(hull.within, gap, splat(__builtin_inff())));
    storeRows(q, i, balls, select(over, to_side, from_edge), gap, hull.within, has_hulls);
    store(q.felt_way + i, wayToPatch(p.flags, allowance, balls, hull, distance, squareRoot(beside2)));
  }
  return minLane(smallest);
}

}  // namespace
}  // namespace spheretree::runtime
