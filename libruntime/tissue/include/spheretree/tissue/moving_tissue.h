// SPDX-License-Identifier: Apache-2.0
// Soft tissue in large motion, between a solver and the steps of the runtime: forces in, leaves out. For a thread of
// the caller's own; the two sides share nothing but what is handed over.
//
// In a step the point of leaf i is displaced by  base_i + sum_j C_ij f_j  with the constant compliance C of the rest,
// which is what the QP knows. Here the base is found for which that is the state of the solver, under the forces that
// it was given: base = x(f) - C f. Between two states the steps go on with C, and with a base that goes with the load
// as it does in the solver's state (core's TissueTangent). So a load that grows or falls as a whole meets the tissue of
// the solver to first order, however late the next state is.
// Leaves hold the whole surface in the solver's state, whatever it is (core's moveLeaves).
// Units: mm, N. Frame of the tree.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "spheretree/core/tissue.h"
#include "spheretree/tissue/tissue_solver.h"

namespace spheretree::tissue {

inline constexpr int kIterations = 8;         // of the solver, for each state
inline constexpr int kTangentIterations = 4;  // for the way of the tissue under its load

struct TissueState {
  std::vector<Sphere> leaves;                  // (leaves) for the runtime's aimTissue(): less what C f says
  std::vector<Eigen::Vector3d> displacements;  // (nodes)
  TissueTangent tangent;                       // beyond what C says
  bool is_frozen = false;                      // the solver was at a loss: this is its last good state
};

class MovingTissue {
 public:
  /// `tissue`, which must have a response, outlives this. Null with a sentence in `fault` if TissueSolver refuses it.
  static std::unique_ptr<MovingTissue> make(const Tissue& tissue, std::string& fault);

  /// At rest, with memory for all that is to come.
  TissueState restState() const;

  /// Goes on from the last state under `forces`: x, y, z of each pressed node, tractions round it (TissueResponse). No
  /// allocation. The same calls give the same bytes. Cost: about 8 ms for 2,500 tetrahedra.
  void advance(std::span<const float> forces, TissueState& state) noexcept;

  /// At rest without forces.
  void reset() noexcept;
  const TissueSolver& solver() const { return *solver_; }

 private:
  MovingTissue(const Tissue& tissue, std::unique_ptr<TissueSolver> solver);
  void makeState(std::span<const float> forces, TissueState& state) noexcept;
  void place(std::span<const Eigen::Vector3d> nodes, std::vector<Eigen::Vector3d>& displacements, std::vector<Sphere>& leaves) noexcept;
  void findTangent(std::span<const float> forces, std::span<const Sphere> leaves) noexcept;
  void predict(std::span<const float> forces) noexcept;
  void relax(std::span<const Sphere> leaves) noexcept;
  Eigen::Vector3d give(std::size_t leaf) const;

  // What a force on a pressed node is on the nodes round it.
  struct Share {
    std::uint32_t pressed, node;
    double weight;
  };

  const Tissue& tissue_;
  std::unique_ptr<TissueSolver> solver_;
  std::vector<Share> shares_;
  std::vector<Eigen::Vector3d> forces_, moved_;      // (nodes) of the last state, and their response to all of its load
  std::vector<Eigen::Vector3d> shifted_, averaged_;  // (nodes) scratch
  std::vector<Eigen::Vector3d> positions_;           // (vertices of the surface) scratch
  std::vector<Sphere> shifted_leaves_;               // (leaves) scratch
  std::vector<float> response_;                      // (pressed) x, y, z: what C says of the last good state
  TissueTangent tangent_;                            // of the last good state
  std::vector<Sphere> rest_, last_;                  // (leaves) at rest, and as they were given out last
  std::vector<Eigen::Vector4f> ways_;                // (leaves) from there to where the last state wanted them
  double part_ = 1;                                  // of these ways, that was gone
};

}  // namespace spheretree::tissue
