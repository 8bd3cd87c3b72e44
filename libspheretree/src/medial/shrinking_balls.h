// SPDX-License-Identifier: GPL-3.0-or-later
// From a point of the surface to the medial ball that touches the surface there.
// Paper: J. Ma, S. W. Bae, S. Choi. 3D medial axis point approximation using nearest neighbors and the normal field.
//         The Visual Computer 28(1), 2012. Here the nearest neighbour is searched on the mesh, not among samples, so
//         that every ball is inscribed and no angle threshold is needed.
#pragma once

#include "base/ball.h"
#include "geometry/distance_field.h"

namespace spheretree::builder {

inline constexpr double kVanishing = 1e-7;  // share of the diagonal: a smaller ball is none, on a sheet that is thinner, too

/// The largest inscribed ball that touches the surface at `point`; `normal` is the outward unit normal there. Radius 0
/// if no such ball exists.
/// `stand_off`: allowed distance of the ball from the point [mm]. The largest ball at that distance lies deeper, and it
/// exists below a convex edge, too.
Ball shrinkingBall(const DistanceField& field, const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double stand_off = 0);

/// The largest inscribed ball that touches the surface at the surface point nearest to `p`, which may be any point.
/// Radius 0 if no such ball exists.
Ball touchingBall(const DistanceField& field, const Eigen::Vector3d& p);

}  // namespace spheretree::builder
