// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/mesh_edit.h"

namespace spheretree {

void dropUnusedVertices(TriangleMesh& mesh) {
  constexpr std::uint32_t kUnused = 0xffffffff;
  std::vector<std::uint32_t> index(mesh.positions.size(), kUnused);
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) index[v] = 0;
  std::size_t kept = 0;
  for (std::size_t v = 0; v < index.size(); ++v) {
    if (index[v] == kUnused) continue;
    index[v] = static_cast<std::uint32_t>(kept);
    mesh.positions[kept++] = mesh.positions[v];
  }
  mesh.positions.resize(kept);
  for (Triangle& triangle : mesh.triangles)
    for (std::uint32_t& v : triangle) v = index[v];
}

TriangleMesh joined(TriangleMesh mesh, const TriangleMesh& more) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), more.positions.begin(), more.positions.end());
  for (const auto& [a, b, c] : more.triangles) mesh.triangles.push_back({first + a, first + b, first + c});
  mesh.part.clear();
  mesh.part_names.clear();
  return mesh;
}

}  // namespace spheretree
