// SPDX-License-Identifier: Apache-2.0
#include "simplify.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>

namespace spheretree::samples {
namespace {

using Eigen::Vector3d;

Vector3d normalOf(const TriangleMesh& mesh, const Triangle& t) {
  return (mesh.positions[t[1]] - mesh.positions[t[0]]).cross(mesh.positions[t[2]] - mesh.positions[t[0]]);
}

// Returns true if the edge a-b may collapse to its midpoint: its ends share just the two opposite corners, and no
// triangle rotates by more than 60 degrees.
bool canCollapse(TriangleMesh& mesh, const std::vector<std::vector<std::uint32_t>>& around, std::uint32_t a, std::uint32_t b) {
  const auto neighbours = [&](std::uint32_t v) {
    std::set<std::uint32_t> all;
    for (const std::uint32_t t : around[v]) all.insert(mesh.triangles[t].begin(), mesh.triangles[t].end());
    all.erase(v);
    return all;
  };
  const std::set<std::uint32_t> near_a = neighbours(a), near_b = neighbours(b);
  std::vector<std::uint32_t> shared;
  std::set_intersection(near_a.begin(), near_a.end(), near_b.begin(), near_b.end(), std::back_inserter(shared));
  if (shared.size() != 2) return false;
  const Vector3d middle = (mesh.positions[a] + mesh.positions[b]) / 2;
  for (const std::uint32_t end : {a, b}) {
    for (const std::uint32_t t : around[end]) {
      const Triangle& triangle = mesh.triangles[t];
      if (std::count(triangle.begin(), triangle.end(), a) + std::count(triangle.begin(), triangle.end(), b) == 2) continue;
      const Vector3d before = normalOf(mesh, triangle), was = mesh.positions[end];
      mesh.positions[end] = middle;
      const Vector3d after = normalOf(mesh, triangle);
      mesh.positions[end] = was;
      if (after.dot(before) < 0.5 * after.norm() * before.norm()) return false;
    }
  }
  return true;
}

}  // namespace

void collapseTo(TriangleMesh& mesh, std::size_t triangles) {
  if (mesh.triangles.size() < triangles || (mesh.triangles.size() - triangles) % 2 != 0)
    throw std::invalid_argument("collapseTo: " + std::to_string(mesh.triangles.size()) + " triangles cannot become " +
                                std::to_string(triangles));
  while (mesh.triangles.size() > triangles) {
    std::vector<std::vector<std::uint32_t>> around(mesh.positions.size());
    struct Edge {
      double length2;
      std::uint32_t a, b;
      bool operator<(const Edge& other) const { return std::tie(length2, a, b) < std::tie(other.length2, other.a, other.b); }
    };
    std::vector<Edge> edges;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
        around[a].push_back(t);
        if (a < b) edges.push_back({(mesh.positions[a] - mesh.positions[b]).squaredNorm(), a, b});
      }
    }
    std::sort(edges.begin(), edges.end());
    const auto edge = std::find_if(edges.begin(), edges.end(), [&](const Edge& e) { return canCollapse(mesh, around, e.a, e.b); });
    if (edge == edges.end()) throw std::invalid_argument("collapseTo: no edge is left that can be collapsed");
    mesh.positions[edge->a] = (mesh.positions[edge->a] + mesh.positions[edge->b]) / 2;
    std::vector<Triangle> kept;
    for (Triangle t : mesh.triangles) {
      for (std::uint32_t& v : t) v = v == edge->b ? edge->a : v;
      if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) kept.push_back(t);
    }
    mesh.triangles = std::move(kept);
    // The last vertex takes the place of the removed one.
    const auto last = static_cast<std::uint32_t>(mesh.positions.size() - 1);
    mesh.positions[edge->b] = mesh.positions[last];
    mesh.positions.pop_back();
    for (Triangle& t : mesh.triangles)
      for (std::uint32_t& v : t) v = v == last ? edge->b : v;
  }
}

}  // namespace spheretree::samples
