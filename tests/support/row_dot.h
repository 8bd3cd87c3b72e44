// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "rows/rows.h"

namespace spheretree::test {

/// Row k of `set` times `y`, without the weight of the row.
inline double rowDot(const runtime::RowSet& set, std::uint32_t k, const runtime::Vector6& y) {
  double sum = 0;
  for (std::size_t i = 0; i < 6; ++i) sum += static_cast<double>(set.rows.a[i][k]) * y[static_cast<int>(i)];
  return sum / static_cast<double>(set.weight[k]);
}

}  // namespace spheretree::test
