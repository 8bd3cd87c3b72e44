// SPDX-License-Identifier: Apache-2.0
// Large motion of soft tissue: the shape at rest under forces, where tetrahedra turn and stretch. No inertia, no time:
// what is found is the minimum of   elastic energy(u) - f . u   over the displacements u of the nodes.
//
// Energy per volume: mu |F - R|^2 + lambda / 2 (J - 1)^2, F the deformation gradient, R its rotation, J the volume
// ratio. F is a mean over the tetrahedra round an edge and J one over those round a node, since plain linear tetrahedra
// are far too stiff where tissue bends or keeps its volume (the tests have figures). A tetrahedron of less than 30 % of
// its volume has an energy of its own, which grows as the square of what it lacks: it is not turned inside out.
// Each iteration solves with the matrix of the shape at rest, factorised once, improves its direction by what the last
// iterations taught (L-BFGS), and goes along it only as far as the sum falls (backtracking): the sum never rises, every
// call costs the same, and the same calls give the same bytes.
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
  /// Factorises. Null with a sentence in `fault` if the tissue is unsound or a part of it is not held by fixed nodes.
  /// Cost: about 60 ms for 700 nodes.
  static std::unique_ptr<TissueSolver> make(const Tissue& tissue, std::string& fault);
  ~TissueSolver();

  /// Goes on from the last state for `iterations` under `forces` on the nodes [N]; those on fixed nodes do not count.
  /// False, with the state as it was, if a force or the new state is not finite, or more than 5 % of the tetrahedra
  /// would be inside out. Cost: about 1 ms an iteration for 2,500 tetrahedra. No allocation.
  bool advance(std::span<const Eigen::Vector3d> forces, int iterations) noexcept;

  /// Goes on until no node moves by more than `tolerance` in an iteration [mm]. False, too, if `most_iterations` did
  /// not get there.
  bool settle(std::span<const Eigen::Vector3d> forces, double tolerance, int most_iterations) noexcept;

  /// At rest without forces.
  void reset() noexcept;

  std::span<const Eigen::Vector3d> displacements() const;  // of all nodes [mm]
  double energy() const;                                   // elastic [N mm]
  std::size_t inverted() const;                            // tetrahedra inside out
  double lastMove() const;                                 // of the node that moved most in the last iteration [mm]
  std::vector<Eigen::Vector3d> elasticForces();            // on the nodes, what holds fixed ones included [N]

 private:
  struct State;
  explicit TissueSolver(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace spheretree::tissue
