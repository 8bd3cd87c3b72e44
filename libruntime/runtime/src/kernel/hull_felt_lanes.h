// SPDX-License-Identifier: Apache-2.0
// Where a cone or slab of the tool rests on a curved patch. docs/algorithms/runtime/hull_rows.md#felt-row
#pragma once

#include "kernel/hull_balls_lanes.h"
#include "kernel/patch_newton_lanes.h"

namespace spheretree::runtime {
namespace {

constexpr float kFarBeyond = 8;  // largest weight of a ball of a cone at which its curve is computed, far beyond its end

// A function of the weights u and v of a patch, with its derivatives.
struct PatchFunction {
  F8 value, along_u, along_v;
};

// A patch at some weights.
struct PatchPlace {
  Vector8 at, at_u, at_v, normal, normal_u, normal_v;
  [[gnu::noinline]] PatchPlace(const Quadratic& position, const Quadratic& direction, const F8& u, const F8& v)
      : at(position.at(u, v)),
        at_u(position.alongU(u, v)),
        at_v(position.alongV(u, v)),
        normal(direction.at(u, v)),
        normal_u(direction.alongU(u, v)),
        normal_v(direction.alongV(u, v)) {}
};

// Zero where the normal of the patch is one of the cone or slab along `span`: normal . span = rise |normal|.
[[gnu::noinline]] PatchFunction lean(const PatchPlace& p, const Vector8& span, const F8& rise) {
  const F8 length = squareRoot(dot(p.normal, p.normal)), share = dividedBy(rise, length);
  return {dot(p.normal, span) - rise * length, dot(p.normal_u, span) - share * dot(p.normal, p.normal_u),
          dot(p.normal_v, span) - share * dot(p.normal, p.normal_v)};
}

// How what is felt of a part departs from it: its axis is a cubic curve whose directions at both ends are those of the
// axis plus these, and its radius a cubic function whose growth and values at the ends are given likewise.
struct FeltTurns {
  Vector8 zero, one;
  F8 rise0, rise1, swell0, swell1;
};
[[gnu::noinline]] FeltTurns feltTurns(const RowRequest& q, std::uint32_t i) {
  FeltTurns turns;
  const Sphere *zero[8], *one[8];
  for (std::uint32_t k = 0; k < 8; ++k) {
    const std::uint32_t slot = q.pairs[i + k < q.count ? i + k : q.count - 1] >> 16;
    zero[k] = q.hulls.turn0 + slot;
    one[k] = q.hulls.turn1 + slot;
    turns.swell0[k] = q.hulls.swell[slot][0];
    turns.swell1[k] = q.hulls.swell[slot][1];
  }
  F8 x, y, z;
  transpose(zero, x, y, z, turns.rise0);
  turns.zero = turn(x, y, z, q.pose.rotation);
  transpose(one, x, y, z, turns.rise1);
  turns.one = turn(x, y, z, q.pose.rotation);
  return turns;
}

// The felt axis where the line along the normal at a place of the patch passes it.
struct FeltAxis {
  F8 w, rise, bulge_radius, further;  // weight of ball 1; growth of the radius; how much larger the ball is; growth of `lean` with w
  Vector8 along, bulge, way;          // direction; from the straight axis; from the place to the felt axis
  [[gnu::noinline]] FeltAxis(const PatchPlace& p, const HullParts& h, const FeltTurns& turns) {
    const Vector8 from = p.at - h.first, upright = dot(p.normal, p.normal) * h.span1 - dot(p.normal, h.span1) * p.normal;
    w = maxOf(splat(-kFarBeyond), minOf(dividedBy(dot(from, upright), dot(h.span1, upright)), splat(kFarBeyond)));
    const F8 rest = splat(1) - w, a = w * rest * rest, b = splat(0) - w * w * rest;
    bulge = a * turns.zero + b * turns.one;
    bulge_radius = rest * turns.swell0 + w * turns.swell1 + a * turns.rise0 + b * turns.rise1;
    along = h.span1 + (rest * turns.zero + w * turns.one);
    rise = h.rise1 + turns.swell1 - turns.swell0 + (rest * turns.rise0 + w * turns.rise1);
    way = w * h.span1 + bulge - from;
    further = dot(p.normal, turns.one - turns.zero) - (turns.rise1 - turns.rise0) * squareRoot(dot(p.normal, p.normal));
  }
};

// Zero where the normal of the patch is one of the cone. The felt direction turns as the place moves along it.
[[gnu::noinline]] PatchFunction lean(const PatchPlace& p, const HullParts& h, const FeltAxis& axis) {
  PatchFunction f = lean(p, axis.along, axis.rise);
  const F8 share = dividedBy(axis.further, dot(h.span1, h.span1)), height = dividedBy(dot(p.normal, axis.way), dot(p.normal, p.normal));
  f.along_u = f.along_u + share * dot(p.at_u + height * p.normal_u, h.span1);
  f.along_v = f.along_v + share * dot(p.at_v + height * p.normal_v, h.span1);
  return f;
}

// Zero where the axis of the cone passes through the line along the normal.
[[gnu::noinline]] PatchFunction offAxis(const PatchPlace& p, const FeltAxis& axis) {
  const Vector8 across = cross(axis.along, p.normal);
  return {dot(across, axis.way), dot(cross(axis.along, p.normal_u), axis.way) - dot(across, p.at_u),
          dot(cross(axis.along, p.normal_v), axis.way) - dot(across, p.at_v)};
}

// Positive if the gap bends upward along a cone: the normal leans more and more along the places `g` = 0, at which the
// axis passes.
inline F8 leans(const PatchPlace& p, const HullParts& h, const PatchFunction& f, const PatchFunction& g) {
  return (f.along_u * g.along_v - f.along_v * g.along_u) * dot(g.along_v * p.at_u - g.along_u * p.at_v, h.span1);
}

// Whether the gap grows to all sides of the place, so that it is where the part touches first: for a cone, along it.
[[gnu::noinline]] I8 isNearest(const PatchPlace& p, const HullParts& h, const PatchFunction& f, const PatchFunction& g) {
  const F8 uu = dot(p.normal_u, p.at_u), vv = dot(p.normal_v, p.at_v),
           uv = splat(0.5f) * (dot(p.normal_u, p.at_v) + dot(p.normal_v, p.at_u));
  return (h.is_cone & (leans(p, h, f, g) > splat(0))) | (h.is_slab & (uu > splat(0)) & (uu * vv > uv * uv));
}

struct HullFoot {
  F8 u, v;
  I8 found;
};

// Finds where the cones and slabs rest, by Newton's method on the weights of the patch from `u` and `v`, and moves the
// balls of the lanes in `which` there.
[[gnu::noinline]] HullFoot restOnPatches(const I8& which, const HullParts& h, const FeltTurns& turns, const Quadratic& position,
                                         const Quadratic& direction, const F8& u, const F8& v, ToolBalls& balls) {
  const F8 zero = splat(0), one = splat(1);
  HullFoot foot{u, v, {}};
  F8 last = one;
  for (int step = 0; step < kNewtonSteps; ++step) {
    const PatchPlace p(position, direction, foot.u, foot.v);
    const FeltAxis axis(p, h, turns);
    const PatchFunction f = lean(p, h, axis), for_cone = offAxis(p, axis), for_slab = lean(p, h.span2, h.rise2),
                        g{select(h.is_slab, for_slab.value, for_cone.value), select(h.is_slab, for_slab.along_u, for_cone.along_u),
                          select(h.is_slab, for_slab.along_v, for_cone.along_v)};
    const F8 det = f.along_u * g.along_v - f.along_v * g.along_u,
             size2 = (f.along_u * f.along_u + f.along_v * f.along_v) * (g.along_u * g.along_u + g.along_v * g.along_v);
    const I8 regular = det * det > splat(1e-8f) * size2;
    const F8 inverse = one / select(regular, det, one);
    // Where the gap bends the other way along a cone, Newton's step would be to its largest value.
    const F8 value = select(h.is_cone & (leans(p, h, f, g) < zero), zero - f.value, f.value);
    const F8 du = select(regular, (f.along_v * g.value - g.along_v * value) * inverse, zero),
             dv = select(regular, (g.along_u * value - f.along_u * g.value) * inverse, zero);
    last = select(regular, maxOf(size(du), size(dv)), one);
    if (maskOf((stepOn(du, dv, last, foot.u, foot.v) > splat(kLastStep)) & which) == 0) break;
  }
  const PatchPlace p(position, direction, foot.u, foot.v);
  const FeltAxis axis(p, h, turns);
  const Vector8 &n = p.normal, way = p.at - h.first, t1 = cross(h.span1, n), t2 = cross(h.span2, n);
  const F8 w1 = select(h.is_slab, dividedBy(dot(way, t2), dot(h.span1, t2)), axis.w),
           w2 = select(h.is_slab, dividedBy(dot(way, t1), dot(h.span2, t1)), zero);
  foot.found = which & (last < splat(kFootFound)) & isNearest(p, h, lean(p, h, axis), offAxis(p, axis)) & areWeights(w1, w2);
  moveTo(which, w1, w2, h, balls);
  const I8 bulges = which & h.is_cone;
  balls.centre = select(bulges, balls.centre + axis.bulge, balls.centre);
  balls.arm = select(bulges, balls.arm + axis.bulge, balls.arm);
  balls.radius = select(bulges, balls.radius + axis.bulge_radius, balls.radius);
  return foot;
}

}  // namespace
}  // namespace spheretree::runtime
