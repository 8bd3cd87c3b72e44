// SPDX-License-Identifier: GPL-3.0-or-later
// The smooth surface that a mesh represents: a Loop subdivision surface whose limit passes through the vertices of the
// mesh. Nothing is subdivided: limit positions and normals come from the limit masks. docs/algorithms/skin/skin.md
// Papers: C. Loop. Smooth subdivision surfaces based on triangles. Master's thesis, University of Utah, 1987;
//         H. Hoppe et al. Piecewise smooth surface reconstruction. SIGGRAPH 1994 (masks of the limit and its tangents);
//         A. Vlachos et al. Curved PN triangles. I3D 2001 (sides at creases, from the normals of their ends);
//         N. Max. Weights for computing vertex normals from facet normals. J. Graphics Tools 4(2), 1999.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "skin/surface_edges.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct SmoothSurface {
  std::vector<std::array<Eigen::Vector3d, 3>> corner_normal;  // (triangles) unit length; differs between the two sides of a sharp edge
  std::vector<std::array<Eigen::Vector3d, 3>> side_normal;    // (triangles) at the middles of the sides 01, 12, 20
  std::vector<Eigen::Vector3d> offset;                        // (edges) from the middle of the chord to the middle of the edge [mm]
};

/// Deterministic. Cost: O(vertices), 60 iterations.
SmoothSurface loopSurface(const TriangleMesh& mesh, const SurfaceEdges& edges);

}  // namespace spheretree::builder
