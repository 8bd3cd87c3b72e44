// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/scan_surface.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "mesh/mesh_edges.h"

namespace spheretree::builder {

EdgeFaces::EdgeFaces(const TriangleMesh& mesh) : first_(mesh.positions.size() + 1, 0), entries_(3 * mesh.triangles.size()) {
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) ++first_[v + 1];
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) entries_[next[mesh.triangles[t][k]]++] = {mesh.triangles[t][(k + 1) % 3], t};
}

std::uint32_t EdgeFaces::face(std::uint32_t from, std::uint32_t to) const {
  for (std::uint32_t i = first_[from]; i < first_[from + 1]; ++i)
    if (entries_[i].to == to) return entries_[i].face;
  return kNone;
}

VertexNeighbours::VertexNeighbours(const TriangleMesh& mesh)
    : first_(mesh.positions.size() + 1, 0), neighbours_(6 * mesh.triangles.size()) {
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) first_[v + 1] += 2;
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (const Triangle& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      neighbours_[next[t[k]]++] = t[(k + 1) % 3];
      neighbours_[next[t[k]]++] = t[(k + 2) % 3];
    }
}

double meanEdge(const ScanSurface& s) {
  double length = 0;
  std::size_t edges = 0;
  for (std::size_t t = 0; t < s.mesh.triangles.size(); ++t)
    if (!s.is_invented[t]) length += (s.mesh.corner(t, 1) - s.mesh.corner(t, 0)).norm(), ++edges;
  return length > 0 ? length / static_cast<double>(edges) : 1;
}

std::vector<std::uint32_t> trianglesNear(const TriangleMesh& mesh, std::span<const std::uint32_t> loop, int rings) {
  std::vector<char> is_reached(mesh.positions.size(), 0);
  for (const std::uint32_t v : loop) is_reached[v] = 1;
  std::vector<std::uint32_t> near;
  for (int ring = 0; ring < rings; ++ring) {
    near.clear();
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const Triangle& corners = mesh.triangles[t];
      if (is_reached[corners[0]] || is_reached[corners[1]] || is_reached[corners[2]]) near.push_back(t);
    }
    for (const std::uint32_t t : near)
      for (const std::uint32_t v : mesh.triangles[t]) is_reached[v] = 1;
  }
  return near;
}

namespace {

/// Removes triangles until each edge has at most one in each direction; larger triangles are kept.
double dropSurplus(TriangleMesh& mesh) {
  double lost = 0;
  for (bool again = true; again;) {
    const std::vector<Side> sides = sortedSides(mesh);
    std::vector<char> drop(mesh.triangles.size(), 0);
    forEachEdge(sides, [&](std::size_t first, std::size_t last) {
      for (const bool forward : {true, false}) {
        std::uint32_t best = kNone;
        for (std::size_t s = first; s < last; ++s) {
          if (sides[s].forward != forward || drop[sides[s].triangle]) continue;
          if (best == kNone || triangleArea(mesh, sides[s].triangle) > triangleArea(mesh, best)) {
            if (best != kNone) drop[best] = 1;
            best = sides[s].triangle;
          } else {
            drop[sides[s].triangle] = 1;
          }
        }
      }
    });
    std::size_t kept = 0;
    for (std::size_t t = 0; t < drop.size(); ++t) {
      if (drop[t])
        lost += triangleArea(mesh, t);
      else
        mesh.triangles[kept++] = mesh.triangles[t];
    }
    again = kept < drop.size();
    mesh.triangles.resize(kept);
  }
  return lost;
}

/// Where several fans of triangles meet in a vertex, keeps the largest one. Returns the removed area.
double dropPinches(TriangleMesh& mesh) {
  Groups fans(3 * mesh.triangles.size());  // corners are connected across edges
  const std::vector<Side> sides = sortedSides(mesh);
  forEachEdge(sides, [&](std::size_t first, std::size_t last) {
    if (last - first != 2) return;
    const Side &a = sides[first], &b = sides[first + 1];
    const auto corner = [](const Side& s, bool at_low) { return 3 * s.triangle + (s.forward == at_low ? s.corner : (s.corner + 1u) % 3u); };
    fans.join(corner(a, true), corner(b, true));
    fans.join(corner(a, false), corner(b, false));
  });
  std::vector<double> area(3 * mesh.triangles.size(), 0);
  for (std::uint32_t c = 0; c < area.size(); ++c) area[fans.root(c)] += triangleArea(mesh, c / 3);
  std::vector<std::uint32_t> largest(mesh.positions.size(), kNone);
  for (std::uint32_t c = 0; c < area.size(); ++c) {
    std::uint32_t& best = largest[mesh.triangles[c / 3][c % 3]];
    if (best == kNone || area[fans.root(c)] > area[best]) best = fans.root(c);
  }
  double lost = 0;
  std::size_t kept = 0;
  const std::vector<Triangle> before = mesh.triangles;
  for (std::uint32_t t = 0; t < before.size(); ++t) {
    bool stays = true;
    for (std::uint32_t k = 0; k < 3; ++k) stays = stays && fans.root(3 * t + k) == largest[before[t][k]];
    if (stays)
      mesh.triangles[kept++] = before[t];
    else
      lost += triangleArea(mesh, t);
  }
  mesh.triangles.resize(kept);
  return lost;
}

}  // namespace

double makeManifold(TriangleMesh& mesh) {
  double lost = 0;
  for (std::size_t before = 0; before != mesh.triangles.size();) {
    before = mesh.triangles.size();
    lost += dropSurplus(mesh);
    lost += dropPinches(mesh);
  }
  return lost;
}

void dropTriangles(ScanSurface& s, const std::vector<char>& is_dropped) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < is_dropped.size(); ++t)
    if (!is_dropped[t]) s.mesh.triangles[kept++] = s.mesh.triangles[t];
  s.mesh.triangles.resize(kept);
  makeManifold(s.mesh);
  s.is_invented.assign(s.mesh.triangles.size(), 0);
}

}  // namespace spheretree::builder
