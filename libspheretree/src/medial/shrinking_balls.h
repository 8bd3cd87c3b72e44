// SPDX-License-Identifier: GPL-3.0-or-later
// Surface samples -> the medial balls that touch the surface there.
// Paper: J. Ma, S. W. Bae, S. Choi. 3D medial axis point approximation using nearest neighbors and the normal field.
//         The Visual
//        Computer 28(1), 2012. Here the nearest neighbour is sought on the mesh and not among samples, so that every
//        ball is inscribed and no angle threshold is needed.
#pragma once

#include <span>
#include <vector>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "geometry/surface_samples.h"

namespace spheretree::builder {

/// The largest inscribed ball that touches the surface at `point`; `normal` is the outward unit normal there. Radius 0
/// if it vanishes.
/// `guess`: a radius that it may have, such as that of a ball nearby; it saves time. 0: none [mm].
/// `stand_off`: the ball may be so far from the point [mm]; the largest such ball lies deeper, and there is one below a
/// convex edge too.
Ball shrinkingBall(const DistanceField& field, const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double guess = 0,
                   double stand_off = 0);

/// The largest inscribed ball that touches the surface where it is nearest to `p`, which may lie anywhere. Radius 0 if
/// it vanishes.
Ball touchingBall(const DistanceField& field, const Eigen::Vector3d& p);

/// The largest inscribed ball that touches the surface at each sample, to a relative 1e-3; the radius is the true
/// distance to the mesh. Samples where it vanishes (sharp convex edges) give none. Free of the degeneracies of a
/// Delaunay triangulation. Deterministic, in the order of the samples. Cost: about five distance queries a sample.
std::vector<Ball> shrinkingBalls(std::span<const SurfaceSample> samples, const DistanceField& field);

}  // namespace spheretree::builder
