// SPDX-License-Identifier: Apache-2.0
// The elastic energy of tetrahedra whose deformation gradients are averaged: over the tetrahedra around an edge in the
// term of the shape (mu), around a node in the term of the volume (lambda). A nearly flat tetrahedron has an additional
// energy of its own. Equation and papers: tissue_solver.h
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "spheretree/core/tissue.h"

namespace spheretree::tissue {

struct Element {
  std::array<std::uint32_t, 4> corner;
  std::array<std::uint32_t, 6> edge;  // indices of its edges
  Eigen::Matrix3d inverse;            // inverse of the matrix of the edges from corner 0, at rest [1/mm]
  double volume;                      // [mm^3]
};

class SmoothedElements {
 public:
  explicit SmoothedElements(const Tissue& tissue);

  const std::vector<Element>& elements() const { return elements_; }
  double mu() const { return mu_; }

  /// Energy of the displacements `u` [N mm]; `out` receives its gradient [N]. Rotations are computed from those of the
  /// previous call, so the same sequence of calls gives the same bytes. No allocation. Cost: about 0.3 us a
  /// tetrahedron.
  double energy(std::span<const Eigen::Vector3d> u, std::vector<Eigen::Vector3d>& out);
  /// Number of inverted tetrahedra.
  std::size_t inverted(std::span<const Eigen::Vector3d> u) const;
  /// Resets the rotations.
  void reset();

 private:
  struct Edge {
    double volume = 0;  // share of the volume of the tetrahedra around it [mm^3]
    Eigen::Quaterniond turn{1, 0, 0, 0};
    Eigen::Matrix3d gradient, stress;
  };
  struct Node {
    double volume = 0, ratio = 0, pressure = 0;
  };

  Eigen::Matrix3d gradientOf(const Element& e, std::span<const Eigen::Vector3d> u) const;

  double lambda_, mu_, barrier_;  // [N/mm^2]
  std::vector<Eigen::Vector3d> rest_;
  std::vector<Element> elements_;
  std::vector<Edge> edges_;
  std::vector<Node> nodes_;
  std::vector<Eigen::Matrix3d> gradients_;  // (element)
  std::vector<double> flat_;                // (element) by how much its volume ratio is below kFlat
};

}  // namespace spheretree::tissue
