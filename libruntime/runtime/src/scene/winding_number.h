// SPDX-License-Identifier: Apache-2.0
// On which side of a skin a point is.
#pragma once

#include "scene/compiled_skin.h"

namespace spheretree::runtime {

/// How often the surface winds around a point: 1 inside a closed surface, 0 outside; in between for a surface with
/// holes. Triangles that are far away, relative to their distances from one another, count as one face. Adds its work,
/// in 8-lane tests, which grows with the logarithm of the number of triangles.
/// Papers: A. Jacobson, L. Kavan, O. Sorkine-Hornung. Robust inside-outside segmentation using generalized winding
///         numbers. ACM TOG 32(4), 2013. G. Barill, N. G. Dickson, R. Schmidt, D. I. W. Levin, A. Jacobson. Fast
///         winding numbers for soups and clouds. ACM TOG 37(4), 2018. A triangle's solid angle: A. van Oosterom,
///         J. Strackee. The solid angle of a plane triangle. IEEE TBME 30(2), 1983.
double windingNumber(const CompiledSkin& skin, const Eigen::Vector3d& point, std::uint32_t& work);

}  // namespace spheretree::runtime
