// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/separate_fans.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kSplitRounds =
    20;  // rounds of splits: a triangle needs at most one for each shared edge, but coincident triangles would need infinitely many

struct FanSide {
  std::uint32_t low, high, triangle;
  std::uint32_t corner;  // the edge runs from this corner to the next
  bool forward;
  double angle = 0;  // of the triangle around the edge, from low to high
};

std::uint32_t rootOf(std::vector<std::uint32_t>& parent, std::uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/// The sides of each edge, in the order of the edges.
std::vector<std::vector<FanSide>> sidesOfEdges(const TriangleMesh& mesh) {
  std::vector<FanSide> sides;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), t, k, a < b});
    }
  std::sort(sides.begin(), sides.end(),
            [](const FanSide& a, const FanSide& b) { return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle); });
  std::vector<std::vector<FanSide>> edges;
  for (std::size_t i = 0; i < sides.size();) {
    edges.emplace_back();
    for (const FanSide first = sides[i]; i < sides.size() && sides[i].low == first.low && sides[i].high == first.high; ++i)
      edges.back().push_back(sides[i]);
  }
  return edges;
}

/// Sorts the sides of an edge around it. There is solid matter between a side that runs forward and the next one at a
/// smaller angle.
void sortRound(const TriangleMesh& mesh, std::vector<FanSide>& edge) {
  const Vector3d axis = (mesh.positions[edge[0].high] - mesh.positions[edge[0].low]).normalized();
  const Vector3d x = axis.unitOrthogonal(), y = axis.cross(x);
  for (FanSide& s : edge) {
    const Vector3d to = mesh.positions[mesh.triangles[s.triangle][(s.corner + 2) % 3]] - mesh.positions[s.low];
    s.angle = std::atan2(to.dot(y), to.dot(x));
  }
  std::sort(edge.begin(), edge.end(),
            [](const FanSide& a, const FanSide& b) { return std::tie(a.angle, a.triangle) < std::tie(b.angle, b.triangle); });
}

/// Gives every pair of triangles at an edge of more than two its own vertex in the middle of the edge. Otherwise two
/// fans that share the edge and are connected elsewhere could not be separated.
std::vector<std::uint32_t> splitSharedEdges(RepairSoup& soup) {
  TriangleMesh& mesh = soup.mesh;
  std::vector<std::uint32_t> middles;
  std::vector<char> is_split(mesh.triangles.size(), 0);  // the sides of a cut triangle are outdated: the next round handles them
  for (std::vector<FanSide>& edge : sidesOfEdges(mesh)) {
    if (edge.size() <= 2 || std::ranges::any_of(edge, [&](const FanSide& s) { return is_split[s.triangle]; })) continue;
    sortRound(mesh, edge);
    for (std::size_t i = 0; i < edge.size(); ++i) {
      const FanSide &a = edge[i], &b = edge[(i + 1) % edge.size()];
      if (a.forward || !b.forward) continue;
      const auto middle = static_cast<std::uint32_t>(mesh.positions.size());
      mesh.positions.push_back(0.5 * (mesh.positions[a.low] + mesh.positions[a.high]));
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
  }
  return middles;
}

/// Joins the corners of two triangles at both ends of an edge.
void join(const TriangleMesh& mesh, const FanSide& a, const FanSide& b, std::vector<std::uint32_t>& parent) {
  for (const std::uint32_t v : {a.low, a.high}) {
    const auto cornerOf = [&](const FanSide& s) {
      return 3 * s.triangle + (mesh.triangles[s.triangle][s.corner] == v ? s.corner : (s.corner + 1) % 3);
    };
    const std::uint32_t i = rootOf(parent, cornerOf(a)), j = rootOf(parent, cornerOf(b));
    parent[std::max(i, j)] = std::min(i, j);
  }
}

}  // namespace

SeparatedFans separateFans(RepairSoup& soup, double distance) {
  TriangleMesh& mesh = soup.mesh;
  std::vector<std::uint32_t> copies;  // the vertices to move
  for (int round = 0; round < kSplitRounds; ++round) {
    const std::vector<std::uint32_t> middles = splitSharedEdges(soup);
    if (middles.empty()) break;
    copies.insert(copies.end(), middles.begin(), middles.end());
  }
  std::vector<std::uint32_t> parent;
  for (std::uint32_t corner = 0; corner < 3 * mesh.triangles.size(); ++corner) parent.push_back(corner);
  for (const std::vector<FanSide>& edge : sidesOfEdges(mesh))
    if (edge.size() == 2) join(mesh, edge[0], edge[1], parent);

  SeparatedFans result;
  result.copies = copies.size();
  result.is_moved.assign(mesh.triangles.size(), 0);
  constexpr std::uint32_t kNone = 0xffffffffu;
  const std::size_t before = mesh.positions.size();
  std::vector<std::uint32_t> first_fan(before, kNone), vertex_of(parent.size(), kNone);  // of the corner that is the fan's root
  std::vector<char> is_shared(before, 0);
  for (std::uint32_t c = 0; c < parent.size(); ++c) {
    const std::uint32_t v = mesh.triangles[c / 3][c % 3], root = rootOf(parent, c);
    if (first_fan[v] == kNone) first_fan[v] = root;
    if (first_fan[v] != root) is_shared[v] = 1;
  }
  for (std::uint32_t c = 0; c < parent.size(); ++c) {
    const std::uint32_t v = mesh.triangles[c / 3][c % 3], root = rootOf(parent, c);
    if (v >= before || !is_shared[v]) continue;
    if (vertex_of[root] == kNone) {
      vertex_of[root] = first_fan[v] == root ? v : static_cast<std::uint32_t>(mesh.positions.size());
      if (vertex_of[root] != v) mesh.positions.push_back(Vector3d(mesh.positions[v])), ++result.copies;
      copies.push_back(vertex_of[root]);
    }
    mesh.triangles[c / 3][c % 3] = vertex_of[root];
  }
  if (copies.empty()) return result;
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
  return result;
}

}  // namespace spheretree::builder
