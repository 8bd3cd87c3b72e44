// SPDX-License-Identifier: Apache-2.0
// Balls and patches of soft tissue. Included by one source for each instruction set, as kernel_lanes.h is, but by other
// sources, so that a program without tissue does not contain them.
#pragma once

#include "kernel/row_parts_lanes.h"
#include "tissue/soft_rows.h"

namespace spheretree::runtime {
namespace {

constexpr float kFollow = 0.25f;       // share of the way to the nearest point that the point of a ball goes in a step
constexpr float kMaxLag = 0.04f;       // of its radius: largest way that is left
constexpr float kSlideInStep = 0.04f;  // of its radius: way by which a ball slides on over its point before it gets another one
constexpr float kStuckOff = 0.01f;     // a ball leaves the point that it stuck to for a point that is nearer by this [mm]
constexpr int kPointSteps = 4;         // iterations to the point of a soft patch that is nearest to a ball

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

inline std::uint32_t pairOf(const RowRequest& q, std::uint32_t row) { return q.pairs[row < q.count ? row : q.count - 1]; }

// In its own dent all points are about equally near to a ball, and each point moves the ball, which moves the nearest
// point. Therefore the point of a ball goes only a share of the way to the nearest one, unless that is far. A ball that
// stuck to its point keeps it.
inline void followLast(const RowRequest& q, std::uint32_t i, const ToolBalls& balls, const Quadratic& position, F8& u, F8& v,
                       Vector8& normal) {
  F8 last_u = u, last_v = v;
  I8 is_stuck{};
  for (unsigned k = 0; k < 8; ++k) {
    const std::uint32_t pair = pairOf(q, i + k);
    const SoftPoint& point = pointOf(q.points, pair);
    if (point.step + 1 != q.step || point.pair != pair) continue;
    last_u[k] = point.u, last_v[k] = point.v;
    if (point.stuck > 0 && point.stuck + 1 >= q.step) is_stuck[k] = -1;
  }
  const Vector8 last = balls.centre - position.at(last_u, last_v), shortest = balls.centre - position.at(u, v), lag = last - shortest;
  const F8 share = maxOf(splat(kFollow), splat(1) - splat(kMaxLag) * balls.radius / maxOf(squareRoot(dot(lag, lag)), splat(1e-12f)));
  is_stuck = is_stuck & (squareRoot(dot(last, last)) <= squareRoot(dot(shortest, shortest)) + splat(kStuckOff));
  u = select(is_stuck, last_u, last_u + share * (u - last_u));
  v = select(is_stuck, last_v, last_v + share * (v - last_v));
  const Vector8 way = balls.centre - position.at(u, v);
  normal = (splat(1) / maxOf(squareRoot(dot(way, way)), splat(1e-6f))) * way;
}

// The ball touches a point of the patch; the normal points from there to its centre. In a step, point and normal stay
// unless the ball slides on: rows then change exactly as the QP predicts, and its first solution is the last.
float softRows(const RowRequest& q) {
  const F8 zero = splat(0), min_distance = splat(1e-6f);
  F8 smallest = splat(__builtin_inff());
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    const ToolBalls balls(q, i);
    const Patches p(q, balls);
    const Quadratic position(p.position[0], p.position[1], p.position[2], p.position[3], p.position[4], p.position[5]);
    F8 u = zero, v = zero;
    Vector8 normal{zero, zero, zero};
    I8 is_known{};
    for (unsigned k = 0; k < 8; ++k) {
      const std::uint32_t pair = pairOf(q, i + k);
      const SoftPoint& point = pointOf(q.points, pair);
      if (point.step != q.step || point.pair != pair) continue;
      u[k] = point.u, v[k] = point.v;
      normal.x[k] = point.normal[0], normal.y[k] = point.normal[1], normal.z[k] = point.normal[2];
      is_known[k] = -1;
    }
    Vector8 way = balls.centre - position.at(u, v);
    const Vector8 aside = cross(way, normal);
    is_known = is_known & (dot(aside, aside) <= splat(kSlideInStep * kSlideInStep) * balls.radius * balls.radius);
    if (maskOf(is_known) != 0xff) {
      F8 new_u, new_v;
      findNearest(p, position, balls.centre, new_u, new_v);
      Vector8 new_normal;
      followLast(q, i, balls, position, new_u, new_v, new_normal);
      u = select(is_known, u, new_u);
      v = select(is_known, v, new_v);
      normal = select(is_known, normal, new_normal);
      way = balls.centre - position.at(u, v);
      for (unsigned k = 0; k < 8; ++k) {
        if (is_known[k]) continue;
        const std::uint32_t pair = pairOf(q, i + k);
        SoftPoint& point = pointOf(q.points, pair);
        point = {u[k], v[k], {normal.x[k], normal.y[k], normal.z[k]}, pair, q.step, point.pair == pair ? point.stuck : 0};
      }
    }
    const F8 gap = dot(way, normal) - balls.radius;
    // The centre must be outside; otherwise the flat triangle holds the ball.
    const I8 in = (dot(way, way) > min_distance * min_distance) & (dot(way, cross(position.alongU(u, v), position.alongV(u, v))) > zero);
    smallest = minOf(smallest, select(in, gap, splat(__builtin_inff())));
    storeRows(q, i, balls, normal, gap, in);
  }
  return minLane(smallest);
}

std::uint32_t keepNear(const RowRequest& q, float reach, std::uint32_t* kept) {
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    const ToolBalls balls(q, i);
    const Patches p(q, balls);
    const F8 farthest = balls.radius + splat(reach);
    const unsigned near = maskOf(squareToTriangle(p.position[0], p.position[1], p.position[2], balls.centre) <= farthest * farthest);
    for (unsigned k = 0; k < 8 && i + k < q.count; ++k)
      if (near >> k & 1) kept[count++] = q.pairs[i + k];
  }
  return count;
}

// A ball can be behind a triangle in two ways: the triangle has moved past its centre, or the tissue is thin there and
// the ball is on its other side. Then a triangle that it is in front of is nearer.
void findFront(const RowRequest& q) {
  for (std::uint32_t i = 0; i < q.count; ++i) q.in_front[q.pairs[i] >> 16] = __builtin_inff();
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    const ToolBalls balls(q, i);
    const Patches p(q, balls);
    const Vector8 a = p.position[0], u = p.position[1] - a, v = p.position[2] - a;
    const F8 distance = squareRoot(squareToTriangle(a, p.position[1], p.position[2], balls.centre));
    const unsigned in_front = maskOf(dot(cross(u, v), balls.centre - a) >= splat(0));
    for (unsigned k = 0; k < 8; ++k)
      if (float& nearest = q.in_front[pairOf(q, i + k) >> 16]; in_front >> k & 1) nearest = __builtin_fminf(nearest, distance[k]);
  }
}

}  // namespace
}  // namespace spheretree::runtime
