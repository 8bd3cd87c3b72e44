// SPDX-License-Identifier: GPL-3.0-or-later
// How well a soft tree represents its object in deformed states: the figures that `spheretree evaluate --states`
// prints.
// Units: mm.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/tissue.h"
#include "spheretree/core/triangle_mesh.h"
#include "tissue/sample_states.h"

namespace spheretree::builder {

struct StateFigures {
  std::string kind;
  double amount = 0;  // as in TissueState
  StateStrain strain;
  std::size_t bare_samples = 0;       // points of the moved surface outside all leaves; 0 according to the certificate
  std::optional<double> overhang_mm;  // proven bound: no leaf reaches farther out of the moved surface; empty if a tetrahedron is inverted,
                                      // since inside and outside are then undefined
  double largest_radius_mm = 0;       // of the leaves
  std::string fault;                  // findFault() of the moved tree; normally ""
};

struct StatesEvaluation {
  std::size_t leaves = 0, samples = 0;  // samples in each state
  double rest_overhang_mm = 0;          // overhang of the leaves that moveLeaves() computes at rest
  std::vector<StateFigures> states;
};

/// `mesh`: the solid that the tree was built from; its vertices are the first of the tissue's surface. `surface`:
/// everything that the tree covers; its vertices are those of the tissue's surface. `state(i)` returns state i of
/// `count`; it may be called from any thread. Same arguments, same result.
/// Cost: a state takes about 10 ms for 2,000 leaves, 10,000 samples and a mesh of 4,000 triangles.
/// @throws Cancelled
StatesEvaluation evaluateStates(const TriangleMesh& mesh, const TriangleMesh& surface, const SphereTree& tree, const Tissue& tissue,
                                std::size_t count, const std::function<TissueState(std::size_t)>& state, std::size_t samples,
                                std::uint64_t seed, Progress& progress);

}  // namespace spheretree::builder
