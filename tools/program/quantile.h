// SPDX-License-Identifier: Apache-2.0
// Quantiles of measured values.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace spheretree::tool {

/// The value at index floor(share * n) of the n sorted values, or the largest one if there is no such index; 0 without
/// values. With share 0.5 and an even n it is the upper of the two values in the middle.
/// `share`: range [0, 1].
template <class Value>
Value quantile(std::vector<Value> values, double share) {
  if (values.empty()) return 0;
  const std::size_t at = std::min(values.size() - 1, static_cast<std::size_t>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

}  // namespace spheretree::tool
