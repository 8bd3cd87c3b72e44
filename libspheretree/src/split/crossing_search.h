// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the triangles of a growing surface that cross new triangles. Units: mm.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Stores triangles in a grid of cubes. Crossing is decided exactly, as in mesh/crossing_triangles.h.
class CrossingSearch {
 public:
  /// `edge`: of the triangles, about [mm]; > 0. `positions` may grow, but the positions of added
  /// triangles must not change.
  CrossingSearch(const std::vector<Eigen::Vector3d>& positions, double edge);

  void add(const Triangle& triangle);
  double cell() const { return cell_; }  // side of a cube [mm]
  const std::vector<Triangle>& triangles() const { return triangles_; }

  /// Crossing pairs in which one triangle is in `fresh`. A pair has the index of the other triangle and the index of
  /// the fresh one, counted after all added triangles. Sorted. Cost: proportional to the triangles in the same cubes.
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
  std::vector<std::uint32_t> large_;  // triangles that overlap too many cubes to be stored in each
};

}  // namespace spheretree::builder
