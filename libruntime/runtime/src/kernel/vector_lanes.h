// SPDX-License-Identifier: Apache-2.0
// Geometry in three dimensions, eight vectors at a time.
#pragma once

#include "kernel/lanes.h"

namespace spheretree::runtime {
namespace {

struct Vector8 {
  F8 x, y, z;
};
inline Vector8 operator+(const Vector8& a, const Vector8& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vector8 operator-(const Vector8& a, const Vector8& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vector8 operator*(const F8& f, const Vector8& a) { return {f * a.x, f * a.y, f * a.z}; }
inline F8 dot(const Vector8& a, const Vector8& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vector8 cross(const Vector8& a, const Vector8& b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline Vector8 select(const I8& mask, const Vector8& yes, const Vector8& no) {
  return {select(mask, yes.x, no.x), select(mask, yes.y, no.y), select(mask, yes.z, no.z)};
}
inline Vector8 splat(float x, float y, float z) { return {splat(x), splat(y), splat(z)}; }

// The vector in the axes of the matrix `m`, row-major.
inline Vector8 turn(const F8& x, const F8& y, const F8& z, const float* m) {
  return {splat(m[0]) * x + splat(m[1]) * y + splat(m[2]) * z, splat(m[3]) * x + splat(m[4]) * y + splat(m[5]) * z,
          splat(m[6]) * x + splat(m[7]) * y + splat(m[8]) * z};
}

// Squared distances from 8 points to 8 segments.
inline F8 squareToSegment(const Vector8& start, const Vector8& span, const Vector8& point) {
  const Vector8 from = point - start;
  const F8 length2 = dot(span, span);
  const Vector8 to = from - clamp01(dot(from, span) / select(length2 > splat(0), length2, splat(1))) * span;
  return dot(to, to);
}

// Squared distances from 8 points to 8 triangles.
inline F8 squareToTriangle(const Vector8& p0, const Vector8& p1, const Vector8& p2, const Vector8& point) {
  const F8 one = splat(1), zero = splat(0);
  const Vector8 corner[3] = {p0, p1, p2}, side[3] = {p1 - p0, p2 - p1, p0 - p2}, across = cross(side[0], p2 - p0);
  const F8 area2 = dot(across, across);
  I8 over = area2 > splat(1e-30f);
  F8 nearest = splat(__builtin_inff());
#pragma GCC unroll 1  // smaller, and no slower
  for (unsigned k = 0; k < 3; ++k) {
    const Vector8 from = point - corner[k];
    over = over & (dot(cross(across, side[k]), from) >= zero);
    nearest = minOf(nearest, squareToSegment(corner[k], side[k], point));
  }
  const F8 height = dot(across, point - p0);
  return select(over, height * height / select(over, area2, one), nearest);
}

}  // namespace
}  // namespace spheretree::runtime
