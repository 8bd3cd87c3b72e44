// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/half_edges.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
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

bool HalfEdges::canCollapse(std::uint32_t h) const {
  const std::uint32_t start = from(h), end = to(h);
  // The two ends may have no neighbours in common but the third corners of the triangles at `h`.
  const OpenMesh::HalfedgeHandle there = halfEdge(h), back = mesh_.opposite_halfedge_handle(there);
  const std::uint32_t left = to(index(mesh_.next_halfedge_handle(there))), right = to(index(mesh_.next_halfedge_handle(back)));
  if (left == right) return false;
  std::vector<std::uint32_t> others;
  visitFrom(start, [&](std::uint32_t out) {
    if (const std::uint32_t v = to(out); v != end && v != left && v != right) others.push_back(v);
  });
  std::uint32_t around_end = 0;
  bool are_apart = true;
  visitFrom(end, [&](std::uint32_t out) {
    ++around_end;
    are_apart = are_apart && std::find(others.begin(), others.end(), to(out)) == others.end();
  });
  return are_apart && !(others.empty() && around_end == 3);  // a tetrahedron would become flat
}

void HalfEdges::collapse(std::uint32_t h) {
  const OpenMesh::HalfedgeHandle there = halfEdge(h), back = mesh_.opposite_halfedge_handle(there);
  const OpenMesh::VertexHandle start = mesh_.from_vertex_handle(there), end = mesh_.to_vertex_handle(there);
  visitFrom(index(start), [&](std::uint32_t out) { mesh_.set_vertex_handle(mesh_.opposite_halfedge_handle(halfEdge(out)), end); });
  // Of the two sides of a removed triangle that become one, `kept` takes the place of `gone` in the triangle beyond.
  const auto join = [&](OpenMesh::HalfedgeHandle kept, OpenMesh::HalfedgeHandle gone) {
    const OpenMesh::HalfedgeHandle following = mesh_.next_halfedge_handle(gone), before = mesh_.prev_halfedge_handle(gone);
    const OpenMesh::FaceHandle face = mesh_.face_handle(gone);
    mesh_.status(mesh_.face_handle(kept)).set_deleted(true);
    mesh_.status(mesh_.edge_handle(gone)).set_deleted(true);
    mesh_.set_face_handle(kept, face);
    mesh_.set_next_halfedge_handle(kept, following);
    mesh_.set_next_halfedge_handle(before, kept);
    if (mesh_.halfedge_handle(face) == gone) mesh_.set_halfedge_handle(face, kept);
  };
  const OpenMesh::HalfedgeHandle left = mesh_.next_halfedge_handle(there), right = mesh_.prev_halfedge_handle(back);
  const OpenMesh::HalfedgeHandle left_gone = mesh_.prev_halfedge_handle(there), right_gone = mesh_.next_halfedge_handle(back);
  // A vertex on a border keeps its half-edge there: that is none of the start's triangles.
  if (mesh_.halfedge_handle(end) == back) mesh_.set_halfedge_handle(end, left);
  const OpenMesh::VertexHandle left_tip = mesh_.to_vertex_handle(left), right_tip = mesh_.to_vertex_handle(right_gone);
  if (mesh_.halfedge_handle(left_tip) == left_gone) mesh_.set_halfedge_handle(left_tip, mesh_.opposite_halfedge_handle(left));
  if (mesh_.halfedge_handle(right_tip) == mesh_.opposite_halfedge_handle(right_gone)) mesh_.set_halfedge_handle(right_tip, right);
  join(left, mesh_.opposite_halfedge_handle(left_gone));
  join(right, mesh_.opposite_halfedge_handle(right_gone));
  mesh_.status(mesh_.edge_handle(there)).set_deleted(true);
  mesh_.set_isolated(start);
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
