// SPDX-License-Identifier: GPL-3.0-or-later
// The connectivity of a manifold triangle mesh whose edges can be collapsed: OpenMesh's half-edges, filled by ourselves
// on all threads. Where OpenMesh adds triangles one by one, it searches around both ends of each side, which takes n^2
// steps for a fan of n slivers: 14 s for 80,000 of them.
#pragma once

#include <OpenMesh/Core/Mesh/TriConnectivity.hh>
#include <cstdint>
#include <span>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Vertices have the numbers of the mesh. OpenMesh's half-edge 2 e + 1 runs the other way than 2 e; along a border, one
/// of the two has no triangle.
class HalfEdges {
 public:
  /// O(n), unless large fans meet at both ends of a side. @throws std::invalid_argument unless the mesh is manifold and
  /// its triangles agree about the outside.
  HalfEdges(std::span<const Triangle> triangles, std::size_t vertices);

  std::size_t count() const { return mesh_.n_halfedges(); }
  std::uint32_t from(std::uint32_t h) const { return index(mesh_.from_vertex_handle(halfEdge(h))); }
  std::uint32_t to(std::uint32_t h) const { return index(mesh_.to_vertex_handle(halfEdge(h))); }
  /// Whether a half-edge is not left.
  bool isRemoved(std::uint32_t h) const { return mesh_.status(mesh_.edge_handle(halfEdge(h))).deleted(); }

  /// Whether a vertex has no triangle (left).
  bool isIsolated(std::uint32_t v) const { return mesh_.is_isolated(vertex(v)); }
  bool isBorder(std::uint32_t v) const { return mesh_.is_boundary(vertex(v)); }
  /// Calls visit(h) for each half-edge from `v`, which is not isolated, in their order around it.
  template <class Visit>
  void visitFrom(std::uint32_t v, Visit&& visit) const {
    const OpenMesh::HalfedgeHandle first = mesh_.halfedge_handle(vertex(v));
    OpenMesh::HalfedgeHandle h = first;
    do {
      visit(index(h));
      h = mesh_.opposite_halfedge_handle(mesh_.prev_halfedge_handle(h));
    } while (h != first);
  }

  /// Whether the mesh stays manifold when the start of `h`, which is not on a border, moves to its end.
  bool canCollapse(std::uint32_t h) const;
  /// Moves the start of `h` to its end, and removes the two triangles at `h`. Reads and changes only triangles of the
  /// start and the handles of its neighbours, so that threads may collapse at the same time where the starts have no
  /// neighbour in common. OpenMesh's own collapse also walks around all of them, which takes n^2 steps for a fan.
  void collapse(std::uint32_t h);

  /// The triangles that are left, in their order.
  std::vector<Triangle> triangles() const;

 private:
  static OpenMesh::HalfedgeHandle halfEdge(std::uint32_t h) { return OpenMesh::HalfedgeHandle(static_cast<int>(h)); }
  static OpenMesh::VertexHandle vertex(std::uint32_t v) { return OpenMesh::VertexHandle(static_cast<int>(v)); }
  static std::uint32_t index(OpenMesh::BaseHandle handle) { return static_cast<std::uint32_t>(handle.idx()); }

  OpenMesh::TriConnectivity mesh_;
};

}  // namespace spheretree::builder
