// SPDX-License-Identifier: Apache-2.0
// Bridges over the ripple of a sphere model: facets and cones over the pits between leaves that stand side by side, so that a tool slides
// over flat ground in place of bumps. In the constrained mode only; the leaves themselves stay as they are.
// Where a bridge is: a large ball (the probe) that rolls over the leaves from outside rests on three of them at a time: their common
// tangent plane makes a facet, and where it tips over two, the cone about both fills the wedge between two facets. This is the reduced
// surface of molecules. The first probe is so large that it rolls over the convex hull: on a flat or round face it rests on the tops alone,
// and where a face is flat but for a small part of the overhang, it is taken as flat (flat_faces.h). Smaller ones pass over what lies low,
// and follow a hollow. A facet or cone is kept if no pit below it is deeper than kDeepestPit (of the first probe: one) overhangs, as the
// tree states them for its leaves: of the whole tree, or of where it has work. So a bridge never stands out farther than that beyond the
// leaves, and what is wider or deeper stays open. A facet must also touch its leaves where they show: one across a groove or a hole touches
// them deep inside others.
//
// Papers: M. F. Sanner, A. J. Olson, J.-C. Spehner. Reduced surface. Biopolymers 38(3), 1996. H. Edelsbrunner, E. P. Muecke.
//         Three-dimensional alpha shapes. ACM TOG 13(1), 1994.
// Units: mm; frame: that of the compiled object (world axes, about the anchor).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "spheretree/core/sphere.h"

namespace spheretree::runtime {

struct Block;
struct BlockLinks;

/// A facet over three leaves or the cone about two, as 4 x 4 floats, which the inner loop transposes. With t = p - a for a point p:
/// Facet: the weights of the second and third leaf at the foot of p are u . t and v . t; gap = axis . t - radius.
/// Cone: p belongs to it where u . t <= 0 and v . t <= 0, and its foot lies between the two.
struct Bridge {
  float a[3], radius;     // the first leaf
  float axis[3], length;  // facet: unit normal, 0; cone: unit vector from the first leaf to the second, distance
  float u[3], u_extra;    // facet: radius of the second leaf less that of the first; cone: slope / rise
  float v[3], v_extra;    // facet: the same of the third; cone: rise, the cosine of its normal against what is across the axis
  bool isCone() const { return length > 0; }
};
static_assert(sizeof(Bridge) == 64);

/// Bridges under a tree of bounding spheres, laid out like a CompiledTree; the bridge of a leaf stands at its slot.
struct BridgeTree {
  std::vector<Block> bound;
  std::vector<BlockLinks> links;
  std::vector<Bridge> of_slot;
  Sphere root{};
  std::size_t count = 0;
};

inline constexpr std::size_t kMostBridges = 32768;  // of a tree
inline constexpr double kDeepestPit = 1.25;         // below a bridge, in overhangs: over a hollow a facet is a chord

/// Bridges of `leaves`, which reach out of the object by at most `overhang` [mm], 0 or less: none; if `is_uneven`, some farther, and those
/// are passed over. Then turned by `rotation`, so that they are the same ones however the object stands. Beyond kMostBridges the last ones
/// found are left out: there the bumps are felt. Deterministic. Cost: about 60 us a leaf; twice that where
/// faces are flat, up to four times if uneven.
BridgeTree makeBridges(std::span<const Sphere> leaves, double overhang, bool is_uneven, const Eigen::Matrix3d& rotation);

/// Weights and angles may be beyond their range by this, so that rounding leaves no slit between a facet and its neighbours.
inline constexpr float kBridgeSlack = 1e-4f;

/// A ball beside a facet, and farther above its plane than this, has the plane ahead of it [mm].
inline constexpr float kClearOfFacet = 1e-3f;

/// The deepest that a ball dips below a bridge on which it came down [mm]: what rows let it, and a little more. One that is deeper came
/// from the side, below a rim that hangs free, and the bridge is not there for it.
inline constexpr float kDeepestDip = 0.02f;

}  // namespace spheretree::runtime
