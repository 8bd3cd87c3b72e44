// SPDX-License-Identifier: Apache-2.0
// Rows of a ball and a patch of soft tissue. Included by one source for each instruction set, as kernel_lanes.h is, but
// in files of its own, so that a program without tissue does not contain them.
#pragma once

#include "kernel_lanes.h"
#include "soft_rows.h"

namespace spheretree::runtime {
namespace {

constexpr float kStuckOff = 0.01f;  // a ball leaves the point that it stuck to for a point that is nearer by this [mm]
constexpr int kPointSteps = 4;      // iterations to the point of a soft patch that is nearest to a ball

// The weights u and v of the approximately nearest points of patches to balls: starts from the nearest point of the
// flat triangle and makes Gauss-Newton steps. A tool lies in its own dent, whose centre of curvature is about the
// centre of the ball. All points are then about equally near, and these steps stay near their start.
inline void findNearest(const Patches& p, const Quadratic& position, const Vector8& centre, F8& u, F8& v) {
  const F8 one = splat(1), zero = splat(0);
  u = v = splat(1.0f / 3);
  for (int step = 0; step <= kPointSteps; ++step) {
    const bool is_flat = step == 0;  // the first step solves for the flat triangle, from any start in it
    const Vector8 pu = is_flat ? p.position[1] - p.position[0] : position.alongU(u, v),
                  pv = is_flat ? p.position[2] - p.position[0] : position.alongV(u, v),
                  way = centre - (is_flat ? p.position[0] + u * pu + v * pv : position.at(u, v));
    // A patch that bulges out is farther away on either side of the point; this curvature shortens the steps.
    const F8 bulge_u = is_flat ? zero : maxOf(zero, splat(-2) * dot(way, position.c)),
             bulge_v = is_flat ? zero : maxOf(zero, splat(-2) * dot(way, position.e));
    const F8 uu = dot(pu, pu) + bulge_u, vv = dot(pv, pv) + bulge_v, uv = dot(pu, pv), det = uu * vv - uv * uv;
    const I8 regular = det > splat(1e-6f) * uu * vv;
    const F8 inverse = one / select(regular, det, one), au = dot(way, pu), av = dot(way, pv);
    u = u + select(regular, (vv * au - uv * av) * inverse, zero);
    v = v + select(regular, (uu * av - uv * au) * inverse, zero);
    const F8 excess = splat(0.5f) * maxOf(zero, u + v - one);
    u = clamp01(u - excess);
    v = clamp01(v - excess);
    const F8 shrink = one / maxOf(one, u + v);
    u = u * shrink;
    v = v * shrink;
  }
}

inline std::uint32_t toolOf(const RowRequest& q, std::uint32_t row) { return q.pairs[row < q.count ? row : q.count - 1] >> 16; }

// A ball that stuck to a point in the last step is still at this point, unless another point is clearly nearer.
inline void keepStuck(const RowRequest& q, std::uint32_t i, const ToolBalls& balls, const Quadratic& position, F8& u, F8& v,
                      Vector8& normal) {
  F8 stuck_u = u, stuck_v = v;
  I8 is_stuck{};
  bool any = false;
  for (unsigned k = 0; k < 8; ++k) {
    const SoftPoint& point = q.points[balls.slot[k]];
    if (point.stuck == 0 || point.stuck + 1 < q.step || point.tool != toolOf(q, i + k)) continue;
    stuck_u[k] = point.u, stuck_v[k] = point.v;
    is_stuck[k] = -1;
    any = true;
  }
  if (!any) return;
  const Vector8 way = balls.centre - position.at(stuck_u, stuck_v), shortest = balls.centre - position.at(u, v);
  const F8 distance = squareRoot(dot(way, way)), min_distance = squareRoot(dot(shortest, shortest));
  is_stuck = is_stuck & (distance <= min_distance + splat(kStuckOff));
  u = select(is_stuck, stuck_u, u);
  v = select(is_stuck, stuck_v, v);
  normal = select(is_stuck, (splat(1) / maxOf(distance, splat(1e-6f))) * way, normal);
}

// The ball touches a point of the patch; the normal points from there to its centre. After the first rows of a step,
// points and normals are fixed: then rows change exactly as the QP predicts, and the step converges.
float softRows(const RowRequest& q) {
  const F8 one = splat(1), zero = splat(0), min_distance = splat(1e-6f);
  F8 smallest = splat(__builtin_inff());
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    const ToolBalls balls(q, i);
    const Patches p(q, balls);
    const Quadratic position(p.position[0], p.position[1], p.position[2], p.position[3], p.position[4], p.position[5]);
    F8 u, v;
    findNearest(p, position, balls.centre, u, v);
    Vector8 way = balls.centre - position.at(u, v);
    const F8 distance = squareRoot(dot(way, way));
    Vector8 normal = (one / maxOf(distance, min_distance)) * way;
    keepStuck(q, i, balls, position, u, v, normal);
    for (unsigned k = 0; k < 8; ++k) {
      SoftPoint& point = q.points[balls.slot[k]];
      const std::uint32_t tool = toolOf(q, i + k);
      if (point.step != q.step || point.tool != tool) {
        point = {u[k], v[k], {normal.x[k], normal.y[k], normal.z[k]}, tool, q.is_found ? q.step : 0, point.tool == tool ? point.stuck : 0};
        continue;
      }
      u[k] = point.u, v[k] = point.v;
      normal.x[k] = point.normal[0], normal.y[k] = point.normal[1], normal.z[k] = point.normal[2];
    }
    way = balls.centre - position.at(u, v);
    const F8 gap = dot(way, normal) - balls.radius;
    // The centre must be outside; otherwise the flat triangle holds the ball.
    const I8 in = (distance > min_distance) & (dot(way, cross(position.alongU(u, v), position.alongV(u, v))) > zero);
    smallest = minOf(smallest, select(in, gap, splat(__builtin_inff())));
    storeRows(q, i, balls, normal, gap, in);
  }
  return minLane(smallest);
}

}  // namespace
}  // namespace spheretree::runtime
