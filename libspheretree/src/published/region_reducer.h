// SPDX-License-Identifier: GPL-3.0-or-later
// The interface of every reducer: it takes a region of the surface and medial balls, and returns a few balls that cover
// the region. All have one signature, so that the framework (build_by_regions.h) can run any of them, or several on the
// same region.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/distance_field.h"
#include "medial/adaptive_medial_axis.h"
#include "medial/surface_regions.h"

namespace spheretree::builder {

struct Region {
  const DistanceField& field;
  std::span<const Eigen::Vector3d> points;  // points to cover, at least one [mm]
  std::span<const FittedBall> pool;         // medial balls that touch the surface in the region; may be empty
  std::size_t max_balls = 8;                // >= 1
  double target_overhang = 0;               // fewer balls are used if their largest overhang stays within this [mm]; >= 0
};

/// Returns at most `max_balls` balls that contain every point of the region, or none if the method finds none (an empty
/// pool). Pure: the same region gives the same balls.
using Reducer = std::vector<FittedBall> (*)(const Region& region);

/// A published method: its reducer, and what its authors do before and after it.
struct Method {
  Reducer reduce = nullptr;
  enum class Axis { None, Static, Asked } axis = Axis::Asked;  // the medial axis of its pool; Asked: that of the settings
  bool refits = true;                                          // the balls of a region are refitted, and redundant ones dropped
};

inline double worstOverhang(std::span<const FittedBall> balls) {
  double worst = 0;
  for (const FittedBall& b : balls) worst = std::max(worst, b.overhang());
  return worst;
}

}  // namespace spheretree::builder
