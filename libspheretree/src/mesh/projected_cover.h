// SPDX-License-Identifier: GPL-3.0-or-later
// Which part of a triangle lies near a surface, by projection: a proof for a large triangle over many small ones that
// needs no samples.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "geometry/distance_field.h"

namespace spheretree::builder {

struct ProjectedCover {
  double distance = 0;                                      // no point of what is covered is farther from the surface [mm]
  std::vector<std::array<Eigen::Vector3d, 3>> not_covered;  // the rest of the triangle, in pieces
};

/// Along the normal of `triangle`, each triangle of `field` covers its projection where it is no farther than `allowed`
/// [mm]. These projections are taken away from `triangle` one by one. Cost: O(n) for n triangles near it, times the
/// pieces that it is in meanwhile.
ProjectedCover coverByProjection(const std::array<Eigen::Vector3d, 3>& triangle, const DistanceField& field, double allowed);

}  // namespace spheretree::builder
