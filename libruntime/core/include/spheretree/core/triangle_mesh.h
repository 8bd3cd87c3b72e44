// SPDX-License-Identifier: Apache-2.0
// A triangle mesh, as all rooms use it: positions in millimetres, triangles counter-clockwise seen from outside.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace spheretree {

using Triangle = std::array<std::uint32_t, 3>;  // vertex indices

struct TriangleMesh {
  std::vector<Eigen::Vector3d> positions;  // [mm], frame of the file after its unit scale
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> part;      // one for each triangle: index into part_names; empty: all triangles are of part 0
  std::vector<std::string> part_names;  // at least one name if `part` is not empty; "" for an unnamed part

  /// Corner `k` (0..2) of triangle `t`.
  const Eigen::Vector3d& corner(std::size_t t, int k) const { return positions[triangles[t][static_cast<std::size_t>(k)]]; }
};

}  // namespace spheretree
