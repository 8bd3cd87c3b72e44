// SPDX-License-Identifier: GPL-3.0-or-later
// Proves that a set of spheres covers every triangle of a mesh, and closes remaining gaps by the smallest growth.
//
// A triangle lies in a ball if and only if its three corners do, since a ball is convex. A triangle that lies in no
// single ball is cut into the power cells of the balls, which shows whether they cover it together. If they do not, it
// is split until each piece lies in one ball. If a piece of the finest split lies in no ball, the nearest ball grows
// until it contains the piece. All points of every triangle are covered, not only samples. The decision is made for the
// stored float32 spheres, with a margin for the rounding of the new corners, so that it holds in real arithmetic. The
// proof: docs/algorithms/certify/certify_cover.md
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "base/ball.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct CertifiedCover {
  std::vector<Sphere> spheres;  // one for each ball; centres relative to the origin; radii that grew are rounded up, others to nearest
  double largest_growth = 0;    // largest increase of a radius to close a gap [mm]
  std::size_t pieces = 0;       // triangle pieces in the proof, each in one sphere
};

/// Rounds `balls` to float32 about `origin` and grows them until they cover `mesh`. The growth exceeds what the deepest
/// gap needs by at most `resolution` [mm] (> 0; a thousandth of the stand-off is a good choice) or 10 %, whichever is
/// larger. Deterministic for any number of threads. Cost: O(triangles + pieces); a piece tests the few balls near its
/// triangle.
/// @throws std::invalid_argument for no balls, or a ball out of the range of float32.
CertifiedCover certifyCover(const TriangleMesh& mesh, std::span<const Ball> balls, const Eigen::Vector3d& origin, double resolution,
                            Progress& progress);

/// Marks redundant spheres among `candidates` (indices into `spheres`): without them the others still cover `mesh`.
/// Candidates are removed one after the other, each with a proof that examines only the triangles near it. `spheres`
/// (relative to `origin`) must cover the mesh. The decision is exact, by power cells; where rounding leaves a doubt,
/// the sphere is kept. Deterministic.
std::vector<char> provenRedundant(const TriangleMesh& mesh, std::span<const Sphere> spheres, const Eigen::Vector3d& origin,
                                  std::span<const std::uint32_t> candidates, Progress& progress);

/// A point of the surface outside all balls.
struct CoverGap {
  Eigen::Vector3d point;  // [mm]
  double gap;             // distance to the nearest ball [mm]
  std::uint32_t triangle;
};

/// The balls, at most four and filled up with kNoBall, that together covered a triangle at its last test. They usually
/// still do after balls have moved slightly, and testing them is faster than a search.
constexpr std::uint32_t kNoBall = std::numeric_limits<std::uint32_t>::max();
using HeldBy = std::array<std::uint32_t, 4>;

/// Finds all places farther than `tolerance` [mm] (>= 0) from the balls: the result contains at least one point of each
/// connected uncovered part of a triangle. Exact up to rounding: the points are corners of the power cells of the
/// balls, each grown by the tolerance. Sorted by triangle. Deterministic for any number of threads. The cost of a
/// triangle is quadratic in the number of balls that cut it.
/// `held_by`: for every triangle of `mesh`, kept from call to call; it only saves time.
std::vector<CoverGap> findCoverGaps(const TriangleMesh& mesh, std::span<const std::uint32_t> triangles, std::span<const Ball> balls,
                                    double tolerance, Progress& progress, std::span<HeldBy> held_by = {});

/// The same surface in triangles with sides of at most `longest` [mm] (> 0), on which findCoverGaps() is faster. They
/// share no vertices.
TriangleMesh subdivided(const TriangleMesh& mesh, double longest);

}  // namespace spheretree::builder
