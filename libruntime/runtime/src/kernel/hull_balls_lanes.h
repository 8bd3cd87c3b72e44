// SPDX-License-Identifier: Apache-2.0
// In which ways, and with which ball, a hull of the tool touches a triangle or a ball. A hull is the union of the balls
// between its own, so a row of a hull is that of one of them. docs/algorithms/runtime/hull_rows.md
#pragma once

#include "kernel/row_parts_lanes.h"

namespace spheretree::runtime {
namespace {

constexpr float kJoint = 1e-4f;  // in weights of balls: a touch may be beyond the end of a part by this, so that rounding leaves no slit

// Functions that scenes without hulls do not call stay out of line, so that those are no slower and the library small.

// 8 parts of hulls, in the axes of the object.
struct HullParts {
  Vector8 first, span1, span2;  // centre of ball 0; from it to balls 1 and 2: zero if there are none
  F8 radius, rise1, rise2;      // of ball 0; radii of balls 1 and 2 minus that
  F8 bend;                      // as in CompiledHulls
  U8 way;
  I8 is_cone, is_slab;  // neither: a ball
};

// Of the pairs from `i` on; the centres of `balls` are those of balls 0.
[[gnu::noinline]] HullParts partsOf(const RowRequest& q, std::uint32_t i, const ToolBalls& balls) {
  HullParts h;
  h.first = balls.centre;
  h.radius = balls.radius;
  const Sphere *one[8], *two[8];
  for (std::uint32_t k = 0; k < 8; ++k) {
    const std::uint32_t slot = q.pairs[i + k < q.count ? i + k : q.count - 1] >> 16;
    one[k] = q.hulls.span1 + slot;
    two[k] = q.hulls.span2 + slot;
    h.way[k] = q.hulls.way[slot];
    h.bend[k] = q.hulls.bend[slot];
  }
  F8 x, y, z;
  transpose(one, x, y, z, h.rise1);
  h.span1 = turn(x, y, z, q.pose.rotation);
  transpose(two, x, y, z, h.rise2);
  h.span2 = turn(x, y, z, q.pose.rotation);
  h.is_slab = dot(h.span2, h.span2) > splat(0);
  h.is_cone = (dot(h.span1, h.span1) > splat(0)) & ~h.is_slab;
  return h;
}

// A ball of a part by its weights.
struct HullTouch {
  F8 w1, w2;  // of balls 1 and 2
  I8 within;  // the part, and not beyond its end
};

inline F8 dividedBy(const F8& a, const F8& b) {
  const I8 is_zero = b == splat(0);
  return select(is_zero, splat(0), a / select(is_zero, splat(1), b));
}

inline Vector8 unit(const Vector8& v) { return dividedBy(splat(1), squareRoot(dot(v, v))) * v; }

inline I8 areWeights(const F8& w1, const F8& w2) {
  const F8 low = splat(-kJoint);
  return (w1 >= low) & (w2 >= low) & (w1 + w2 <= splat(1 + kJoint));
}

// The axis of each cone.
struct HullAxis {
  F8 inverse_length, sine, cosine;  // of the half angle
  Vector8 unit;
  explicit HullAxis(const HullParts& h)
      : inverse_length(dividedBy(splat(1), squareRoot(dot(h.span1, h.span1)))),
        sine(h.rise1 * inverse_length),
        cosine(squareRoot(maxOf(splat(1) - sine * sine, splat(1e-6f)))),
        unit(inverse_length * h.span1) {}
  // The ball that is nearest to a point at height z along the axis and rho beside it.
  HullTouch at(const F8& z, const F8& rho) const {
    const F8 zero = splat(0), w1 = inverse_length * (z + rho * sine / cosine);
    return {w1, zero, areWeights(w1, zero)};
  }
};

// The ball of each cone that is nearest to the segment from `a` to a + d, or to the point `a` if d = 0: the distance is
// convex along it.
[[gnu::noinline]] HullTouch coneAt(const HullParts& h, const Vector8& a, const Vector8& d) {
  const F8 one = splat(1), half = splat(0.5f);
  const HullAxis axis(h);
  const Vector8 from = a - h.first;
  const F8 z0 = dot(axis.unit, from), dz = dot(axis.unit, d);
  const Vector8 beside = from - z0 * axis.unit, d_beside = d - dz * axis.unit;
  const F8 m2 = dot(d_beside, d_beside);
  // A segment along the axis touches at the middle of the part: others hold its ends.
  const I8 crosses = m2 > splat(1e-8f) * dot(d, d);
  const F8 middle = dividedBy(half, axis.inverse_length);
  const F8 s0 = select(crosses, -dividedBy(dot(beside, d_beside), m2), dividedBy(middle - z0, dz));
  const Vector8 nearest = beside + s0 * d_beside;
  const F8 slope = dividedBy(axis.sine * dz, axis.cosine * squareRoot(m2)), flat = squareRoot(maxOf(one - slope * slope, splat(1e-6f)));
  const F8 further = squareRoot(dividedBy(dot(nearest, nearest), m2)) * (slope / flat);
  const F8 s = clamp01(select(crosses, s0 + further, s0));
  const Vector8 at = beside + s * d_beside;
  return axis.at(z0 + s * dz, squareRoot(dot(at, at)));
}

// The ball of each slab that is nearest to `point`, on the face of the slab that is turned to it.
[[gnu::noinline]] HullTouch slabAt(const HullParts& h, const Vector8& point) {
  const F8 one = splat(1), zero = splat(0);
  const Vector8 across = cross(h.span1, h.span2);
  const F8 square = dot(across, across), inverse2 = dividedBy(one, square), inverse = squareRoot(inverse2);
  const Vector8 to1 = inverse2 * cross(h.span2, across), to2 = inverse2 * cross(across, h.span1);  // to1 . span1 = 1, to1 . span2 = 0
  const Vector8 from = point - h.first, fall = h.rise1 * to1 + h.rise2 * to2;
  const F8 height = inverse * dot(across, from), side = select(height < zero, zero - one, one);
  const F8 upright = squareRoot(maxOf(one - dot(fall, fall), splat(1e-6f)));
  const Vector8 normal = (side * upright * inverse) * across - fall;
  const Vector8 centre = from - (size(height) / upright) * normal;
  const F8 w1 = dot(to1, centre), w2 = dot(to2, centre);
  return {w1, w2, areWeights(w1, w2) & (square > zero)};
}

// Moves the balls of the lanes in `which` to these weights, or to the nearest ones within the part.
[[gnu::noinline]] void moveTo(const I8& which, const F8& w1, const F8& w2, const HullParts& h, ToolBalls& balls) {
  const F8 zero = splat(0), one = splat(1), u = maxOf(w1, zero), v = maxOf(w2, zero), share = one / maxOf(one, u + v),
           a = select(which, share * u, zero), b = select(which, share * v, zero);
  const Vector8 way = a * h.span1 + b * h.span2;
  balls.centre = select(which, h.first + way, balls.centre);
  balls.arm = select(which, balls.centre - balls.offset, balls.arm);
  balls.radius = select(which, h.radius + a * h.rise1 + b * h.rise2, balls.radius);
}

// What the balls of 8 pairs are for. Of a part's three ways, one has the felt row of the smooth patch, and the others
// those of sharp sides.
struct HullBalls {
  I8 within;         // the ball is one that this way answers for: its guaranteed row counts
  I8 is_ball;        // neither a cone nor a slab
  I8 rests;          // such a ball may rest on the smooth patch
  I8 smooth, sharp;  // a cone or slab whose felt row is that of the smooth patch, or of the sharp side `way`
  F8 nearest;        // lower bound of the distance of the cone or slab from the triangle
  U8 way;
};
constexpr HullBalls kOnlyBalls{~I8{}, ~I8{}, ~I8{}, I8{}, I8{}, F8{}, U8{}};

inline I8 isSharp(const Patches& p, const U8& side) { return (I8)((p.flags >> side) & splatU(1)) != 0; }

// No point of a patch is farther than this from its flat triangle [mm].
inline F8 swingOf(const U8& flags, const F8& allowance) {
  return allowance * __builtin_convertvector((I8)(flags >> kSwingShift & splatU(kSwingMask)), F8) * splat(1.0f / kSwingMask);
}

// Bound of the sine of the angle between the normals of a patch and that of its flat triangle.
inline F8 leanOf(const U8& flags) { return __builtin_convertvector((I8)(flags >> kLeanShift), F8) * splat(1.0f / kLeanMask); }

// A part and a triangle.
struct HullOver {
  F8 apart;     // lower bound of the distance of its balls, as they are felt, from the triangle
  I8 may_rest;  // on the smooth patch: the normals of both agree somewhere, if the tool turns by at most `turn` [rad]
};

// Two planes may part them: that of the triangle, and one between their middles. The normals of a patch with the lean s
// are within sqrt(2) s of that of its triangle.
[[gnu::noinline]] HullOver overTriangle(const HullParts& h, const Patches& p, float turn = 0) {
  const F8 zero = splat(0), third = splat(1.0f / 3);
  const Vector8 side1 = p.position[1] - p.position[0], side2 = p.position[2] - p.position[0], from = h.first - p.position[0],
                normal = unit(cross(side1, side2)), middle = third * (side1 + side2);
  const F8 along1 = dot(normal, h.span1), along2 = dot(normal, h.span2), height = dot(normal, from);
  const auto lowest = [&](const F8& at, const F8& at1, const F8& at2) {
    return at - h.radius + minOf(zero, minOf(at1 - h.rise1, at2 - h.rise2));
  };
  const F8 abreast = clamp01(dividedBy(dot(middle - from, h.span1), dot(h.span1, h.span1)));
  const Vector8 way = unit(from - middle + select(h.is_slab, third, abreast) * h.span1 + third * h.span2);
  const F8 beside = lowest(dot(way, from), dot(way, h.span1), dot(way, h.span2)) - maxOf(zero, maxOf(dot(way, side1), dot(way, side2)));
  const auto agrees = [&](const Vector8& span, const F8& along, const F8& rise) {
    return size(along - rise) <= (splat(1.4143f) * leanOf(p.flags) + splat(turn)) * (squareRoot(dot(span, span)) + h.bend) + h.bend;
  };
  return {maxOf(beside, maxOf(lowest(height, along1, along2), lowest(zero - height, zero - along1, zero - along2))) - splat(0.5f) * h.bend,
          agrees(h.span1, along1, h.rise1) & (h.is_cone | agrees(h.span2, along2, h.rise2))};
}

// The way of a cone or slab that has the felt row of the smooth patch.
inline I8 feltWay(const HullParts& h, const Patches& p) {
  return (I8)(p.flags >> (splatU(kFeltConeShift) + ((U8)h.is_slab & splatU(kFeltSlabShift - kFeltConeShift))) & splatU(kNoFeltWay));
}

// Cones touch side `way` of the triangle, slabs corner `way`.
[[gnu::noinline]] HullBalls touchTriangles(const HullParts& h, const Patches& p, ToolBalls& balls) {
  const F8 zero = splat(0);
  const I8 is_ball = ~(h.is_cone | h.is_slab), sharp = isSharp(p, h.way);
  HullBalls out{
      is_ball, is_ball, is_ball & ((I8)h.way == 0), ~is_ball & ((I8)h.way == feltWay(h, p)), ~is_ball & sharp, splat(__builtin_inff()),
      h.way};
  if (maskOf(is_ball) == 0xff) return out;
  const I8 is1 = (I8)h.way == (I8)splatU(1), is2 = (I8)h.way == (I8)splatU(2);
  const auto ofWay = [&](const Vector8& a, const Vector8& b, const Vector8& c) { return select(is2, c, select(is1, b, a)); };
  const Vector8 corner = ofWay(p.position[0], p.position[1], p.position[2]), next = ofWay(p.position[1], p.position[2], p.position[0]);
  HullTouch cone{zero, zero, I8{}}, slab = cone;
  if (maskOf(h.is_cone) != 0) cone = coneAt(h, corner, next - corner);
  if (maskOf(h.is_slab) != 0) slab = slabAt(h, corner);
  out.within = out.within | (h.is_slab & slab.within) | (h.is_cone & cone.within);
  moveTo(~is_ball, select(h.is_slab, slab.w1, cone.w1), select(h.is_slab, slab.w2, zero), h, balls);
  if (maskOf(out.smooth) != 0) {
    const HullOver over = overTriangle(h, p);
    out.smooth = out.smooth & over.may_rest;
    out.nearest = over.apart;
  }
  return out;
}

// Of the three ways of a part, the first one is for a ball.
[[gnu::noinline]] I8 touchBalls(const HullParts& h, const Vector8& centre, ToolBalls& balls) {
  const HullTouch cone = coneAt(h, centre, splat(0, 0, 0)), slab = slabAt(h, centre);
  const I8 is_ball = ~(h.is_cone | h.is_slab);
  moveTo(~is_ball, select(h.is_slab, slab.w1, cone.w1), select(h.is_slab, slab.w2, splat(0)), h, balls);
  return is_ball | (((I8)h.way == 0) & ((h.is_slab & slab.within) | (h.is_cone & cone.within)));
}

// Each pair in those of its ways in which the two may touch before the next search.
std::uint32_t spreadWays(const RowRequest& q, const HullWays& w) {
  std::uint32_t* end = w.to;
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    const ToolBalls balls(q, i);
    const Patches p(q, balls);
    const HullParts h = partsOf(q, i, balls);
    const HullOver over = overTriangle(h, p, w.turn);
    const unsigned live = i + 8 <= q.count ? 0xffu : (1u << (q.count - i)) - 1, near = maskOf(over.apart <= splat(w.reach)) & live;
    const I8 is_hull = h.is_cone | h.is_slab, may_rest = over.may_rest & is_hull, felt = feltWay(h, p);
    U8 pairs, ways;
#pragma GCC unroll 1  // smaller
    for (unsigned k = 0; k < 8; ++k) {
      pairs[k] = q.pairs[i + k < q.count ? i + k : q.count - 1];
      ways[k] = w.ways[q.items[balls.slot[k]]];
    }
    ways = ((ways >> ((U8)h.is_slab & splatU(3))) & (U8)is_hull) | (splatU(1) & ~(U8)is_hull);  // a ball has one way
#pragma GCC unroll 1
    for (std::uint32_t k = 0; k < 3; ++k) {
      const I8 touches = (I8)(ways >> splatU(k) & splatU(1)) != 0;
      end = append(end, pairs + splatU(k * w.apart << 16), maskOf(touches | (may_rest & (felt == (I8)splatU(k)))) & near);
    }
  }
  return static_cast<std::uint32_t>(end - w.to);
}

}  // namespace
}  // namespace spheretree::runtime
