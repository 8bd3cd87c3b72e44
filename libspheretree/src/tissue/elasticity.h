// SPDX-License-Identifier: GPL-3.0-or-later
// Linear elasticity on tetrahedra, for small deformations: K u = f, with the same elements as the solver for large
// deformations (spheretree/tissue/rest_stiffness.h). Plain linear elements are far too stiff in bending and at nearly
// constant volume.
// Units: mm, N. Deterministic.
#pragma once

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <span>
#include <utility>
#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/tissue.h"
#include "tissue/tetrahedra.h"

namespace spheretree::builder {

class Elasticity {
 public:
  /// Assembles and factorises. `is_fixed`: one for each node. Cost: about 1 s of one core for 3,000 tetrahedra.
  /// @throws BuildError if a connected part could move freely, because it does not have three fixed corners that are
  /// not collinear; Cancelled.
  Elasticity(const Tetrahedra& solid, const TissueMaterial& material, std::span<const char> is_fixed, Progress& progress);

  bool isFixed(std::uint32_t node) const { return free_[node] < 0; }

  /// Displacements of all nodes [mm] under `forces` on them [N]. A fixed node is displaced by its entry in
  /// `prescribed`, or not at all if `prescribed` is empty. All arrays have one entry a node.
  std::vector<Eigen::Vector3d> displacements(std::span<const Eigen::Vector3d> forces,
                                             std::span<const Eigen::Vector3d> prescribed = {}) const;

  /// Unknowns: three for each free node. `unknown(node)` is the first unknown of a node, or -1.
  std::size_t unknowns() const { return static_cast<std::size_t>(stiffness_.rows()); }
  std::int32_t unknown(std::uint32_t node) const { return free_[node]; }
  /// K^-1 f for several right-hand sides at once: row i contains unknown i of all of them. May be called from any
  /// number of threads.
  void solve(Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>& columns) const;

 private:
  void assemble(const Eigen::SparseMatrix<double>& all);

  std::vector<std::int32_t> free_;          // first unknown of each node, -1: fixed
  std::vector<std::int32_t> fixed_column_;  // column of a fixed node in coupling_; -1: free
  Eigen::SparseMatrix<double> stiffness_;   // of the unknowns, lower half [N/mm]
  Eigen::SparseMatrix<double> coupling_;    // unknowns x coordinates of fixed nodes
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
};

}  // namespace spheretree::builder
