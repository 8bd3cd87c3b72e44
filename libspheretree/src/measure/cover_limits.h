// SPDX-License-Identifier: GPL-3.0-or-later
// What overhang a given number of balls must have, at least about, to cover a surface: a formula and a numerical lower
// bound to hold a tree against. Derivations: docs/measures.md
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

/// Area of the discs of the thinnest cover of the plane, per area covered: 2 pi / (3 sqrt 3). Kershner 1939.
inline constexpr double kHexagonalCover = 1.2091995761561452;

struct CoverLimitSettings {
  std::size_t samples = 30000;        // surface points: h_fin takes a medial ball from each, h_low counts them
  std::size_t candidates = 8000;      // of the medial balls, for h_low; range [1, samples]
  double noise_angle = 0.5235987756;  // contacts of a medial ball seen under less than this from its centre are one [rad], 30 degrees
  std::uint64_t seed = 1;
};

/// Largest ball inside the solid that touches triangle `triangle` at its point `p`. The mesh must be closed and
/// oriented.
Ball largestInnerBall(const DistanceField& field, const Eigen::Vector3d& p, std::uint32_t triangle, double noise_angle);

/// Limits for `balls` (>= 1) balls. Meaningful while they are small against the gaps between parts of the object.
/// @throws Cancelled, std::invalid_argument for no balls, settings out of range or a mesh without area.
CoverLimits coverLimits(const TriangleMesh& mesh, const DistanceField& field, std::size_t balls, const CoverLimitSettings& settings,
                        Progress& progress);

}  // namespace spheretree::builder
