// SPDX-License-Identifier: Apache-2.0
// Bridges over the ripple of a sphere model: the convex hull of two or three leaves that stand side by side fills the pit between them, so
// that a tool slides over flat facets in place of bumps. In the constrained mode only.
// Where a bridge is: over every corner of the surface of the union of the leaves, which three leaves make, and over the edges between them,
// as far as the pit is no deeper than the overhang that the tree states for its leaves. So a bridge never stands out farther than one more
// overhang, and a narrow groove or a hole stays open.
// Idea: the spheres swept between nodes of a medial mesh; F. Sun, Y.-K. Choi, Y. Yu, W. Wang. Medial meshes. IEEE TVCG 22(3), 2016.
// Units: mm; frame: that of the compiled object (world axes, about the anchor).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace spheretree::runtime {

struct CompiledTree;

/// The hull of three leaves, or of two (slot[2] == slot[1]), with what nearestOnBridge() asks of it.
struct Bridge {
  std::array<std::uint16_t, 3> slot;
  float depth;                            // it stands no higher than this above its own leaves [mm]
  Eigen::Vector3d a;                      // centre of the first leaf
  double radius;                          // of the first leaf
  Eigen::Vector3d up;                     // three: normal of the plane of centres; two: unit vector from the first to the second
  std::array<Eigen::Vector3d, 2> normal;  // three: of the facet on the side of `up`, and on the other
  Eigen::Vector3d along_u, along_v;       // three: weights of the second and third leaf are foot . these
  double length, slope, rise;             // two: between centres; sine and cosine of the cone's normal against `up`
  double spread_u, spread_v;              // how far the weights move, at most, when the ball moves by 1 mm; two: the foot [mm]
  bool isPair() const { return slot[2] == slot[1]; }
};

struct Bridges {
  std::vector<Bridge> all;
  std::vector<std::uint32_t> first;    // (slot + 1) range of `of_slot` for each slot; empty without bridges
  std::vector<std::uint32_t> of_slot;  // indices into `all`, each under all its leaves
  float deepest = 0;                   // largest `depth` [mm]
};

/// Bridges of the leaves of `tree` over pits of at most `most_depth` [mm]; 0: none. Deterministic. A leaf that overlaps more than 256
/// others gets none. Cost: about 0.1 ms a leaf.
Bridges makeBridges(const CompiledTree& tree, double most_depth);

/// The nearest point of a bridge, as a contact: gap of a ball and the hull, and the unit normal from the hull to the ball.
struct BridgeContact {
  Eigen::Vector3d normal;
  double gap;  // [mm]; to the centre of the ball, its radius not yet taken off
};

/// True, and `contact` filled, if the point of the bridge that is nearest to `p` lies between its leaves: on the facet of three, on the
/// line of two. Else a single leaf or a bridge of fewer is the one that touches. Cost: about 10 ns.
bool nearestOnBridge(const Bridge& bridge, const Eigen::Vector3d& p, BridgeContact& contact) noexcept;

/// False only if nearestOnBridge() is false, or its gap above `gap`, for every point within `margin` of `p`.
bool mayTouchBridge(const Bridge& bridge, const Eigen::Vector3d& p, double gap, double margin) noexcept;

}  // namespace spheretree::runtime
