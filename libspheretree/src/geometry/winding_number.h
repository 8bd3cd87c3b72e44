// SPDX-License-Identifier: GPL-3.0-or-later
// The winding number of a surface around a point: an integer for a closed surface (1 inside, 0 outside), fractional for
// an open one.
//
// Papers: A. Jacobson, L. Kavan, O. Sorkine-Hornung. Robust inside-outside segmentation using generalized winding
//         numbers. ACM TOG 32(4), 2013: the sum of solid angles. G. Barill et al. Fast winding numbers for soups and
//         clouds. ACM TOG 37(4), 2018: a far cluster of triangles is replaced by its area vector at its centre.
// Deterministic. Any number of threads may query it.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

class WindingNumber {
 public:
  /// O(n log n). Copies what it needs.
  explicit WindingNumber(const TriangleMesh& mesh);

  /// The winding number around `p`, without the triangles `leave_out`. Its error is about 0.02 for each body that
  /// surrounds `p`. On a triangle that is left out it is the mean of the numbers on its two sides. Cost: O(log n) far
  /// from the surface.
  double at(const Eigen::Vector3d& p, std::span<const std::uint32_t> leave_out = {}) const;

 private:
  struct Node {
    Eigen::Vector3d centre, area_vector;  // [mm], [mm^2]
    double radius;                        // about the centre, of all its triangles [mm]
    std::uint32_t first, count;           // in order_
    std::uint32_t second_child;           // the first child follows its parent; 0: leaf
  };
  std::uint32_t build(std::uint32_t first, std::uint32_t count);

  std::vector<std::array<Eigen::Vector3d, 3>> corners_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace spheretree::builder
