// SPDX-License-Identifier: Apache-2.0
// Rows of a ball of the tool and a ball of an object. docs/algorithms/runtime/rows.md
#pragma once

#include "kernel/hull_balls_lanes.h"
#include "kernel/row_parts_lanes.h"

namespace spheretree::runtime {
namespace {

float sphereRows(const RowRequest& q) {
  const F8 one = splat(1);
  F8 smallest = splat(__builtin_inff());
  for (std::uint32_t i = 0; i < q.count; i += 8) {
    ToolBalls balls(q, i);
    const Sphere* object[8];
    Sphere kept[8];
    for (unsigned k = 0; k < 8; ++k) {
      const std::uint32_t slot = balls.slot[k], lane = slot & 7;
      object[k] = q.object + slot;
      if (q.object) continue;
      const Block& b = q.bound[slot >> 3];
      kept[k] = {b.x[lane], b.y[lane], b.z[lane], b.r[lane]};
      object[k] = kept + k;
    }
    Vector8 c;
    F8 radius;
    transpose(object, c.x, c.y, c.z, radius);
    const I8 within = q.hulls.way ? touchBalls(partsOf(q, i, balls), c, balls) : kOnlyBalls.within;
    const Vector8 way = balls.centre - c;
    const F8 square = dot(way, way), sum = balls.radius + radius;
    const I8 apart = square > splat(1e-20f);  // otherwise the centres coincide, and the normal is +z
    const F8 d = squareRoot(square), scale = one / select(apart, d, one);
    F8 gap = d - sum;
    smallest = minOf(smallest, select(within, gap, splat(__builtin_inff())));
    if (q.squared) gap = gap * (d + sum) * (splat(0.5f) * scale);
    storeRows(q, i, balls, select(apart, scale * way, splat(0, 0, 1)), gap, within, q.hulls.way);
  }
  return minLane(smallest);
}

}  // namespace
}  // namespace spheretree::runtime
