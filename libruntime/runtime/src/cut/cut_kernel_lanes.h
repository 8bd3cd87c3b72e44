// SPDX-License-Identifier: Apache-2.0
// The fields of a block of what is cut: cut_lattice.h. docs/algorithms/runtime/cutting.md
#pragma once

#include <algorithm>

#include "cut/cut_kernel.h"
#include "kernel/vector_lanes.h"

namespace spheretree::runtime {
namespace {

constexpr unsigned kBlockRows = kBlockPoints / 8;

inline F8 shareWithin(const F8& distance, const F8& inverse_spacing) { return clamp01(splat(0.5f) + distance * inverse_spacing); }

inline F8 toSegment(const Vector8& p, const Vector8& way, const F8& inverse_square) {
  const Vector8 off = p - clamp01(dot(p, way) * inverse_square) * way;
  return squareRoot(dot(off, off));
}

// Of eight rows that differ in y, those in which the removal may come nearer to some point.
inline unsigned rowsToCut(const CutRequest& q, const Vector8& way, unsigned z) {
  const F8 h = splat(q.spacing);
  const Vector8 middle{splat(q.corner[0] + 3.5f * q.spacing), splat(q.corner[1]) + h * __builtin_convertvector((I8)kLanes, F8),
                       splat(q.corner[2] + q.spacing * static_cast<float>(z))};
  const F8 least = toSegment(middle, way, splat(q.inverse_square)) - splat(q.radius) - splat(3.51f * q.spacing);
  return maskOf(least < load(q.row_most + 8 * z));
}

void cutBlock(const CutRequest& q) {
  const F8 h = splat(q.spacing), inverse_h = splat(1 / q.spacing), radius = splat(q.radius), zero = splat(0);
  const Vector8 way = splat(q.way[0], q.way[1], q.way[2]);
  const double cell = double{q.spacing} * double{q.spacing} * double{q.spacing};
  for (unsigned z = 0; z < 8; ++z)
    for (unsigned rows = rowsToCut(q, way, z); rows; rows &= rows - 1) {
      const auto y = static_cast<unsigned>(__builtin_ctz(rows)), row = 8 * z + y;
      const Vector8 p{splat(q.corner[0]) + h * __builtin_convertvector((I8)kLanes, F8),
                      splat(q.corner[1] + q.spacing * static_cast<float>(y)), splat(q.corner[2] + q.spacing * static_cast<float>(z))};
      const F8 before = load(q.clearance + 8 * row), now = toSegment(p, way, splat(q.inverse_square)) - radius;
      const I8 is_nearer = now < before;
      if (maskOf(is_nearer) == 0) continue;
      const F8 after = select(is_nearer, now, before);
      store(q.clearance + 8 * row, after);
      q.row_most[row] = -minLane(-after);
      const F8 depth = load(q.depth + 8 * row);
      q.wall[row] = static_cast<std::uint8_t>(maskOf((minOf(after, depth) > splat(q.play)) & (after <= splat(q.largest))));
      const F8 taken = (shareWithin(before, inverse_h) - shareWithin(after, inverse_h)) * shareWithin(depth, inverse_h);
      for (unsigned lanes = maskOf(taken > zero); lanes; lanes &= lanes - 1) {
        const auto lane = static_cast<unsigned>(__builtin_ctz(lanes));
        q.volume[q.layer[8 * row + lane]] += cell * static_cast<double>(taken[lane]);
      }
    }
}

// Square of a distance within which rounding may put one that is as large as the sum of two radii.
inline F8 widened(const F8& sum) { return splat(1.0001f) * sum * sum; }

void nearWalls(const WallRequest& q) {
  const F8 h = splat(q.spacing), lane = __builtin_convertvector((I8)kLanes, F8), reach = splat(q.reach);
  const F8 x = splat(q.corner[0]) + h * lane, y = splat(q.corner[1]) + h * lane, widest = widened(reach + splat(q.largest));
  for (unsigned z = 0; z < 8; ++z) {
    const float off = q.corner[2] + q.spacing * static_cast<float>(z);
    const F8 from_line = y * y + splat(off * off);
    std::fill_n(q.near + 8 * z, 8, std::uint8_t{0});
    for (unsigned rows = maskOf(from_line <= widest); rows; rows &= rows - 1) {
      const auto k = static_cast<unsigned>(__builtin_ctz(rows)), row = 8 * z + k;
      const unsigned wall = q.wall[row];
      if (wall == 0) continue;
      const F8 radius = minOf(load(q.clearance + 8 * row), load(q.depth + 8 * row)) - splat(q.play);
      q.near[row] = static_cast<std::uint8_t>(wall & maskOf(x * x + splat(from_line[k]) <= widened(reach + radius)));
    }
  }
}

// Distances to triangles that differ by less than this share are those of a side or corner that the triangles have in
// common.
constexpr float kTie = 1e-4f;

inline Vector8 splatted(const float (&p)[3], const double* origin) {
  return splat(static_cast<float>(static_cast<double>(p[0]) - origin[0]), static_cast<float>(static_cast<double>(p[1]) - origin[1]),
               static_cast<float>(static_cast<double>(p[2]) - origin[2]));
}

// The sign is that of the nearest triangle. Where several are as near, the point is beside a side or corner of them,
// and the triangle counts that the point is most in front of: the sign of just any of them would be wrong there.
// Paper: J. A. Baerentzen, H. Aanaes. Signed distance computation using the angle weighted pseudonormal. IEEE TVCG
//        11(3), 2005.
void signedDistances(const DepthRequest& q) {
  const F8 h = splat(q.spacing), one = splat(1), zero = splat(0), most = splat(q.reach);
  F8 square[kBlockRows], height[kBlockRows];
  for (unsigned row = 0; row < kBlockRows; ++row) square[row] = splat(1e30f), height[row] = zero;
  for (std::uint32_t n = 0; n < q.count; ++n) {
    const CompiledPatch& patch = q.patches[q.triangles[n]];
    const Vector8 p0 = splatted(patch.position[0], q.corner), p1 = splatted(patch.position[1], q.corner),
                  p2 = splatted(patch.position[2], q.corner), across = cross(p1 - p0, p2 - p0);
    const F8 area2 = dot(across, across);
    const Vector8 upright = (one / squareRoot(select(area2 > zero, area2, one))) * across;
    for (unsigned row = 0; row < kBlockRows; ++row) {
      const Vector8 p{h * __builtin_convertvector((I8)kLanes, F8), splat(q.spacing * static_cast<float>(row & 7)),
                      splat(q.spacing * static_cast<float>(row >> 3))};
      const F8 d2 = squareToTriangle(p0, p1, p2, p), up = dot(upright, p - p0);
      const I8 is_nearer = d2 < square[row] * splat(1 - kTie), is_tie = d2 <= square[row] * splat(1 + kTie);
      height[row] = select(is_nearer | (is_tie & (size(up) > size(height[row]))), up, height[row]);
      square[row] = minOf(square[row], d2);
    }
  }
  for (unsigned row = 0; row < kBlockRows; ++row) {
    const F8 distance = minOf(squareRoot(square[row]), most);
    store(q.out + 8 * row, select(height[row] > zero, zero - distance, distance));
  }
}

}  // namespace
}  // namespace spheretree::runtime
