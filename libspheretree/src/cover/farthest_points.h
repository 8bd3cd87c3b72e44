// SPDX-License-Identifier: GPL-3.0-or-later
// A first cover, from which cover_search.h starts: each ball is added at the sample that lies farthest outside of those
// before it.
// Paper: T. F. Gonzalez. Clustering to minimize the maximum intercluster distance. Theoretical Computer Science 38,
//        1985; here the distance of a sample from a ball is its gap |p - c| - d(c).
#pragma once

#include <span>
#include <vector>

#include "base/ball.h"
#include "geometry/distance_field.h"

namespace spheretree::builder {

/// At most `count` inscribed balls. The first touches the surface at a sample; each other one is the largest that
/// leaves the sample of the largest gap half of it, so that it reaches past a sharp edge. On a sheet, where no ball is
/// inscribed, it is a point. Fewer if no gap is left; none if no ball touches the surface at any sample. Deterministic.
/// Cost: O(n log n) for n samples in practice, and about five distance queries a ball.
std::vector<Ball> farthestPointBalls(const DistanceField& field, std::span<const Eigen::Vector3d> samples, std::size_t count);

}  // namespace spheretree::builder
