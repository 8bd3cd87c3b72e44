// SPDX-License-Identifier: GPL-3.0-or-later
// A scan while it is turned into solids: a manifold surface whose vertices, and after the cut whose triangles, have a
// region.
// Units: mm.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mesh/triangle_area.h"
#include "spheretree/core/none.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

inline constexpr std::int32_t kGumRegion = 0;  // all pieces of the gum; every other region is a single piece of a label

/// Rounds in which crossings are removed, without becoming fewer, before they stay; no scan needed more than 16.
inline constexpr int kMaxRounds = 25;

struct ScanSurface {
  TriangleMesh mesh;
  std::vector<std::int32_t> vertex_region;  // before the cut
  std::vector<std::int32_t> region;         // for each triangle, after the cut
  std::vector<char> is_invented;            // for each triangle: filled or added, not part of the scan
  std::vector<std::int32_t> region_label;   // label of each region
  std::vector<char> is_doubtful;            // vertices that were islands of another label; without those that were added
};

/// The triangle with the directed edge from -> to, if there is one.
class EdgeFaces {
 public:
  explicit EdgeFaces(const TriangleMesh& mesh);
  std::uint32_t face(std::uint32_t from, std::uint32_t to) const;

 private:
  std::vector<std::uint32_t> first_;  // index of the first entry of each vertex
  struct Entry {
    std::uint32_t to, face;
  };
  std::vector<Entry> entries_;  // by from, in the order of the triangles
};

/// The neighbours of each vertex along edges. A neighbour is listed once for each triangle at the edge, so that inner
/// neighbours, which all are listed twice, have the same weight.
class VertexNeighbours {
 public:
  explicit VertexNeighbours(const TriangleMesh& mesh);
  std::span<const std::uint32_t> of(std::uint32_t v) const { return {neighbours_.data() + first_[v], neighbours_.data() + first_[v + 1]}; }

 private:
  std::vector<std::uint32_t> first_;  // index of the first neighbour of each vertex
  std::vector<std::uint32_t> neighbours_;
};

/// Mean length of the edges of the triangles that were scanned [mm]; 1 if there are none.
double meanEdge(const ScanSurface& surface);

/// The triangles at the vertices of a loop, then those at the vertices of these triangles, and so on, `rings` times;
/// ascending indices.
std::vector<std::uint32_t> trianglesNear(const TriangleMesh& mesh, std::span<const std::uint32_t> loop, int rings);

/// Makes the surface manifold by removing triangles. At edges with more than two triangles, or with two in the same
/// direction, one triangle in each direction is kept; at vertices in which several fans meet, the largest fan is kept.
/// Returns the removed area. All vertices stay, used or not.
double makeManifold(TriangleMesh& mesh);

/// Removes the triangles that are marked in `is_dropped`, and makes the rest manifold. Call it before anything is
/// invented.
void dropTriangles(ScanSurface& surface, const std::vector<char>& is_dropped);

}  // namespace spheretree::builder
