// SPDX-License-Identifier: GPL-3.0-or-later
// States of tissue to try a soft tree in: from the gentle to the impossible.
// Units: mm.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "spheretree/core/tissue.h"

namespace spheretree::builder {

struct TissueState {
  std::string kind;                            // "squeeze", "poke", "bend", "noise", "inverted", or where it comes from
  double amount = 0;                           // squeeze: share of the length; poke: depth [mm]; bend: angle [rad]; else share of an edge
  std::vector<Eigen::Vector3d> displacements;  // (nodes)
};

/// State `index` of `count`: the kinds take turns, and each grows evenly to its largest amount:
/// - squeeze along a random direction to 30 %, with the volume kept;
/// - poke: a dent of up to 5 mm from a random point of the surface inward, as wide as it is deep, and wider;
/// - bend of the longest side by 60 degrees about a random axis across it;
/// - noise: every node moves by up to 20 % of the mean edge;
/// - inverted: every node moves by up to 150 % of it, so that many tetrahedra are inside out.
/// Nodes that the file calls fixed move, too: the proof holds in every state. Same arguments, same state.
TissueState sampleState(const Tissue& tissue, std::size_t index, std::size_t count, std::uint64_t seed);

/// Largest and smallest stretch of a tetrahedron (singular values of its deformation gradient), and how many are inside
/// out.
struct StateStrain {
  double largest_stretch = 1, smallest_stretch = 1;
  std::size_t inverted = 0;
};
StateStrain strainOf(const Tissue& tissue, std::span<const Eigen::Vector3d> displacements);

}  // namespace spheretree::builder
