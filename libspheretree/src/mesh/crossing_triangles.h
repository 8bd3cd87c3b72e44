// SPDX-License-Identifier: GPL-3.0-or-later
// The pairs of triangles of a mesh that cross, touch or overlap outside their shared corners and edges, by exact
// arithmetic.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct CrossingTriangles {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  // lower triangle first, sorted
  bool is_stopped = false;  // stopped at `max_pairs` pairs: there may be more, and which ones were found is arbitrary
};

/// Two triangles cross if they have a common point that is neither a shared corner nor on a shared edge; two triangles
/// that are folded flat onto each other do. Corners are compared by index, so that bodies that merely touch do cross.
/// Flat triangles (corners repeated or exactly in line) are ignored, and duplicates are not pairs. Indices and
/// coordinates must be valid.
/// Cost: O(n log n) plus one test for each pair of triangles whose boxes overlap; of slivers that lie side by side or
/// around a point, only neighbours are tested. @throws Cancelled
CrossingTriangles findCrossingTriangles(const TriangleMesh& mesh, std::size_t max_pairs, const Progress& progress = {});

/// The test of one pair; neither triangle may be flat.
bool doCross(const std::vector<Eigen::Vector3d>& positions, const Triangle& a, const Triangle& b);

/// Whether a triangle has repeated corners, or corners exactly in line.
bool isFlat(const TriangleMesh& mesh, std::size_t triangle);
bool isFlat(const std::vector<Eigen::Vector3d>& positions, const Triangle& triangle);

}  // namespace spheretree::builder
