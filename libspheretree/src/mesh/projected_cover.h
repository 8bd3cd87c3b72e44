// SPDX-License-Identifier: GPL-3.0-or-later
// The part of a triangle that lies near a surface, by projection: a proof for a large triangle over many small ones
// that needs no samples.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "geometry/distance_field.h"

namespace spheretree::builder {

struct ProjectedCover {
  double distance = 0;                                      // no covered point is farther than this from the surface [mm]
  std::vector<std::array<Eigen::Vector3d, 3>> not_covered;  // the remaining part of the triangle, in pieces
};

/// Each triangle of `field` covers its projection along the normal of `triangle`, where it is at most `allowed` [mm]
/// away. These projections are subtracted from `triangle`, which is first divided until few of them reach into a part.
/// Cost: O(n log n) for n triangles nearby.
ProjectedCover coverByProjection(const std::array<Eigen::Vector3d, 3>& triangle, const DistanceField& field, double allowed);

}  // namespace spheretree::builder
