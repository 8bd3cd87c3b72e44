// SPDX-License-Identifier: GPL-3.0-or-later
// Proves that a set of spheres covers every triangle of a mesh, and closes what is left by the smallest growth.
//
// A triangle lies in a ball iff its three corners do: a ball is convex. A triangle that lies in no single ball is split
// until each piece does; a piece that no ball holds down to the finest split makes the nearest ball grow until it does.
// Every triangle counts, not samples. Decided for the stored float32 spheres, with a margin for the rounding of the
// split points, so that the statement holds in real arithmetic. The proof: docs/algorithms/certify/certify_cover.md
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
  std::vector<Sphere> spheres;  // (as many as balls), centres relative to the origin; grown radii rounded up, others to nearest
  double largest_growth = 0;    // most that one radius grew to close a gap [mm]
  std::size_t pieces = 0;       // triangle pieces in the proof, each in one sphere
};

/// Rounds `balls` to float32 about `origin` and grows them until they cover `mesh`. Gaps are closed to within
/// `resolution` [mm] (> 0, a thousandth of the stand-off is a good choice), or 10 % if that is more, of the growth that
/// the deepest gap found asks for. Deterministic for any number of threads.
/// Cost: O(triangles + pieces), a piece tests the few balls near its triangle.
/// @throws std::invalid_argument for no balls, or a ball that float32 cannot hold.
CertifiedCover certifyCover(const TriangleMesh& mesh, std::span<const Ball> balls, const Eigen::Vector3d& origin, double resolution,
                            Progress& progress);

/// Marks those of `candidates` (indices into `spheres`) without which the others still cover `mesh`: taken away one
/// after the other, each with a proof that looks at the triangles near it only. Needs `spheres` (relative to `origin`)
/// to cover the mesh. Decided exactly, by power cells; where rounding leaves a doubt the sphere is kept. Deterministic.
std::vector<char> provenRedundant(const TriangleMesh& mesh, std::span<const Sphere> spheres, const Eigen::Vector3d& origin,
                                  std::span<const std::uint32_t> candidates, Progress& progress);

/// A point of the surface that no ball holds.
struct CoverGap {
  Eigen::Vector3d point;  // [mm]
  double gap;             // distance to the nearest ball [mm]
  std::uint32_t triangle;
};

/// Balls that together held a triangle when it was last looked at, fewer filled up with kNoBall; no more than four.
/// Most of them still do when balls have moved a little, which is quicker to see than that any do.
constexpr std::uint32_t kNoBall = std::numeric_limits<std::uint32_t>::max();
using HeldBy = std::array<std::uint32_t, 4>;

/// All places that are farther than `tolerance` [mm] (>= 0) from the balls: each connected piece of them in a triangle
/// has at least one of the points found in it. Exact up to rounding: the points are corners of the power cells of the
/// balls, each grown by the tolerance. Sorted by triangle. Deterministic for any number of threads. Cost: a triangle
/// costs the square of the number of balls that cut it.
/// `held_by`: of every triangle of `mesh`, from earlier calls and for later ones; only a saving of time.
std::vector<CoverGap> findCoverGaps(const TriangleMesh& mesh, std::span<const std::uint32_t> triangles, std::span<const Ball> balls,
                                    double tolerance, Progress& progress, std::span<HeldBy> held_by = {});

/// The same surface in triangles without a side longer than `longest` [mm] (> 0), which findCoverGaps is quicker with.
/// They share no vertices.
TriangleMesh subdivided(const TriangleMesh& mesh, double longest);

}  // namespace spheretree::builder
