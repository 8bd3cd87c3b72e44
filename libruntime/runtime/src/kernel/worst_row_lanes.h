// SPDX-License-Identifier: Apache-2.0
// The row of a QP that a point violates most (qp6.h).
#pragma once

#include "kernel/kernel.h"
#include "kernel/lanes.h"

namespace spheretree::runtime {
namespace {

WorstRow worstRow(const float* const* a, const float* b, std::uint32_t count, const float* y) {
  const F8 y0 = splat(y[0]), y1 = splat(y[1]), y2 = splat(y[2]), y3 = splat(y[3]), y4 = splat(y[4]), y5 = splat(y[5]);
  F8 smallest = splat(__builtin_inff());
  U8 at = splatU(0), index = kLanes;
  for (std::uint32_t i = 0; i < count; i += 8, index += splatU(8)) {
    const F8 s = ((load(a[0] + i) * y0 + load(a[1] + i) * y1) + (load(a[2] + i) * y2 + load(a[3] + i) * y3)) +
                 ((load(a[4] + i) * y4 + load(a[5] + i) * y5) - load(b + i));
    const I8 less = s < smallest;
    smallest = select(less, s, smallest);
    at = (U8)(((I8)index & less) | ((I8)at & ~less));
  }
  WorstRow worst{~0u, minLane(smallest)};
  for (unsigned lanes = maskOf(smallest == splat(worst.slack)); lanes; lanes &= lanes - 1) {
    const std::uint32_t row = at[__builtin_ctz(lanes)];
    worst.row = row < worst.row ? row : worst.row;
  }
  return worst;
}

}  // namespace
}  // namespace spheretree::runtime
