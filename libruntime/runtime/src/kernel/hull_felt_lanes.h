// SPDX-License-Identifier: Apache-2.0
// Where a cone or slab of the tool rests on a curved patch. docs/algorithms/runtime/hull_rows.md#felt-row
#pragma once

#include "kernel/hull_balls_lanes.h"
#include "kernel/patch_newton_lanes.h"

namespace spheretree::runtime {
namespace {

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

// Zero where the axis of the cone passes through the line along the normal.
[[gnu::noinline]] PatchFunction offAxis(const PatchPlace& p, const HullParts& h) {
  const Vector8 way = h.first - p.at, across = cross(h.span1, p.normal);
  return {dot(across, way), dot(cross(h.span1, p.normal_u), way) - dot(across, p.at_u),
          dot(cross(h.span1, p.normal_v), way) - dot(across, p.at_v)};
}

// Whether the gap grows to all sides of the place, so that it is where the part touches first: for a cone, along its
// axis.
[[gnu::noinline]] I8 isNearest(const PatchPlace& p, const HullParts& h, const PatchFunction& f) {
  const F8 uu = dot(p.normal_u, p.at_u), vv = dot(p.normal_v, p.at_v),
           uv = splat(0.5f) * (dot(p.normal_u, p.at_v) + dot(p.normal_v, p.at_u));
  const F8 along = uu * f.along_v * f.along_v - splat(2) * uv * f.along_u * f.along_v + vv * f.along_u * f.along_u;
  return (h.is_cone & (along > splat(0))) | (h.is_slab & (uu > splat(0)) & (uu * vv > uv * uv));
}

struct HullFoot {
  F8 u, v;
  I8 found;
};

// Finds where the cones and slabs rest, by Newton's method on the weights of the patch, and moves the balls of the
// lanes in `which` there.
[[gnu::noinline]] HullFoot restOnPatches(const I8& which, const HullParts& h, const Quadratic& position, const Quadratic& direction,
                                         ToolBalls& balls) {
  const F8 zero = splat(0), one = splat(1);
  HullFoot foot{splat(1.0f / 3), splat(1.0f / 3), {}};
  F8 last = one;
  for (int step = 0; step < kNewtonSteps; ++step) {
    const PatchPlace p(position, direction, foot.u, foot.v);
    const PatchFunction f = lean(p, h.span1, h.rise1), for_cone = offAxis(p, h), for_slab = lean(p, h.span2, h.rise2),
                        g{select(h.is_slab, for_slab.value, for_cone.value), select(h.is_slab, for_slab.along_u, for_cone.along_u),
                          select(h.is_slab, for_slab.along_v, for_cone.along_v)};
    const F8 det = f.along_u * g.along_v - f.along_v * g.along_u,
             size2 = (f.along_u * f.along_u + f.along_v * f.along_v) * (g.along_u * g.along_u + g.along_v * g.along_v);
    const I8 regular = det * det > splat(1e-8f) * size2;
    const F8 inverse = one / select(regular, det, one);
    const F8 du = select(regular, (f.along_v * g.value - g.along_v * f.value) * inverse, zero),
             dv = select(regular, (g.along_u * f.value - f.along_u * g.value) * inverse, zero);
    last = select(regular, maxOf(size(du), size(dv)), one);
    if (maskOf((stepOn(du, dv, last, foot.u, foot.v) > splat(kLastStep)) & which) == 0) break;
  }
  const PatchPlace p(position, direction, foot.u, foot.v);
  const PatchFunction g = offAxis(p, h);
  const Vector8 &n = p.normal, way = p.at - h.first, t1 = cross(h.span1, n), t2 = cross(h.span2, n);
  const Vector8 upright = dot(n, n) * h.span1 - dot(n, h.span1) * n;  // in the plane of axis and normal
  const F8 w1 = select(h.is_slab, dividedBy(dot(way, t2), dot(h.span1, t2)), dividedBy(dot(way, upright), dot(h.span1, upright))),
           w2 = select(h.is_slab, dividedBy(dot(way, t1), dot(h.span2, t1)), zero);
  foot.found = which & (last < splat(kFootFound)) & isNearest(p, h, g) & areWeights(w1, w2);
  moveTo(which, w1, w2, h, balls);
  return foot;
}

}  // namespace
}  // namespace spheretree::runtime
