// SPDX-License-Identifier: Apache-2.0
// The elastic energy of tetrahedra whose deformation gradients are means: round an edge for what changes shape, round a
// node for what changes volume; a tetrahedron that is nearly flat resists by itself. Equation and papers:
// tissue_solver.h
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
  Eigen::Matrix3d inverse;            // of the edges from corner 0, at rest [1/mm]
  double volume;                      // [mm^3]
};

class SmoothedElements {
 public:
  explicit SmoothedElements(const Tissue& tissue);

  const std::vector<Element>& elements() const { return elements_; }
  double mu() const { return mu_; }

  /// Of displacements `u` [N mm], and its gradient in `out` [N]. Rotations are found from those of the call before, so
  /// the same calls give the same bytes. No allocation. Cost: about 0.3 us a tetrahedron.
  double energy(std::span<const Eigen::Vector3d> u, std::vector<Eigen::Vector3d>& out);
  /// How many are inside out.
  std::size_t inverted(std::span<const Eigen::Vector3d> u) const;
  /// Forgets the rotations.
  void reset();

 private:
  struct Edge {
    double volume = 0;  // its share of the tetrahedra round it [mm^3]
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
  std::vector<double> flat_;                // (element) how far it is below kFlat
};

}  // namespace spheretree::tissue
