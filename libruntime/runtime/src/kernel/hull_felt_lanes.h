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

// Least and largest value.
struct Range {
  F8 least = splat(__builtin_inff()), most = splat(-__builtin_inff());
  void add(const F8& value) { least = minOf(least, value), most = maxOf(most, value); }
};
[[gnu::noinline]] I8 meet(const Range& a, const Range& b, const F8& slack) {
  const F8 far = slack + splat(8 * kJoint) * (a.most - a.least + (b.most - b.least));
  return (a.least <= b.most + far) & (b.least <= a.most + far);
}

// The directions in which mayRest() measures a patch. Of a slab: `first` and `second` give the weights of balls 1 and
// 2, along the normal of its face that is turned to the patch. Of a cone: `first` gives the weight of ball 1 abreast of
// a point; `second` is the direction from the middle of the patch to the axis, `third` is across both.
struct PatchDirections {
  Vector8 up, first, second, third;  // up: normal of the triangle
  [[gnu::noinline]] PatchDirections(const HullParts& h, const Patches& p) {
    const F8 zero = splat(0), one = splat(1);
    up = unit(cross(p.position[1] - p.position[0], p.position[2] - p.position[0]));
    const Vector8 across = cross(h.span1, h.span2);
    const F8 inverse2 = dividedBy(one, dot(across, across));
    const Vector8 fall = inverse2 * (h.rise1 * cross(h.span2, across) + h.rise2 * cross(across, h.span1));
    const F8 tilt = squareRoot(maxOf(one - dot(fall, fall), splat(1e-6f)) * inverse2);
    const Vector8 face = select(dot(across, up) < zero, zero - tilt, tilt) * across + fall, t1 = cross(h.span1, face),
                  t2 = cross(h.span2, face);
    const Vector8 along = dividedBy(one, dot(h.span1, h.span1)) * h.span1,
                  to_axis = h.first - splat(1.0f / 3) * (p.position[0] + p.position[1] + p.position[2]),
                  ahead = unit(to_axis - dot(to_axis, along) * h.span1);
    first = select(h.is_slab, dividedBy(one, dot(h.span1, t2)) * t2, along);
    second = select(h.is_slab, dividedBy(one, dot(h.span2, t1)) * t1, ahead);
    third = cross(unit(h.span1), ahead);
  }
};

// Whether a cone or slab may rest somewhere on the patch: a bound for what restOnPatches() finds, many times cheaper. A
// quadratic field of the patch lies between the values at its six control points.
[[gnu::noinline]] I8 mayRest(const HullParts& h, const Patches& p) {
  const F8 zero = splat(0), one = splat(1), half = splat(0.5f), joint = splat(kJoint), infinite = splat(__builtin_inff());
  const PatchDirections d(h, p);
  Range lean1, lean2;                      // normal . span
  Range first, second, third;              // a slab: weights of balls 1 and 2, and their sum; a cone: weight of ball 1, slopes
                                           // of the way to the axis and of the normal, seen along the axis
  F8 longest2 = zero, upright = infinite;  // of the normals
  F8 farthest2 = zero, ahead = infinite, normal_ahead = infinite;  // from the axis of a cone; of the way to it, and of the normal
#pragma GCC unroll 1
  for (unsigned k = 0; k < 6; ++k) {
    Vector8 at = p.position[k], normal = p.normal(k);
    if (k >= 3) {  // control points of the sides, from the points at their middles
      const unsigned from = k - 3, to = (k - 2) % 3;
      at = splat(2) * at - half * (p.position[from] + p.position[to]);
      normal = splat(2) * normal - half * (p.normal(from) + p.normal(to));
    }
    const Vector8 way = h.first - at;
    const F8 w1 = zero - dot(way, d.first), along_second = dot(way, d.second), off = dot(way, d.third), towards = dot(normal, d.second);
    lean1.add(dot(normal, h.span1));
    lean2.add(dot(normal, h.span2));
    first.add(w1);
    second.add(select(h.is_slab, zero - along_second, off / along_second));
    third.add(select(h.is_slab, w1 - along_second, dot(normal, d.third) / towards));
    longest2 = maxOf(longest2, dot(normal, normal));
    upright = minOf(upright, dot(normal, d.up));
    farthest2 = maxOf(farthest2, along_second * along_second + off * off);
    ahead = minOf(ahead, along_second);
    normal_ahead = minOf(normal_ahead, towards);
  }
  const F8 longest = squareRoot(longest2), shortest = maxOf(upright, zero);
  const auto agrees = [&](const Range& lean, const F8& rise) {
    Range of_part;
    of_part.add(rise * shortest);
    of_part.add(rise * longest);
    return meet(lean, of_part, h.bend * longest);
  };
  const Range weights{zero, one};
  // The felt axis of a cone leaves the straight one, and the ball that touches is not the one abreast of the place.
  const F8 inverse = dividedBy(one, squareRoot(dot(h.span1, h.span1))), sine = minOf(inverse * (size(h.rise1) + h.bend), splat(0.999f)),
           farthest = squareRoot(farthest2), slide = farthest * sine / squareRoot(one - sine * sine),
           off = longest * (inverse * h.bend * (farthest + slide) + half * h.bend) / (ahead * normal_ahead);
  const I8 slab = meet(second, weights, joint) & meet(third, weights, joint),
           cone = (ahead <= zero) | (normal_ahead <= zero) | meet(second, third, off);
  return agrees(lean1, h.rise1) & agrees(lean2, h.rise2) & meet(first, weights, joint + select(h.is_slab, zero, inverse * slide)) &
         ((h.is_slab & slab) | (h.is_cone & cone));
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
