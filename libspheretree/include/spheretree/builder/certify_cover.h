// SPDX-License-Identifier: GPL-3.0-or-later
// Proves that a set of spheres covers every triangle of a mesh, and closes what is left by the smallest growth.
//
// A triangle lies in a sphere iff its three corners do (a ball is convex). A triangle that lies in no single sphere is split
// until each piece does; a piece that no sphere holds down to the finest split makes the sphere grow that needs to grow
// least. Every triangle counts, not samples. Decided for the stored float32 spheres, with a margin for the rounding of the
// split points, so that the statement holds in real arithmetic.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "spheretree/builder/ball.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct CertifiedCover {
  std::vector<Sphere> spheres;       // (as many as balls), centres relative to the origin given, radii grown and rounded up
  double largest_growth = 0;         // most that one radius grew to close a gap [mm]
  std::size_t pieces = 0;            // triangle pieces in the proof
};

/// Rounds `balls` to float32 about `origin` (radius up by what the rounding of the centre costs) and grows them until they
/// cover `mesh`. Deterministic for any number of threads.
/// @throws std::invalid_argument for no balls, a ball that is not finite, or one too large for float32.
CertifiedCover certifyCover(const TriangleMesh& mesh, std::span<const Ball> balls, const Eigen::Vector3d& origin, Progress& progress);

/// Point of the surface farthest outside the spheres among the pieces that could not be proven covered, or an empty list:
/// the check alone, without growing. At most `most` points come back; they serve as new samples.
struct CoverGap {
  Eigen::Vector3d point;  // on the surface, in the frame of the mesh
  double gap;             // distance to the nearest sphere [mm]
  std::uint32_t triangle;
};
std::vector<CoverGap> findCoverGaps(const TriangleMesh& mesh, std::span<const Ball> balls, double tolerance, std::size_t most);

}  // namespace spheretree::builder
