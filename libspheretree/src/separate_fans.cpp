// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/separate_fans.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

struct Side {
  std::uint32_t low, high, triangle;
  std::uint32_t corner;  // the edge runs from this corner to the next
  bool forward;
  double angle = 0;  // of the triangle about the edge, from low to high
};

std::uint32_t rootOf(std::vector<std::uint32_t>& parent, std::uint32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

/// Joins the two triangles' corners at both ends of an edge.
void join(const TriangleMesh& mesh, const Side& a, const Side& b, std::vector<std::uint32_t>& parent) {
  for (const std::uint32_t v : {a.low, a.high}) {
    const auto cornerOf = [&](const Side& s) {
      return 3 * s.triangle + (mesh.triangles[s.triangle][s.corner] == v ? s.corner : (s.corner + 1) % 3);
    };
    const std::uint32_t i = rootOf(parent, cornerOf(a)), j = rootOf(parent, cornerOf(b));
    parent[std::max(i, j)] = std::min(i, j);
  }
}

/// About the edge, solid matter lies before a triangle that runs forward along it (at smaller angles) and after one that runs back.
void joinRound(const TriangleMesh& mesh, std::vector<Side>& round, std::vector<std::uint32_t>& parent) {
  if (round.size() > 2) {
    const Vector3d axis = (mesh.positions[round[0].high] - mesh.positions[round[0].low]).normalized();
    const Vector3d x = axis.unitOrthogonal(), y = axis.cross(x);
    for (Side& s : round) {
      const Vector3d to = mesh.positions[mesh.triangles[s.triangle][(s.corner + 2) % 3]] - mesh.positions[s.low];
      s.angle = std::atan2(to.dot(y), to.dot(x));
    }
    std::sort(round.begin(), round.end(),
              [](const Side& a, const Side& b) { return std::tie(a.angle, a.triangle) < std::tie(b.angle, b.triangle); });
  }
  for (std::size_t i = 0; i < round.size(); ++i) {
    const Side &a = round[i], &b = round[(i + 1) % round.size()];
    if (!a.forward && b.forward) join(mesh, a, b, parent);
  }
}

}  // namespace

SeparatedFans separateFans(TriangleMesh& mesh, double distance) {
  std::vector<Side> sides;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), t, k, a < b});
    }
  std::sort(sides.begin(), sides.end(),
            [](const Side& a, const Side& b) { return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle); });
  std::vector<std::uint32_t> parent(3 * mesh.triangles.size());
  std::iota(parent.begin(), parent.end(), 0u);
  std::vector<Side> round;
  for (std::size_t i = 0; i < sides.size();) {
    round.clear();
    for (const Side first = sides[i]; i < sides.size() && sides[i].low == first.low && sides[i].high == first.high; ++i)
      round.push_back(sides[i]);
    joinRound(mesh, round, parent);
  }

  SeparatedFans result;
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
  std::vector<std::uint32_t> copies;  // the vertices to move
  for (std::uint32_t c = 0; c < parent.size(); ++c) {
    const std::uint32_t v = mesh.triangles[c / 3][c % 3], root = rootOf(parent, c);
    if (v >= before || !is_shared[v]) continue;
    if (vertex_of[root] == kNone) {
      vertex_of[root] = first_fan[v] == root ? v : static_cast<std::uint32_t>(mesh.positions.size());
      if (vertex_of[root] != v) mesh.positions.push_back(Vector3d(mesh.positions[v])), ++result.copies;
      copies.push_back(vertex_of[root]);
    }
    mesh.triangles[c / 3][c % 3] = vertex_of[root];
    result.is_moved[c / 3] = 1;
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
  for (const std::uint32_t v : copies) {
    const Vector3d move = -std::min(distance, 0.01 * shortest[v]) * normal[v].normalized();
    if (!move.allFinite()) continue;
    mesh.positions[v] += move;
    result.moved = std::max(result.moved, move.norm());
  }
  return result;
}

}  // namespace spheretree::builder
