// SPDX-License-Identifier: Apache-2.0
// A mesh with places marked in colour, to be looked at: grey, the triangles named in colour, and an octahedron about
// each point.
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

inline constexpr std::size_t kMostMarkedPoints = 20000;  // of each: what comes later gets no octahedron

/// GLB, glTF 2.0 in metres: nodes "mesh" and one for each of `marks` that has anything. A triangle of several marks has
/// the colour of the first. Triangles that name missing vertices and points that are not finite are left out. Faces are
/// shown from both sides.
std::vector<std::byte> encodeMarkedGlb(const TriangleMesh& mesh, std::span<const Marks> marks);

}  // namespace spheretree::formats
