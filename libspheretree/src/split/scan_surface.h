// SPDX-License-Identifier: GPL-3.0-or-later
// A scan on its way to solids: a manifold surface whose vertices, and once it is cut whose triangles, have a region.
// Units: mm.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mesh/triangle_area.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

inline constexpr std::int32_t kGumRegion = 0;  // all pieces of the gum; other regions are single pieces of a label

inline constexpr std::size_t kMostSplitCrossings = 100'000;  // pairs after which a count of crossings stops

struct ScanSurface {
  TriangleMesh mesh;
  std::vector<std::int32_t> vertex_region;  // before the cut
  std::vector<std::int32_t> region;         // for each triangle, after the cut
  std::vector<char> is_invented;            // for each triangle: filled or added, no part of the scan
  std::vector<std::int32_t> region_label;   // label of each region
};

/// Triangle with the directed edge from -> to, if there is one.
class EdgeFaces {
 public:
  explicit EdgeFaces(const TriangleMesh& mesh);
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::uint32_t face(std::uint32_t from, std::uint32_t to) const;

 private:
  std::vector<std::uint32_t> first_;  // of each vertex, into the entries
  struct Entry {
    std::uint32_t to, face;
  };
  std::vector<Entry> entries_;  // by from, in the order of the triangles
};

/// Triangles at the vertices of a loop, then those at the vertices of these, and so on, `rings` times; indices ascend.
std::vector<std::uint32_t> trianglesNear(const TriangleMesh& mesh, std::span<const std::uint32_t> loop, int rings);

/// Makes the surface manifold by leaving out triangles: at edges with more than two, or with two that run the same way,
/// those beyond one in each direction; at vertices in which several fans meet, all but the largest fan. Returns the
/// area that went. Vertices stay, used or not.
double makeManifold(TriangleMesh& mesh);

/// Leaves out what is true in `is_dropped`, and makes the rest manifold. Before anything is invented.
void dropTriangles(ScanSurface& surface, const std::vector<char>& is_dropped);

}  // namespace spheretree::builder
