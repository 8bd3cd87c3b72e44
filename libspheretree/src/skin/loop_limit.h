// SPDX-License-Identifier: GPL-3.0-or-later
// The Loop subdivision surface whose limit passes through the vertices of a mesh. Nothing is subdivided: positions and
// normals of the limit come from masks. docs/algorithms/skin/skin.md
// Papers: C. Loop. Smooth subdivision surfaces based on triangles. Master's thesis, University of Utah, 1987;
//         H. Hoppe et al. Piecewise smooth surface reconstruction. SIGGRAPH 1994 (masks of the limit and its tangents).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace spheretree::builder {

/// Neighbours of each vertex, counter-clockwise; empty: the limit has no mask there, and the control vertex is fixed.
using Rings = std::vector<std::vector<std::uint32_t>>;

class LoopLimit {
 public:
  /// `creases`: the two neighbours along the crease that passes smoothly through a vertex; twice the same: none. All
  /// must outlive this. Cost: 60 iterations over the vertices.
  LoopLimit(const std::vector<Eigen::Vector3d>& positions, const Rings& rings, const std::vector<std::array<std::uint32_t, 2>>& creases);

  /// Of a vertex with a ring; unit length.
  Eigen::Vector3d normal(std::uint32_t v) const;

  struct Middle {
    Eigen::Vector3d offset, normal;  // from the middle of the chord [mm]; unit length
  };
  /// Of the edge of two vertices with rings.
  Middle middle(std::uint32_t a, std::uint32_t b) const;

 private:
  void solve(const std::vector<std::array<std::uint32_t, 2>>& creases);
  Eigen::Vector3d subdivided(std::uint32_t v) const;

  const std::vector<Eigen::Vector3d>& at_;
  const Rings& rings_;
  std::vector<Eigen::Vector3d> control_;  // (vertices)
};

}  // namespace spheretree::builder
