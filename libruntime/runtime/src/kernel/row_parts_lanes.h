// SPDX-License-Identifier: Apache-2.0
// What the kernels of rows share: the balls of the tool and the patches of eight pairs, the quadratic fields of the
// patches, and the output.
#pragma once

#include "kernel/kernel.h"
#include "kernel/vector_lanes.h"

namespace spheretree::runtime {
namespace {

// 8 balls of the tool, in the axes of the object.
struct ToolBalls {
  std::uint32_t slot[8];        // of the object, for each pair
  Vector8 offset, arm, centre;  // of the reference point from the anchor; from the reference point; from the anchor
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
    offset = splat(q.pose.offset[0], q.pose.offset[1], q.pose.offset[2]);
    arm = turn(x, y, z, q.pose.rotation);
    centre = arm + offset;
  }
};

// 8 patches: the content of eight CompiledPatch, transposed.
struct Patches {
  Vector8 position[6];
  U8 packed[9];  // normals, two components in each
  U8 flags;

  [[gnu::noinline]] Patches(const RowRequest& q, const ToolBalls& balls) {
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

// 8 rows of a QP: six coefficients of each, times `scale`.
inline void storeScaled(float* const a[6], std::uint32_t i, const F8 (&row)[6], F8 scale) {
  for (unsigned k = 0; k < 6; ++k) store(a[k] + i, row[k] * scale);
}

// Stores rows of 8 pairs with these normals and gaps, in the axes of the object. Rows that are not `in` are always
// satisfied: by far, or by the gap if `keeps_gap`.
inline void storeRows(const RowRequest& q, std::uint32_t i, const ToolBalls& balls, const Vector8& normal, F8 gap, I8 in,
                      bool keeps_gap = false) {
  const F8 one = splat(1), zero = splat(0);
  const Vector8 lever = splat(q.inverse_angle_length) * cross(balls.arm, normal);
  const Vector8 n = turn(normal.x, normal.y, normal.z, q.to_world);
  Vector8 a = turn(lever.x, lever.y, lever.z, q.to_world);
  if (q.squared) a = turn(a.x, a.y, a.z, q.axes);
  const F8 weight = one / squareRoot(one + (a.x * a.x + a.y * a.y + a.z * a.z));
  storeScaled(q.a, i, {n.x, n.y, n.z, a.x, a.y, a.z}, select(in, weight, zero));
  store(q.b + i, select(in, -(gap * weight), keeps_gap ? minOf(-(gap * weight), zero) : splat(-1e30f)));
  store(q.weight + i, weight);
  if (q.along) store(q.along + i, dot(balls.arm, normal) - balls.radius);
}

}  // namespace
}  // namespace spheretree::runtime
