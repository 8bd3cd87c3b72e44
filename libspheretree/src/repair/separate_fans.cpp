// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/separate_fans.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <tuple>

#include "mesh/mesh_edges.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

struct FanSide : Side {
  double angle;  // of the triangle around the edge, from low to high
};

/// The sides of one edge in their order around it. There is solid matter between a side that runs forward and the next
/// one at a smaller angle.
std::vector<FanSide> sortedRound(const TriangleMesh& mesh, std::span<const Side> sides) {
  const Vector3d axis = (mesh.positions[sides[0].high()] - mesh.positions[sides[0].low()]).normalized();
  const Vector3d x = axis.unitOrthogonal(), y = axis.cross(x);
  std::vector<FanSide> edge;
  for (const Side& s : sides) {
    const Vector3d to = mesh.positions[mesh.triangles[s.triangle][(s.corner + 2) % 3]] - mesh.positions[s.low()];
    edge.push_back({s, std::atan2(to.dot(y), to.dot(x))});
  }
  std::sort(edge.begin(), edge.end(),
            [](const FanSide& a, const FanSide& b) { return std::tie(a.angle, a.triangle) < std::tie(b.angle, b.triangle); });
  return edge;
}

/// Gives every pair of triangles at an edge of more than two its own vertex in the middle of the edge. Otherwise two
/// fans that share the edge and are connected elsewhere could not be separated.
std::vector<std::uint32_t> splitSharedEdges(RepairSoup& soup) {
  TriangleMesh& mesh = soup.mesh;
  std::vector<std::uint32_t> middles;
  std::vector<char> is_split(mesh.triangles.size(), 0);  // the sides of a cut triangle are outdated: the next round handles them
  const std::vector<Side> sides = sortedSides(mesh);
  forEachEdge(sides, [&](std::size_t first_side, std::size_t last_side) {
    const std::span<const Side> own(sides.data() + first_side, last_side - first_side);
    if (own.size() <= 2 || std::ranges::any_of(own, [&](const Side& s) { return is_split[s.triangle]; })) return;
    const std::vector<FanSide> edge = sortedRound(mesh, own);
    for (std::size_t i = 0; i < edge.size(); ++i) {
      const FanSide &a = edge[i], &b = edge[(i + 1) % edge.size()];
      if (a.forward || !b.forward) continue;
      const auto middle = static_cast<std::uint32_t>(mesh.positions.size());
      mesh.positions.push_back(0.5 * (mesh.positions[a.low()] + mesh.positions[a.high()]));
      middles.push_back(middle);
      for (const FanSide& s : {a, b}) {
        is_split[s.triangle] = 1;
        Triangle& first = mesh.triangles[s.triangle];
        Triangle second = first;
        first[(s.corner + 1) % 3] = middle;
        second[s.corner] = middle;
        mesh.triangles.push_back(second);
        soup.source.push_back(soup.source[s.triangle]);
      }
    }
  });
  return middles;
}

/// Joins the corners of two triangles at both ends of an edge.
void join(const TriangleMesh& mesh, const Side& a, const Side& b, Groups& fans) {
  for (const std::uint32_t v : {a.low(), a.high()}) {
    const auto cornerOf = [&](const Side& s) {
      return 3 * s.triangle + (mesh.triangles[s.triangle][s.corner] == v ? s.corner : (s.corner + 1u) % 3);
    };
    fans.join(cornerOf(a), cornerOf(b));
  }
}

/// Moves the copies into their solid by `distance`, by less where edges are short, so that no two of them coincide.
void moveInward(TriangleMesh& mesh, const std::vector<std::uint32_t>& copies, double distance, SeparatedFans& result) {
  std::vector<Vector3d> normal(mesh.positions.size(), Vector3d::Zero());
  std::vector<double> shortest(mesh.positions.size(), distance * 100);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vector3d face = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).normalized();
    for (int k = 0; k < 3; ++k) {
      const Vector3d u = mesh.corner(t, (k + 1) % 3) - mesh.corner(t, k), w = mesh.corner(t, (k + 2) % 3) - mesh.corner(t, k);
      const std::uint32_t v = mesh.triangles[t][static_cast<std::size_t>(k)];
      normal[v] += std::atan2(u.cross(w).norm(), u.dot(w)) * face;
      shortest[v] = std::min({shortest[v], u.norm(), w.norm()});
    }
  }
  std::vector<char> is_copy(mesh.positions.size(), 0);
  for (const std::uint32_t v : copies) is_copy[v] = 1;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    result.is_moved[t] = std::ranges::any_of(mesh.triangles[t], [&](std::uint32_t v) { return is_copy[v] != 0; });
  for (const std::uint32_t v : copies) {
    const Vector3d move = -std::min(distance, 0.01 * shortest[v]) * normal[v].normalized();
    if (!move.allFinite()) continue;
    mesh.positions[v] += move;
    result.moved = std::max(result.moved, move.norm());
  }
}

}  // namespace

SeparatedFans separateFans(RepairSoup& soup, double distance) {
  TriangleMesh& mesh = soup.mesh;
  if (hasDuplicates(mesh)) return {0, 0, std::vector<char>(mesh.triangles.size(), 0)};  // they would be split without end
  std::vector<std::uint32_t> copies;                                                    // the vertices to move
  for (;;) {  // an edge waits for a neighbour that is split in the same round; each round leaves fewer shared edges
    const std::vector<std::uint32_t> middles = splitSharedEdges(soup);
    if (middles.empty()) break;
    copies.insert(copies.end(), middles.begin(), middles.end());
  }
  const std::size_t corners = 3 * mesh.triangles.size();
  Groups fans(corners);
  const std::vector<Side> sides = sortedSides(mesh);
  forEachEdge(sides, [&](std::size_t first, std::size_t last) {
    if (last - first == 2) join(mesh, sides[first], sides[first + 1], fans);
  });

  SeparatedFans result;
  result.copies = copies.size();
  result.is_moved.assign(mesh.triangles.size(), 0);
  const std::size_t before = mesh.positions.size();
  std::vector<std::uint32_t> first_fan(before, kNone), vertex_of(corners, kNone);  // of the corner that is the fan's root
  std::vector<char> is_shared(before, 0);
  for (std::uint32_t c = 0; c < corners; ++c) {
    const std::uint32_t v = mesh.triangles[c / 3][c % 3], root = fans.root(c);
    if (first_fan[v] == kNone) first_fan[v] = root;
    if (first_fan[v] != root) is_shared[v] = 1;
  }
  for (std::uint32_t c = 0; c < corners; ++c) {
    const std::uint32_t v = mesh.triangles[c / 3][c % 3], root = fans.root(c);
    if (v >= before || !is_shared[v]) continue;
    if (vertex_of[root] == kNone) {
      vertex_of[root] = first_fan[v] == root ? v : static_cast<std::uint32_t>(mesh.positions.size());
      if (vertex_of[root] != v) mesh.positions.push_back(Vector3d(mesh.positions[v])), ++result.copies;
      copies.push_back(vertex_of[root]);
    }
    mesh.triangles[c / 3][c % 3] = vertex_of[root];
  }
  if (copies.empty()) return result;
  moveInward(mesh, copies, distance, result);
  return result;
}

}  // namespace spheretree::builder
