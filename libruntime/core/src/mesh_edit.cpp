// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/mesh_edit.h"

#include <bit>

namespace spheretree {
namespace {

/// The index of the first vertex at exactly the same position, for each position; kNone where `used` is false.
std::vector<std::uint32_t> firstAtEach(const std::vector<Eigen::Vector3d>& positions, const std::vector<bool>& used) {
  const std::size_t slots = std::bit_ceil(positions.size() * 2 + 1);
  std::vector<std::uint32_t> table(slots, kNone), first(positions.size(), kNone);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!used[i]) continue;
    std::uint64_t hash = 0x9e3779b97f4a7c15u;
    for (int axis = 0; axis < 3; ++axis) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(positions[i][axis])) * 0xbf58476d1ce4e5b9u;
      hash ^= hash >> 29;
    }
    hash = (hash ^ (hash >> 32)) * 0x94d049bb133111ebu;
    std::size_t slot = (hash ^ (hash >> 31)) & (slots - 1);
    while (table[slot] != kNone && positions[table[slot]] != positions[i]) slot = (slot + 1) & (slots - 1);
    if (table[slot] == kNone) table[slot] = static_cast<std::uint32_t>(i);
    first[i] = table[slot];
  }
  return first;
}

}  // namespace

void dropUnusedVertices(TriangleMesh& mesh) {
  std::vector<std::uint32_t> index(mesh.positions.size(), kNone);
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) index[v] = 0;
  std::size_t kept = 0;
  for (std::size_t v = 0; v < index.size(); ++v) {
    if (index[v] == kNone) continue;
    index[v] = static_cast<std::uint32_t>(kept);
    mesh.positions[kept++] = mesh.positions[v];
  }
  mesh.positions.resize(kept);
  for (Triangle& triangle : mesh.triangles)
    for (std::uint32_t& v : triangle) v = index[v];
}

std::vector<std::uint32_t> weldEqualVertices(TriangleMesh& mesh) {
  std::vector<bool> used(mesh.positions.size());
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) used[v] = true;
  std::vector<std::uint32_t> index = firstAtEach(mesh.positions, used);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < index.size(); ++i) {
    if (index[i] == kNone) continue;
    if (index[i] == i) {
      index[i] = static_cast<std::uint32_t>(kept);
      mesh.positions[kept++] = mesh.positions[i];
    } else {
      index[i] = index[index[i]];  // the first one precedes it and already has its new index
    }
  }
  mesh.positions.resize(kept);
  for (Triangle& t : mesh.triangles)
    for (std::uint32_t& v : t) v = index[v];
  return index;
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
