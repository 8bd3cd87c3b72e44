// SPDX-License-Identifier: Apache-2.0
// A mesh with marked places, for viewing: the mesh in grey, marked triangles in colour, and an octahedron around each
// marked point.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::formats {

struct Marks {
  std::string name;                      // of the mesh in the file
  std::array<double, 3> colour;          // red, green, blue, 0 to 1
  std::vector<std::uint32_t> triangles;  // of the mesh, in any order
  std::vector<Eigen::Vector3d> points;   // [mm]
};

inline constexpr std::size_t kMaxMarkedPoints = 20000;  // of each of `marks`: further points get no octahedron

/// GLB, glTF 2.0 in metres: a node "mesh" and a node for each non-empty element of `marks`. A triangle in several marks
/// has the colour of the first. Triangles with missing vertices and points that are not finite are left out. Faces are
/// visible from both sides.
std::vector<std::byte> encodeMarkedGlb(const TriangleMesh& mesh, std::span<const Marks> marks);

}  // namespace spheretree::formats
