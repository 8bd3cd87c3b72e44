// SPDX-License-Identifier: GPL-3.0-or-later
// An upper bound of the overhang of a stored sphere.
#pragma once

#include <Eigen/Core>

#include "geometry/distance_field.h"
#include "spheretree/core/sphere.h"

namespace spheretree::builder {

/// Proven: no point of the sphere is farther outside the surface than this [mm]. No point of a ball with centre c and
/// radius r is farther outside than r + s(c), where s is the signed distance, negative inside. The centre of the sphere
/// is relative to `origin`.
double overhangBound(const DistanceField& field, const Eigen::Vector3d& origin, const Sphere& sphere);

}  // namespace spheretree::builder
