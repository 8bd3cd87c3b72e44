// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/half_edges.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <limits>
#include <numeric>
#include <stdexcept>

namespace spheretree::builder {

namespace {

constexpr std::uint32_t kNoTwin = std::numeric_limits<std::uint32_t>::max();

void require(bool is_so) {
  if (!is_so) throw std::invalid_argument("simplify: the mesh is not manifold");
}

/// Side 3 t + k runs from corner k of triangle t to the next corner.
std::uint32_t next(std::uint32_t side) { return side % 3 == 2 ? side - 2 : side + 1; }
std::uint32_t previous(std::uint32_t side) { return side % 3 == 0 ? side + 2 : side - 1; }

struct Sides {
  std::vector<std::uint32_t> from;   // (sides) vertex
  std::vector<std::uint32_t> begin;  // (vertices + 1) where the sides from there begin in `around`
  std::vector<std::uint32_t> around;
  std::vector<std::uint32_t> twin;  // (sides) the one that runs the other way; kNoTwin: on a border
};

Sides sidesOf(std::span<const Triangle> triangles, std::size_t vertices) {
  Sides s;
  s.from.reserve(3 * triangles.size());
  s.begin.assign(vertices + 1, 0);
  for (const Triangle& t : triangles)
    for (const std::uint32_t v : t) s.from.push_back(v), ++s.begin[v];
  std::partial_sum(s.begin.begin(), s.begin.end(), s.begin.begin());
  s.around.resize(s.from.size());
  for (std::uint32_t side = 0; side < s.from.size(); ++side) s.around[--s.begin[s.from[side]]] = side;
  s.twin.assign(s.from.size(), kNoTwin);
  // The sides into and out of each vertex are those of its triangles; searched at the end that has fewer.
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(s.from.size())), [&](const auto& range) {
    for (std::uint32_t side = range.begin(); side < range.end(); ++side) {
      const std::uint32_t a = s.from[side], b = s.from[next(side)];
      require(a != b);
      const bool at_a = s.begin[a + 1] - s.begin[a] <= s.begin[b + 1] - s.begin[b];
      const std::uint32_t at = at_a ? a : b;
      std::uint32_t same = 0, opposite = 0;
      for (std::uint32_t i = s.begin[at]; i < s.begin[at + 1]; ++i) {
        const std::uint32_t out = s.around[i], in = previous(out), there = at_a ? out : in, back = at_a ? in : out;
        if (s.from[there] == a && s.from[next(there)] == b) ++same;
        if (s.from[back] == b && s.from[next(back)] == a) s.twin[side] = back, ++opposite;
      }
      require(same == 1 && opposite <= 1);
    }
  });
  return s;
}

}  // namespace

HalfEdges::HalfEdges(std::span<const Triangle> triangles, std::size_t vertices) {
  const Sides sides = sidesOf(triangles, vertices);
  std::vector<std::uint32_t> place(sides.from.size());  // (sides) number of the half-edge
  std::uint32_t edges = 0;
  for (std::uint32_t side = 0; side < place.size(); ++side) {
    if (sides.twin[side] < side) continue;
    if (sides.twin[side] != kNoTwin) place[sides.twin[side]] = 2 * edges + 1;
    place[side] = 2 * edges++;
  }
  mesh_.resize(vertices, edges, triangles.size());
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(place.size())), [&](const auto& range) {
    for (std::uint32_t side = range.begin(); side < range.end(); ++side) {
      const OpenMesh::HalfedgeHandle h = halfEdge(place[side]);
      const OpenMesh::FaceHandle face(static_cast<int>(side / 3));
      mesh_.set_vertex_handle(h, vertex(sides.from[next(side)]));
      mesh_.set_face_handle(h, face);
      mesh_.set_next_halfedge_handle(h, halfEdge(place[next(side)]));
      if (side % 3 == 0) mesh_.set_halfedge_handle(face, h);
      if (side == sides.around[sides.begin[sides.from[side]]]) mesh_.set_halfedge_handle(vertex(sides.from[side]), h);
    }
  });
  // A border has its own half-edges, each followed by the one that begins where it ends.
  std::vector<OpenMesh::HalfedgeHandle> border;
  for (std::uint32_t side = 0; side < place.size(); ++side) {
    if (sides.twin[side] != kNoTwin) continue;
    const OpenMesh::HalfedgeHandle h = border.emplace_back(mesh_.opposite_halfedge_handle(halfEdge(place[side])));
    mesh_.set_vertex_handle(h, vertex(sides.from[side]));
    require(!isBorder(sides.from[next(side)]));  // one gap around each vertex
    mesh_.set_halfedge_handle(vertex(sides.from[next(side)]), h);
  }
  for (const OpenMesh::HalfedgeHandle h : border) mesh_.set_next_halfedge_handle(h, mesh_.halfedge_handle(mesh_.to_vertex_handle(h)));
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(vertices)), [&](const auto& range) {
    for (std::uint32_t v = range.begin(); v < range.end(); ++v) {
      if (isIsolated(v)) continue;
      std::uint32_t count = 0;
      visitFrom(v, [&](std::uint32_t h) { count += !mesh_.is_boundary(halfEdge(h)); });
      require(count == sides.begin[v + 1] - sides.begin[v]);  // one fan
    }
  });
  mesh_.request_vertex_status();
  mesh_.request_edge_status();
  mesh_.request_face_status();
}

std::vector<Triangle> HalfEdges::triangles() const {
  std::vector<Triangle> out;
  for (std::size_t t = 0; t < mesh_.n_faces(); ++t) {
    const OpenMesh::FaceHandle face(static_cast<int>(t));
    if (mesh_.status(face).deleted()) continue;
    const std::uint32_t h = index(mesh_.halfedge_handle(face)), following = index(mesh_.next_halfedge_handle(halfEdge(h)));
    out.push_back({from(h), to(h), to(following)});
  }
  return out;
}

}  // namespace spheretree::builder
