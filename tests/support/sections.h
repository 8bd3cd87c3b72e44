// SPDX-License-Identifier: Apache-2.0
// Plane sections of a closed mesh.
#pragma once

#include <map>
#include <utility>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::test {

/// Number of closed outlines in which the plane z = `height` cuts the mesh; no vertex may lie in the plane.
inline int outlinesAtHeight(const TriangleMesh& mesh, double height) {
  // Triangles that the plane cuts are connected by the edges that it cuts; counts the pieces.
  std::vector<std::size_t> root(mesh.triangles.size());
  for (std::size_t t = 0; t < root.size(); ++t) root[t] = t;
  const auto find = [&root](std::size_t t) {
    while (root[t] != t) t = root[t] = root[root[t]];
    return t;
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> first_at;
  std::vector<bool> cut(mesh.triangles.size(), false);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      if ((mesh.positions[a].z() < height) == (mesh.positions[b].z() < height)) continue;
      cut[t] = true;
      const auto [at, is_new] = first_at.try_emplace(std::minmax(a, b), t);
      if (!is_new) root[find(t)] = find(at->second);
    }
  }
  int count = 0;
  for (std::size_t t = 0; t < root.size(); ++t) count += cut[t] && find(t) == t ? 1 : 0;
  return count;
}

}  // namespace spheretree::test
