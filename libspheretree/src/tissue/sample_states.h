// SPDX-License-Identifier: GPL-3.0-or-later
// States of tissue to test a soft tree in, from gentle to physically impossible.
// Units: mm.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "spheretree/core/tissue.h"

namespace spheretree::builder {

struct TissueState {
  std::string kind;                            // "squeeze", "poke", "bend", "noise", "inverted", or the source of the state
  double amount = 0;                           // squeeze: share of the length; poke: depth [mm]; bend: angle [rad]; else share of an edge
  std::vector<Eigen::Vector3d> displacements;  // (nodes)
};

/// State `index` of `count`: the kinds alternate, and the amount of each kind grows evenly to its largest value:
/// - squeeze: along a random direction to 30 %, with constant volume;
/// - poke: a dent of up to 5 mm from a random point of the surface inward, at least as wide as it is deep;
/// - bend: the longest side by 60 degrees about a random axis perpendicular to it;
/// - noise: every node moves by up to 20 % of the mean edge;
/// - inverted: every node moves by up to 150 % of the mean edge, so that many tetrahedra are inverted.
/// Fixed nodes move, too, since the proof holds in every state. Same arguments, same state.
TissueState sampleState(const Tissue& tissue, std::size_t index, std::size_t count, std::uint64_t seed);

/// Largest and smallest stretch of a tetrahedron (singular values of its deformation gradient), and the number of
/// inverted tetrahedra.
struct StateStrain {
  double largest_stretch = 1, smallest_stretch = 1;
  std::size_t inverted = 0;
};
StateStrain strainOf(const Tissue& tissue, std::span<const Eigen::Vector3d> displacements);

}  // namespace spheretree::builder
