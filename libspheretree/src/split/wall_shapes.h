// SPDX-License-Identifier: GPL-3.0-or-later
// Shapes of which the walls below a tooth are made: the span of a loop, a collar, a stub. Units: mm.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Closed line of vertices along which a wall begins, in the direction of the triangles of the wall.
struct WallRim {
  std::vector<std::uint32_t> loop;
  std::vector<char> is_still;  // of each vertex of the loop: a collar does not move it
};

/// Triangulates `loop`, wound as it runs; as a fan around its middle, a new vertex, if it has no triangulation. Nothing
/// for fewer than three vertices.
std::vector<Triangle> spanWall(TriangleMesh& mesh, const std::vector<std::uint32_t>& loop);

struct Collar {
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> inner;  // loop at its inner end; contains the vertices that stayed
};

/// Adds a strip of `depth` [mm, > 0] from the rim into the solid. Its inner end is the rim, smoothed over a length of
/// about `depth`, moved against the normals of its vertices. `normals`: outward unit normals of the first vertices of
/// the mesh; other vertices move against `up`, a unit vector. `edge`: mean edge of the rim [mm].
Collar addCollar(TriangleMesh& mesh, const WallRim& rim, double depth, double edge, std::span<const Eigen::Vector3d> normals,
                 const Eigen::Vector3d& up);

/// Adds a cone of the length `root` [mm], against `up`, with a flat end that is 0.4 times as wide as the rim.
std::vector<Triangle> addStub(TriangleMesh& mesh, const std::vector<std::uint32_t>& rim, double root, const Eigen::Vector3d& up);

}  // namespace spheretree::builder
