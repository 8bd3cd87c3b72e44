// SPDX-License-Identifier: GPL-3.0-or-later
// A scan surface that is a field of heights over a square, and what is known of the solids under it.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

#include "mesh/mesh_edges.h"
#include "split/scan_surface.h"

namespace spheretree::test {

/// z = height(x, y) over [-half, half]^2, triangles of side `edge`, without those whose midpoint does not satisfy
/// `is_there`. All of it is gum.
inline builder::ScanSurface fieldOf(
    double half, double edge, const std::function<double(double, double)>& height,
    const std::function<bool(const Eigen::Vector3d&)>& is_there = [](const Eigen::Vector3d&) { return true; }) {
  builder::ScanSurface s;
  const auto n = static_cast<std::uint32_t>(std::lround(2 * half / edge));
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= n; ++i) {
      const double x = -half + edge * i, y = -half + edge * j;
      s.mesh.positions.push_back({x, y, height(x, y)});
    }
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = c - 1;
      for (const Triangle& t : {Triangle{a, b, c}, Triangle{a, c, d}})
        if (is_there((s.mesh.positions[t[0]] + s.mesh.positions[t[1]] + s.mesh.positions[t[2]]) / 3)) s.mesh.triangles.push_back(t);
    }
  s.vertex_region.assign(s.mesh.positions.size(), builder::kGumRegion);
  s.region.assign(s.mesh.triangles.size(), builder::kGumRegion);
  s.is_invented.assign(s.mesh.triangles.size(), 0);
  s.region_label = {0};
  return s;
}

/// Gives the triangles whose midpoint satisfies `is_in` to a new region.
inline void addRegion(builder::ScanSurface& s, const std::function<bool(const Eigen::Vector3d&)>& is_in) {
  const auto region = static_cast<std::int32_t>(s.region_label.size());
  s.region_label.push_back(10 + region);
  for (std::size_t t = 0; t < s.mesh.triangles.size(); ++t)
    if (is_in((s.mesh.corner(t, 0) + s.mesh.corner(t, 1) + s.mesh.corner(t, 2)) / 3)) s.region[t] = region;
}

/// Volume between the triangles that satisfy `counts` and the plane z = 0; exact.
inline double volumeUnder(const TriangleMesh& mesh, const std::function<bool(std::size_t)>& counts) {
  double volume = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!counts(t)) continue;
    const Eigen::Vector3d a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    volume += (b - a).cross(c - a).z() / 2 * (a.z() + b.z() + c.z()) / 3;
  }
  return volume;
}

/// True if along every edge as many triangles run one way as the other.
inline bool isClosed(const TriangleMesh& mesh) {
  bool closed = true;
  const std::vector<builder::Side> sides = builder::sortedSides(mesh);
  builder::forEachEdge(sides, [&](std::size_t first, std::size_t last) {
    int balance = 0;
    for (std::size_t s = first; s < last; ++s) balance += sides[s].forward ? 1 : -1;
    closed = closed && balance == 0;
  });
  return closed;
}

}  // namespace spheretree::test
