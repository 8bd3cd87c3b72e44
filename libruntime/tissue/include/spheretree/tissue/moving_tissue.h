// SPDX-License-Identifier: Apache-2.0
// Soft tissue in large motion, between a solver and the steps of the runtime: forces in, the surface out. For a thread
// of the caller's own; the two sides share nothing but what is handed over.
//
// In a step pressed node i is displaced by  base_i + sum_j C_ij f_j  with the constant compliance C of the rest, which
// is what the QP knows. Here the base is found for which that is the state of the solver, under the forces that it was
// given: base = x(f) - C f. Between two states the steps go on with C. Since it is the compliance of the solver's own
// elements, that is where the next state will be, up to what is of second order.
// Units: mm, N. Frame of the tree.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "spheretree/core/tissue.h"
#include "spheretree/tissue/tissue_solver.h"

namespace spheretree::tissue {

inline constexpr int kIterations = 8;  // of the solver, for each state

struct TissueState {
  std::vector<float> surface;                  // x, y, z of each pressed node, for the runtime's aimTissue(): less what C f says
  std::vector<Eigen::Vector3d> displacements;  // (nodes)
  bool is_frozen = false;                      // the solver was at a loss: this is its last good state
};

class MovingTissue {
 public:
  /// `tissue`, which must have a response, outlives this. Null with a sentence in `fault` if TissueSolver refuses it.
  static std::unique_ptr<MovingTissue> make(const Tissue& tissue, std::string& fault);

  /// At rest, with memory for all that is to come.
  TissueState restState() const;

  /// Goes on from the last state under `forces`: x, y, z of each pressed node. No allocation. The same calls give the
  /// same bytes. Cost: about 8 ms for 2,500 tetrahedra.
  void advance(std::span<const float> forces, TissueState& state) noexcept;

  /// At rest without forces.
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
  // Of the pressed nodes, x, y, z of each.
  std::vector<float> response_;  // what C says of the last good state
  std::vector<float> last_;      // as it was given out last
  std::vector<float> ways_;      // from there to where the last state wanted it
  double part_ = 1;              // of these ways, that was gone
};

}  // namespace spheretree::tissue
