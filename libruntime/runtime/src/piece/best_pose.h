// SPDX-License-Identifier: Apache-2.0
// The answer of a step: the last free pose of all its pieces, or else the one with the smallest depth.
#pragma once

#include <limits>

#include "spheretree/core/rigid.h"
#include "spheretree/runtime/step.h"

namespace spheretree::runtime {

struct BestPose {
  Configuration pose;
  double depth = std::numeric_limits<double>::infinity();  // penetration of the guaranteed surface [mm]

  bool isKnown() const { return depth < std::numeric_limits<double>::infinity(); }
  void set(const Configuration& to, double to_depth) {
    pose = to;
    depth = to_depth;
  }
  void record(const Configuration& next, double next_depth) {
    if (next_depth < depth || next_depth <= 0.5 * kGapTolerance) set(next, next_depth);
  }
};

}  // namespace spheretree::runtime
