// SPDX-License-Identifier: GPL-3.0-or-later
// The smooth surface that a mesh represents, through its vertices: where these lie evenly, the limit of a subdivision
// surface (loop_limit.h), elsewhere cubics fitted to them (cubic_fit.h), and at creases curves that follow the normals.
// docs/algorithms/skin/skin.md
// Papers: A. Vlachos et al. Curved PN triangles. I3D 2001 (sides at creases, from the normals of their ends);
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

/// Triangles that lean too far from the surface around them become facets: their sides become sharp in `edges`.
/// Deterministic. Cost: O(vertices), 60 iterations on the even ones.
SmoothSurface smoothSurface(const TriangleMesh& mesh, SurfaceEdges& edges);

}  // namespace spheretree::builder
