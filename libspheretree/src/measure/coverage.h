// SPDX-License-Identifier: GPL-3.0-or-later
// The part of a mesh's surface that a union of balls leaves uncovered: its share of the area, and the largest gap with
// a proven bound. The gap of a surface point is its distance to the union. Definitions: docs/measures.md
// Units: mm. Deterministic: same arguments, same result, for any number of threads.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/sphere_union.h"
#include "spheretree/builder/evaluation.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct SurfacePoint {
  Eigen::Vector3d point;   // [mm]
  std::uint32_t triangle;  // triangle that contains it
};

/// `count` points spread over the surface more evenly than at random: one in each of `count` equal shares of the area,
/// placed within the triangle by an additive recurrence. Empty if the mesh has no area.
/// Paper: H. Niederreiter. Random number generation and quasi-Monte Carlo methods. SIAM, 1992 (Kronecker sequences).
std::vector<SurfacePoint> spreadOverSurface(const TriangleMesh& mesh, std::size_t count, std::uint64_t seed);

struct CoverageSettings {
  double tolerance = 0;                // gaps up to this count as covered [mm]; > 0
  std::size_t samples = 200000;        // of the surface, by area
  std::uint64_t seed = 1;              // of the samples
  std::size_t max_pieces = 4'000'000;  // then the search for the largest gap ends with its current bound
};

/// Cost: a search for each sample, and for each piece into which the triangles must be cut (a few for each triangle in
/// a good cover).
/// @throws Cancelled, std::invalid_argument for a mesh without area or a tolerance out of range.
Coverage measureCoverage(const TriangleMesh& mesh, const SphereUnion& balls, const CoverageSettings& settings, Progress& progress);

}  // namespace spheretree::builder
