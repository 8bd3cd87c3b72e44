// SPDX-License-Identifier: GPL-3.0-or-later
// Linear elasticity on tetrahedra, for small motion: K u = f.
//
// Quadratic elements (ten nodes: corners and middles of the edges), since linear ones are far too stiff where tissue
// bends or keeps its volume: a bar of four of them across is off by a fifth, of two quadratic ones by a hundredth.
// Text: T. J. R. Hughes. The Finite Element Method, Dover 2000, chapters 2 and 3. Integrals by the four-point rule of
//       P. C. Hammer, A. H. Stroud, Math. Comp. 10, 1956, which is exact here: strains are linear in an element.
// Units: mm, N; stress in N/mm^2 (= 1000 kPa). Deterministic.
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

/// The nodes of quadratic elements: the corners as they are, then the middle of each edge.
struct QuadraticNodes {
  std::vector<Eigen::Vector3d> position;                         // [mm]
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;    // (middles) its ends, the lower first; ascending
  std::vector<std::array<std::uint32_t, 10>> of_element;         // corners 0..3, then middles 01, 02, 03, 12, 13, 23
  std::uint32_t middle(std::uint32_t a, std::uint32_t b) const;  // of an edge that exists
};
QuadraticNodes quadraticNodes(const Tetrahedra& solid);

class Elasticity {
 public:
  /// Assembles and factorises. `is_fixed`: one for each corner node; the middle of an edge is fixed if both ends are.
  /// Cost: about 2 s of one core for 3,000 tetrahedra.
  /// @throws BuildError if a connected part has no three fixed corners out of line and could float away; Cancelled.
  Elasticity(const Tetrahedra& solid, const TissueMaterial& material, std::span<const char> is_fixed, Progress& progress);

  const QuadraticNodes& nodes() const { return nodes_; }
  bool isFixed(std::uint32_t node) const { return free_[node] < 0; }

  /// Displacements of all nodes [mm] under `forces` on them [N]; a fixed node is displaced by what `prescribed` says,
  /// or stays if that is empty. All of length nodes().position.size().
  std::vector<Eigen::Vector3d> displacements(std::span<const Eigen::Vector3d> forces,
                                             std::span<const Eigen::Vector3d> prescribed = {}) const;

  /// Unknowns: three for each free node. `unknown(node)` is the first of a node, or -1.
  std::size_t unknowns() const { return static_cast<std::size_t>(stiffness_.rows()); }
  std::int32_t unknown(std::uint32_t node) const { return free_[node]; }
  /// K^-1 f for several right-hand sides at once: row i holds unknown i of all of them. Any number of threads may call.
  void solve(Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>& columns) const;

 private:
  void assemble(const Tetrahedra& solid, const TissueMaterial& material, Progress& progress);

  QuadraticNodes nodes_;
  std::vector<std::int32_t> free_;          // first unknown of a node, -1: fixed
  std::vector<std::int32_t> fixed_column_;  // of a fixed node, in coupling_; -1: free
  Eigen::SparseMatrix<double> stiffness_;   // of the unknowns, lower half [N/mm]
  Eigen::SparseMatrix<double> coupling_;    // unknowns x coordinates of fixed nodes
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
};

}  // namespace spheretree::builder
