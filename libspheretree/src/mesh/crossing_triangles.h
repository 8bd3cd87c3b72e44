// SPDX-License-Identifier: GPL-3.0-or-later
// The pairs of triangles of a mesh that cross, touch or overlap outside their shared corners and edges. Decided by
// exact arithmetic.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct CrossingTriangles {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  // lower triangle first, sorted
  bool is_stopped = false;                                     // at `most` pairs: there may be more, and which were found is chance
};

/// Two triangles cross if they have a point in common that is no shared corner and on no shared edge: two that are
/// folded flat onto each other do. Triangles are told by their indices, so that bodies that only touch do cross. Flat
/// triangles (corners repeated or exactly in line) are left out, and duplicates are no pair. Indices and coordinates
/// must be sound.
/// Cost: O(n log n) plus one test for each pair of triangles whose boxes meet.
CrossingTriangles findCrossingTriangles(const TriangleMesh& mesh, std::size_t most);

/// The test of one pair; neither is flat.
bool doCross(const std::vector<Eigen::Vector3d>& positions, const Triangle& a, const Triangle& b);

/// Whether a triangle has repeated corners, or corners exactly in line.
bool isFlat(const TriangleMesh& mesh, std::size_t triangle);
bool isFlat(const std::vector<Eigen::Vector3d>& positions, const Triangle& triangle);

}  // namespace spheretree::builder
