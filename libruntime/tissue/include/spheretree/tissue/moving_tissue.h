// SPDX-License-Identifier: Apache-2.0
// Large deformation of soft tissue: connects a solver with the steps of the runtime. Forces go in, the surface comes
// out. It runs in a thread of the caller; the two threads share nothing but the arguments that the caller passes on.
//
// In a step, pressed node i is displaced by  base_i + sum_j C_ij f_j  with the constant compliance C of the shape at
// rest, which the QP uses. This class computes the base for which that sum equals the solver's state x(f) under the
// forces f that it received: base = x(f) - C f. Between two states the steps continue with C. Since C is the compliance
// of the solver's own elements, the result differs from the next state only by terms of second order.
// Units: mm, N. Frame of the tree.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "spheretree/core/tissue.h"
#include "spheretree/tissue/tissue_solver.h"

namespace spheretree::tissue {

inline constexpr int kIterations = 8;  // iterations of the solver for each state

struct TissueState {
  std::vector<float> surface;                  // x, y, z of each pressed node, for the runtime's aimTissue(): x(f) - C f
  std::vector<Eigen::Vector3d> displacements;  // (nodes)
  bool is_frozen = false;                      // the solver failed: this is its last good state
};

class MovingTissue {
 public:
  /// `tissue` must have a response and outlive the object. Returns null, with a sentence in `fault`, if TissueSolver
  /// refuses it.
  static std::unique_ptr<MovingTissue> make(const Tissue& tissue, std::string& fault);

  /// The state at rest, with all memory that advance() needs.
  TissueState restState() const;

  /// Continues from the last state under `forces` (x, y, z of each pressed node). No allocation. The same calls give
  /// the same bytes. Cost: about 8 ms for 2,500 tetrahedra.
  void advance(std::span<const float> forces, TissueState& state) noexcept;

  /// Returns to the shape at rest, without forces.
  void reset() noexcept;
  const TissueSolver& solver() const { return *solver_; }

 private:
  MovingTissue(const Tissue& tissue, std::unique_ptr<TissueSolver> solver);
  void makeState(std::span<const float> forces, TissueState& state) noexcept;
  void relax(std::span<const float> surface) noexcept;
  void takeSurface(std::span<const Eigen::Vector3d> nodes, std::span<float> surface) const noexcept;

  const Tissue& tissue_;
  std::unique_ptr<TissueSolver> solver_;
  std::vector<Eigen::Vector3d> forces_;  // (nodes)
  // For the pressed nodes, x, y, z of each.
  std::vector<float> response_;  // C f of the last good state
  std::vector<float> last_;      // the surface that was returned last
  std::vector<float> ways_;      // from there to the surface of the last state
  double share_ = 1;             // share of these ways that the returned surface covered
};

}  // namespace spheretree::tissue
