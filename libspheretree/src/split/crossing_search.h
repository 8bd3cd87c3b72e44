// SPDX-License-Identifier: GPL-3.0-or-later
// Which triangles of a growing surface new ones cross. Units: mm.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Keeps triangles in a grid of cubes. Crossing is decided exactly, as in mesh/crossing_triangles.h.
class CrossingSearch {
 public:
  /// `cell`: side of a cube [mm], a few edges of the triangles; > 0. `positions` may grow; those of triangles that were
  /// added stay.
  CrossingSearch(const std::vector<Eigen::Vector3d>& positions, double cell) : positions_(positions), cell_(cell) {}

  void add(const Triangle& triangle);
  const std::vector<Triangle>& triangles() const { return triangles_; }

  /// Pairs of which one is of `fresh`: index of the other one, and place in `fresh` after all that were added. Sorted.
  /// Cost: that of the triangles in the same cubes.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> against(const std::vector<Triangle>& fresh) const;

 private:
  using Cell = std::array<std::int64_t, 3>;
  Eigen::AlignedBox3d boxOf(const Triangle& triangle) const;
  Cell cellOf(const Eigen::Vector3d& p) const;
  static double cellCount(const Cell& low, const Cell& high);

  const std::vector<Eigen::Vector3d>& positions_;
  double cell_;
  std::vector<Triangle> triangles_;
  std::vector<Eigen::AlignedBox3d> boxes_;
  std::map<Cell, std::vector<std::uint32_t>> in_cell_;
  std::vector<std::uint32_t> large_;  // triangles that reach over too many cubes to stand in each
};

}  // namespace spheretree::builder
