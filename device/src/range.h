// SPDX-License-Identifier: Apache-2.0
// Settings and their ranges.
#pragma once

#include <cstdio>
#include <span>
#include <string>

namespace spheretree::device {

struct Range {
  const char* name;
  double value, low, high;
};

/// A sentence that names the first setting outside its range (NaN is outside of any range), or "".
inline std::string outOfRange(std::span<const Range> ranges) {
  for (const Range& r : ranges) {
    if (r.value >= r.low && r.value <= r.high) continue;
    char text[128];
    std::snprintf(text, sizeof text, " is %.9g: give a number from %g to %g", r.value, r.low, r.high);
    return r.name + std::string(text);
  }
  return {};
}

}  // namespace spheretree::device
