// SPDX-License-Identifier: GPL-3.0-or-later
// The overhang that a given number of balls needs to cover a surface: a formula and a numerical lower limit, both
// approximate, for comparison with a tree. Derivations: docs/measures.md
// Papers: R. Kershner. The number of circles covering a set. Amer. J. Math. 61, 1939. J. Ma, S. W. Bae, S. Choi. 3D
//         medial axis point approximation using nearest neighbors and the normal field. The Visual Computer 28, 2012
//         (shrinking ball).
// Units: mm. Deterministic: same arguments, same result, for any number of threads.
#pragma once

#include <cstdint>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/evaluation.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Total area of the discs in the thinnest cover of the plane, divided by the covered area: 2 pi / (3 sqrt 3). Kershner
/// 1939.
inline constexpr double kHexagonalCover = 1.2091995761561452;

struct CoverLimitSettings {
  std::size_t samples = 30000;    // surface points: h_fin computes a medial ball at each, h_low counts them
  std::size_t candidates = 8000;  // number of medial balls for h_low; range [1, samples]
  double noise_angle =
      0.5235987756;  // contacts of a medial ball that are less than this apart, seen from its centre, count as one [rad], 30 degrees
  std::uint64_t seed = 1;
};

/// Largest ball inside the solid that touches triangle `triangle` at its point `p`. The mesh must be closed and
/// oriented.
Ball largestInnerBall(const DistanceField& field, const Eigen::Vector3d& p, std::uint32_t triangle, double noise_angle);

/// Limits for `balls` (>= 1) balls. Meaningful as long as the balls are small compared with the distances between parts
/// of the object.
/// @throws Cancelled, std::invalid_argument for no balls, settings out of range or a mesh without area.
CoverLimits coverLimits(const TriangleMesh& mesh, const DistanceField& field, std::size_t balls, const CoverLimitSettings& settings,
                        Progress& progress);

}  // namespace spheretree::builder
