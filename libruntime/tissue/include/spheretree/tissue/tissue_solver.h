// SPDX-License-Identifier: Apache-2.0
// Large deformation of soft tissue: the static shape under forces, where tetrahedra rotate and stretch. There is no
// inertia and no time: the solver minimises   elastic energy(u) - f . u   over the displacements u of the nodes.
//
// Energy per volume: mu |F - R|^2 + lambda / 2 (J - 1)^2, with the deformation gradient F, its rotation R and the
// volume ratio J. F is a mean over the tetrahedra around an edge, and J one over the tetrahedra around a node, since
// plain linear tetrahedra are far too stiff in bending and at nearly constant volume (the tests have figures). A
// tetrahedron with less than 30 % of its volume gets an additional energy, which grows as the square of the missing
// volume and keeps it from being inverted.
// Each iteration solves with the matrix of the shape at rest, which is factorised once, improves the direction with the
// last iterations (L-BFGS), and follows it only as far as the sum decreases (backtracking). Hence the sum never rises,
// every call costs the same, and the same calls give the same bytes.
// Papers: M. Mueller, M. Gross. Interactive virtual materials. Graphics Interface 2004 (corotational). A. McAdams et
//         al. Efficient elasticity for character skinning. ACM TOG 30(4), 2011 (energy). T. Liu, S. Bouaziz, L. Kavan.
//         Quasi-Newton methods for real-time simulation of hyperelastic materials. ACM TOG 36(3), 2017 (iteration).
//         E. Cazes, G. Meschke. An edge-based smoothed finite element method for 3D analysis of solid mechanics
//         problems. Int. J. Numer. Meth. Eng. 94, 2013; J. Bonet, A. Burton. A simple average nodal pressure
//         tetrahedral element. Comm. Numer. Meth. Eng. 14, 1998 (means). J. Nocedal. Math. Comp. 35, 1980 (L-BFGS).
// Units: mm, N; stress in N/mm^2. Frame of the tree.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "spheretree/core/tissue.h"

namespace spheretree::tissue {

class TissueSolver {
 public:
  /// Factorises the stiffness matrix. Returns null, with a sentence in `fault`, if the tissue is unsound or a part of
  /// it has no fixed nodes. Cost: about 60 ms for 700 nodes.
  static std::unique_ptr<TissueSolver> make(const Tissue& tissue, std::string& fault);
  ~TissueSolver();

  /// Runs `iterations` from the last state under `forces` on the nodes [N]; forces on fixed nodes are ignored. Returns
  /// false, and keeps the old state, if a force or the new state is not finite, or if more than 5 % of the tetrahedra
  /// would be inverted. Cost: about 1 ms an iteration for 2,500 tetrahedra. No allocation.
  bool advance(std::span<const Eigen::Vector3d> forces, int iterations) noexcept;

  /// Iterates until no node moves by more than `tolerance` in an iteration [mm]. Also returns false if
  /// `max_iterations` do not suffice.
  bool settle(std::span<const Eigen::Vector3d> forces, double tolerance, int max_iterations) noexcept;

  /// Returns to the shape at rest, without forces.
  void reset() noexcept;

  std::span<const Eigen::Vector3d> displacements() const;  // of all nodes [mm]
  double energy() const;                                   // elastic energy [N mm]
  std::size_t inverted() const;                            // number of inverted tetrahedra
  std::vector<Eigen::Vector3d> elasticForces();            // on the nodes, including the reaction of the fixed nodes [N]

 private:
  struct State;
  explicit TissueSolver(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace spheretree::tissue
