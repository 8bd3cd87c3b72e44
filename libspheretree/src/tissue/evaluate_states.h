// SPDX-License-Identifier: GPL-3.0-or-later
// How a soft tree stands for its object in deformed states: what `spheretree evaluate --states` prints.
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
  std::size_t bare_samples = 0;       // points of the moved surface in no leaf; the certificate says 0
  std::optional<double> overhang_mm;  // no leaf reaches farther out of the moved surface; proven. None where a tetrahedron is inside
                                      // out, since in and out then lose their meaning
  double largest_radius_mm = 0;       // of a leaf
  std::string fault;                  // findFault() of the moved tree; "" as it should be
};

struct StatesEvaluation {
  std::size_t leaves = 0, samples = 0;  // samples of each state
  double rest_overhang_mm = 0;          // of the leaves as moveLeaves() gives them at rest
  std::vector<StateFigures> states;
};

/// `mesh`: the solid that the tree was built from; its vertices are the first of the tissue's surface. `surface`: all
/// of what the tree covers, whose vertices are the tissue's. `state(i)` gives state i of `count`; it is called from any
/// thread. Same arguments, same result.
/// Cost: a state takes about 10 ms for 2,000 leaves, 10,000 samples and a mesh of 4,000 triangles.
/// @throws Cancelled
StatesEvaluation evaluateStates(const TriangleMesh& mesh, const TriangleMesh& surface, const SphereTree& tree, const Tissue& tissue,
                                std::size_t count, const std::function<TissueState(std::size_t)>& state, std::size_t samples,
                                std::uint64_t seed, Progress& progress);

}  // namespace spheretree::builder
