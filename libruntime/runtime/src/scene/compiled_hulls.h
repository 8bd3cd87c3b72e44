// SPDX-License-Identifier: Apache-2.0
// The hulls of a tool (core/hulls.h) in the memory layout of the search and of the rows: a search tree over their
// parts, and for each slot the balls of the part.
// Units: mm; frame: axes of the tool, origin at its reference point.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scene/compiled_skin.h"
#include "scene/compiled_tree.h"
#include "spheretree/core/hulls.h"

namespace spheretree::runtime {

/// A part touches a triangle in up to three ways: a ball in its nearest point, a cone at a side, a slab at a
/// corner. The search finds slots of the tree. A pair with a cone or slab then becomes one for each way: their tool
/// slots are slot + way * ways_apart.
struct CompiledHulls {
  CompiledTree tree;
  std::uint32_t ways_apart = 0;      // number of slots of the tree
  std::vector<Sphere> ball;          // (slot of a way) ball 0 of the part; of an inner node: its bounding sphere
  std::vector<Sphere> span1, span2;  // (slot of a way) balls 1 and 2 minus ball 0; 0 if there are none
  std::vector<Sphere> turn0, turn1;  // (slot of a way) of cones: how what is felt of them departs from them (FeltTurns)
  std::vector<std::array<float, 2>> swell;
  // (slot of a way) What is felt departs by at most this from the direction of the axis, for its length, and from the
  // growth of the radius; from the part itself by at most half of it [mm].
  std::vector<float> bend;
  std::vector<std::uint32_t> way;  // (slot of a way); kNoFeltWay: a ball at which one cone continues another
  float smallest_radius = 0;       // of the balls [mm]

  bool empty() const { return ball.empty(); }
};

/// `origin`: origin of the hulls' frame minus the reference point of the tool.
CompiledHulls compileHulls(const Hulls& hulls, const Eigen::Vector3d& origin);

}  // namespace spheretree::runtime
