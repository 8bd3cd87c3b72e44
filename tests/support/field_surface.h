// SPDX-License-Identifier: GPL-3.0-or-later
// A scan surface that is a field of heights over a square.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>

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

}  // namespace spheretree::test
